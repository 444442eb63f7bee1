"""A curve that was fitted, with the clearance it keeps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

from abi.clearance.bezier import PolynomialCurve
from abi.clearance.curve_clearance import ROUNDING, Clearance, prove
from abi.obstacles.obstacle_set import ObstacleSet

CurveT = TypeVar("CurveT", bound=PolynomialCurve)

_FINEST = 1e-6  # of the curve's extent


@dataclass(frozen=True, eq=False)
class Fit(Generic[CurveT]):
    """A fitted curve and how clear of the obstacles it is.

    Attributes:
        curve: the curve.
        clearance: its distance to the obstacles, proven where it can be.
        asked: distance it should keep from every obstacle, [unit].
        note: why it is not the curve that was asked for, as a sentence; empty when it is.
    """

    curve: CurveT
    clearance: Clearance
    asked: float
    note: str = ""

    @property
    def holds(self) -> bool:
        """Whether it is proven that the curve keeps the distance asked for."""
        return self.clearance.keeps(self.asked)


def finest(extent: float) -> float:
    """Distance to which the clearance of a curve of such an extent is known, [unit]."""
    return _FINEST * extent + ROUNDING


def proven(curve: CurveT, extent: float, obstacles: ObstacleSet, asked: float) -> Fit[CurveT]:
    """Fit of a curve whose clearance is measured to a millionth of its extent, and proven.

    Args:
        curve: the curve.
        extent: its size, [unit].
        obstacles: what it should keep clear of.
        asked: distance it should keep from every obstacle, at least 0, [unit].
    """
    return Fit(curve, prove(curve, obstacles, asked, finest(extent)), asked)
