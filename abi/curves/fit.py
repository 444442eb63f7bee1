"""A fitted curve together with its clearance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

from abi.arrays import ShortRepr
from abi.curves.clearance.bezier import PolynomialCurve
from abi.curves.clearance.curve_clearance import ROUNDING, Clearance, proven_clearance
from abi.obstacles.obstacle_set import ObstacleSet

CurveT = TypeVar("CurveT", bound=PolynomialCurve)

_TOLERANCE = 1e-6  # of the curve's extent


@dataclass(frozen=True, eq=False, repr=False)
class Fit(ShortRepr, Generic[CurveT]):
    """A fitted curve and its clearance.

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
