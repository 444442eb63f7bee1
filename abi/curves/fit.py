"""A fitted curve together with its clearance and its arc length."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Generic, TypeVar

from abi.arrays import FloatArray, ShortRepr
from abi.curves.clearance.curve_clearance import ROUNDING, Clearance, proven_clearance
from abi.curves.curve import ArcLength, Curve, arc_length
from abi.obstacles.obstacle_set import ObstacleSet

CurveT = TypeVar("CurveT", bound=Curve)

_TOLERANCE = 1e-6  # of the curve's extent


@dataclass(frozen=True, eq=False, repr=False)
class Fit(ShortRepr, Generic[CurveT]):
    """A fitted curve, its clearance and its arc length.

    Attributes:
        curve: the curve.
        clearance: its distance to the obstacles, proven where it can be.
        required: distance to keep from every obstacle, [unit].
        note: sentence on why it is not the curve that the mode asks for; empty if it is.
    """

    curve: CurveT
    clearance: Clearance
    required: float
    note: str = ""

    @cached_property
    def arc(self) -> ArcLength:
        """Arc length of the curve."""
        return arc_length(self.curve)

    def at_share(self, share: FloatArray) -> FloatArray:
        """Points (n, 3) of the curve at shares (n,) of its arc length, [unit], world."""
        return self.curve(self.arc.parameter(share * self.arc.length))

    @property
    def holds(self) -> bool:
        """Whether it is proven that the curve keeps the required distance."""
        return self.clearance.keeps(self.required)


def clearance_tolerance(extent: float) -> float:
    """Tolerance of the clearance of a curve of this extent, [unit]."""
    return _TOLERANCE * extent + ROUNDING


def proven_fit(
    curve: CurveT, extent: float, obstacles: ObstacleSet, required: float
) -> Fit[CurveT]:
    """Fit of a curve with its clearance, measured to a millionth of its extent and proven.

    Args:
        curve: the curve.
        extent: its size, [unit].
        obstacles: to keep clear of.
        required: distance to keep from every obstacle, at least 0, [unit].
    """
    clearance = proven_clearance(curve, obstacles, required, clearance_tolerance(extent))
    return Fit(curve, clearance, required)
