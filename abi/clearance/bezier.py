"""Curves as Bézier pieces: what certificates are made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from abi.arrays import FloatArray, flat, read_only
from abi.curves import bspline_kernels as kernels
from abi.curves.curve import Curve
from abi.obstacles.memory import ByIdentity


class SplineCurve(Curve, Protocol):
    """A B-spline given by knots and control points."""

    @property
    def knots(self) -> FloatArray:
        """Shape (n + degree + 1,), not decreasing."""

    @property
    def control_points(self) -> FloatArray:
        """Shape (n, 3), [unit], world."""


class PiecesCurve(Curve, Protocol):
    """Quadratics side by side."""

    @property
    def pieces(self) -> Sequence[tuple[float, float, FloatArray]]:
        """First and last parameter of each and its rows c0, c1, c2 (3, 3), [unit]."""


PolynomialCurve = SplineCurve | PiecesCurve
"""What can be certified."""


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
        """Of each polynomial."""
        return int(self.points.shape[1]) - 1


@ByIdentity
def bezier(curve: PolynomialCurve) -> Bezier:
    """Bézier points of a spline or of quadratics.

    Args:
        curve: has ``knots`` and ``control_points``, or ``pieces``.
    """
    if hasattr(curve, "pieces"):
        return _from_powers(curve.pieces)
    return _from_spline(curve.knots, curve.control_points, curve.degree)


def polyline(points: FloatArray) -> Bezier:
    """Polyline on [0, k - 1], its vertices (k, 3) at the whole parameters; k >= 1, [unit]."""
    given = np.array(points, dtype=float)
    vertices = given if len(given) > 1 else np.repeat(given, 2, axis=0)
    breaks = np.arange(len(vertices), dtype=float)
    pieces = np.stack([vertices[:-1], vertices[1:]], axis=1)
    return Bezier(read_only(breaks), read_only(pieces), float(np.abs(vertices).max()))


def _from_spline(knots: FloatArray, control_points: FloatArray, degree: int) -> Bezier:
    """Insert every knot until it occurs ``degree`` times.

    Bézier point j of the polynomial on [a, b] is the blossom at a, degree - j times, and b, j
    times (Ramshaw, Blossoms are polar forms, 1989, section 6). De Boor's recursion for it takes
    convex combinations only, so errors do not grow.
    """
    most = len(control_points) - degree
    breaks, points = np.empty(most + 1), np.empty(3 * most * (degree + 1))
    spline = flat(knots), flat(control_points), degree
    count = kernels.bezier(*spline, breaks, points)
    pieces = points.reshape(most, degree + 1, 3)[:count]
    size = float(np.abs(control_points).max())
    return Bezier(read_only(breaks[: count + 1]), read_only(pieces), size)


def _from_powers(pieces: Sequence[tuple[float, float, FloatArray]]) -> Bezier:
    start = np.array([piece[0] for piece in pieces])
    end = np.array([piece[1] for piece in pieces])
    coefficients = np.array([piece[2] for piece in pieces])
    # the blossom of c0 + c1 t + c2 t² at (a, a), (a, b), (b, b)
    blossom = np.ones((len(pieces), 3, 3))
    blossom[:, :, 1] = np.stack([start, (start + end) / 2, end], axis=1)
    blossom[:, :, 2] = np.stack([start * start, start * end, end * end], axis=1)
    points = blossom @ coefficients
    size = float((np.abs(blossom).max(axis=1, keepdims=True) @ np.abs(coefficients)).max())
    return Bezier(read_only(np.append(start, end[-1:])), read_only(points), size)
