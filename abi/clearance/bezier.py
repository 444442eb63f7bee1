"""Bézier pieces of a curve, on which clearance is measured and certified."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from abi.arrays import FloatArray


class PolynomialCurve(Protocol):
    """A continuous curve in space that is a polynomial between its breaks."""

    def bezier(self) -> Bezier:
        """Bézier points of the curve's polynomials."""


@dataclass(frozen=True, eq=False)
class Bezier:
    """A curve of s polynomials, each by its Bézier points, which hold it in their convex hull.

    Attributes:
        breaks: parameters between the polynomials, increasing, shape (s + 1,).
        points: shape (s, degree + 1, 3), [unit], world.
        size: the points' errors are at most 16·degree·2^-53 times this, [unit]; at least the
            largest coordinate.
    """

    breaks: FloatArray
    points: FloatArray
    size: float

    @property
    def degree(self) -> int:
        """Degree of each polynomial."""
        return int(self.points.shape[1]) - 1

    def bezier(self) -> Bezier:
        """The pieces themselves."""
        return self
