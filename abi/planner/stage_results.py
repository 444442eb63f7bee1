"""What stages give of which there is more than one part."""

from __future__ import annotations

from typing import Literal, NamedTuple, TypeAlias

from abi.arm_planning.motion.arm_clearance import ArmClearance, is_clear
from abi.arm_planning.motion.trajectory import ArmMotion
from abi.curves.bspline import BSpline
from abi.curves.cubic_profile import PathProfile
from abi.curves.fit import Fit
from abi.curves.quadratic import Quadratic
from abi.search.graph import Graph
from abi.search.search import SearchResult

AnyFit: TypeAlias = Fit[BSpline] | Fit[Quadratic]
CurveName: TypeAlias = Literal["bspline", "quadratic"]


class ShortestPath(NamedTuple):
    """Result of stage 3.

    Attributes:
        graph: in which it was found: that of stage 2, without edges that turned out not to be free.
        path: result of the search that the scene chooses.
        clearance: distance of the path to the obstacles, [unit].
    """

    graph: Graph
    path: SearchResult
    clearance: float


class TimedMotion(NamedTuple):
    """Result of stage 6: the motion along the curve, the joints over time, and their clearance."""

    profile: PathProfile
    motion: ArmMotion
    clearance: ArmClearance

    @property
    def is_clear(self) -> bool:
        """Whether the whole arm is proven clear all along it, in reach and range."""
        return is_clear(self.motion, self.clearance)
