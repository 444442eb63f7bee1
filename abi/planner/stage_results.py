"""What stages 5 and 6 give: a curve of either kind, and a motion along it."""

from __future__ import annotations

from typing import Literal, NamedTuple, TypeAlias

from abi.arm_planning.motion.arm_clearance import ArmClearance, is_clear
from abi.arm_planning.motion.trajectory import ArmMotion
from abi.curves.bspline import BSpline
from abi.curves.cubic_profile import PathProfile
from abi.curves.fit import Fit
from abi.curves.quadratic import Quadratic

AnyFit: TypeAlias = Fit[BSpline] | Fit[Quadratic]
CurveName: TypeAlias = Literal["bspline", "quadratic"]


class TimedMotion(NamedTuple):
    """Result of stage 6: the motion along the curve, the joints over time, and their clearance."""

    profile: PathProfile
    motion: ArmMotion
    clearance: ArmClearance

    @property
    def is_clear(self) -> bool:
        """Whether the whole arm is proven clear all along it, in reach and range."""
        return is_clear(self.motion, self.clearance)
