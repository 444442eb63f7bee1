"""Bézier pieces of a curve, on which its length and its clearance are measured."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from abi import arguments
from abi.arrays import FloatArray, ShortRepr, read_only
from abi.errors import ArgumentError

_ROUNDED = 1e-12


@dataclass(frozen=True, eq=False, repr=False)
class Bezier(ShortRepr):
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

    def __post_init__(self) -> None:
        breaks = arguments.increasing("breaks", self.breaks)
        points = arguments.numbers("points", self.points, (len(breaks) - 1, -1, 3))
        if points.shape[1] < 2:
            raise ArgumentError("points of each polynomial", points.shape[1], "2 or more")
        # the size may have been rounded otherwise than the points
        least = (1 - _ROUNDED) * float(np.abs(points).max())
        size = arguments.number("size", self.size, least)
        arguments.keep(self, breaks=breaks, points=points, size=size)

    @property
    def degree(self) -> int:
        """Degree of each polynomial."""
        return int(self.points.shape[1]) - 1

    def bezier(self) -> Bezier:
        """This curve itself, as :class:`abi.curves.curve.Curve` gives its pieces."""
        return self

    def chords(self, count: int) -> tuple[FloatArray, float]:
        """Points along each polynomial, and how far the curve is from the lines between them.

        Args:
            count: parts of each polynomial, at equal steps of its parameter.

        Returns:
            Points (s, count + 1, 3) and a bound, both [unit], but for rounding. A chord over a
            step h is at most h² max abs(B'') / 8 away, and B'' is within the second differences of
            the Bézier points, times degree (degree - 1).
        """
        count = arguments.integer("count", count, 1, arguments.LARGEST_ID)
        p = self.degree
        bend = np.linalg.norm(np.diff(self.points, n=2, axis=1), axis=2).max(initial=0.0)
        return _bernstein(p, count) @ self.points, float(p * (p - 1) * bend / (8 * count**2))


@lru_cache(maxsize=16)
def _bernstein(degree: int, count: int) -> FloatArray:
    """Bernstein polynomials at equal steps from 0 to 1, shape (count + 1, degree + 1)."""
    t, i = np.linspace(0.0, 1.0, count + 1)[:, None], np.arange(degree + 1)
    binomials = np.array([math.comb(degree, k) for k in range(degree + 1)], dtype=float)
    return read_only(binomials * t**i * (1 - t) ** (degree - i))
