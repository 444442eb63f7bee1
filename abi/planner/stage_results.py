"""What stages 4 and 5 give: a curve of either kind, and its name."""

from __future__ import annotations

from typing import Literal, TypeAlias

from abi.curves.bspline import BSpline
from abi.curves.fit import Fit
from abi.curves.quadratic import Quadratic

AnyFit: TypeAlias = Fit[BSpline] | Fit[Quadratic]
CurveName: TypeAlias = Literal["bspline", "quadratic"]
