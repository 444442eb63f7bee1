"""Curves, solids and directions in exact rational numbers, for :mod:`abi.verify.verify`.

Shares no arithmetic with the rest of the package, on purpose. Square roots, which are not rational,
are bounded from both sides.
"""

from __future__ import annotations

import bisect
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Vec3 = tuple[Fraction, Fraction, Fraction]

_DIGITS = 100
"""Binary digits to which roots are bounded."""


def vector(numbers: Sequence[float]) -> Vec3:
    """Three floating-point numbers, exactly."""
    x, y, z = map(Fraction, numbers)
    return x, y, z


def dot(a: Vec3, b: Vec3) -> Fraction:
    """a·b, reduced once and not at each step."""
    above, below = 0, 1
    for one, other in zip(a, b, strict=True):
        part = one.denominator * other.denominator
        above = above * part + one.numerator * other.numerator * below
        below *= part
    return Fraction(above, below)


def sub(a: Vec3, b: Vec3) -> Vec3:
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def sqrt_bounds(square: Fraction) -> tuple[Fraction, Fraction]:
    """Bounds of the square root of a number >= 0, which differ by at most 2^-100 of it."""
    whole = square.numerator * square.denominator  # the root of p / q is the root of p q, over q
    shift = max(0, _DIGITS + 1 - whole.bit_length() // 2)
    below = math.isqrt(whole << 2 * shift)
    above = below + (below * below != whole << 2 * shift)
    scale = square.denominator << shift
    return Fraction(below, scale), Fraction(above, scale)


def in_body(v: Vec3, wxyz: Sequence[float]) -> Vec3:
    """World vector in the body frame of a quaternion of any length but zero, exactly."""
    x, y, z = _axes(tuple(wxyz))
    return dot(x, v), dot(y, v), dot(z, v)


@lru_cache(maxsize=1024)
def _axes(wxyz: tuple[float, ...]) -> tuple[Vec3, Vec3, Vec3]:
    """Axes of the body in the world."""
    w, x, y, z = map(Fraction, wxyz)
    s = 1 / (w * w + x * x + y * y + z * z)
    return (
        (s * (w * w + x * x - y * y - z * z), s * 2 * (x * y + w * z), s * 2 * (x * z - w * y)),
        (s * 2 * (x * y - w * z), s * (w * w - x * x + y * y - z * z), s * 2 * (y * z + w * x)),
        (s * 2 * (x * z + w * y), s * 2 * (y * z - w * x), s * (w * w - x * x - y * y + z * z)),
    )


@dataclass(frozen=True)
class ExactSolid:
    """Minkowski sum of a box, a disc across the body's z and a ball, placed in the world.

    Attributes:
        half: half sizes of the box, [unit].
        disc: radius of the disc, [unit].
        ball: radius of the ball, [unit].
        position: of the centre, [unit], world.
        wxyz: rotation as a quaternion of any length but zero.
    """

    half: Vec3
    disc: Fraction
    ball: Fraction
    position: Vec3
    wxyz: tuple[float, float, float, float]

    @property
    def depth(self) -> Fraction:
        """Distance from the centre to the surface, [unit]."""
        across = min(self.half[:2]) + self.disc
        return min(across, self.half[2]) + self.ball

    def separated(self, normal: Vec3, least: Fraction, margin: Fraction) -> bool:
        """Test whether all x with normal·x >= ``least`` are farther than ``margin`` from the solid.

        The normal need not be of length 1.
        """
        x, y, z = in_body(normal, self.wxyz)
        support = dot(normal, self.position)
        support += abs(x) * self.half[0] + abs(y) * self.half[1] + abs(z) * self.half[2]
        support += self.disc * sqrt_bounds(x * x + y * y)[1] if self.disc else 0
        return least - support > times_length(self.ball + margin, normal)


@dataclass(frozen=True)
class ExactFloor:
    """All points at a height or below, [unit]."""

    height: Fraction

    def separated(self, normal: Vec3, least: Fraction, margin: Fraction) -> bool:
        """Check whether a normal, which must point straight up, separates the floor."""
        x, y, z = normal
        return not (x or y) and z > 0 and least > z * (self.height + margin)


class MovedHull(NamedTuple):
    """All points within ``radius`` of a hull in the frame of a joint, -1 for the world."""

    link: str
    frame: int
    points: tuple[Vec3, ...]
    radius: Fraction


LinkPiece = tuple[MovedHull, ...]
"""A piece of a link: what is common to some hulls, such as a capsule and a hull that is closer."""


def times_length(factor: Fraction, normal: Vec3) -> Fraction:
    """Upper bound of a factor times the length of a normal."""
    below, above = sqrt_bounds(dot(normal, normal))
    return factor * (above if factor > 0 else below)


@dataclass(frozen=True, eq=False)
class ExactSpan:
    """A polynomial of a curve, from one parameter to another.

    Attributes:
        start, end: the parameters.
        bezier: its Bézier points there, one more than its degree.
    """

    start: Fraction
    end: Fraction
    bezier: Sequence[Vec3]

    def points(self, start: Fraction, end: Fraction) -> list[Vec3]:
        """Bézier points of the polynomial on [start, end]."""
        rows, unit = self._whole
        degree, width = len(rows) - 1, self.end - self.start
        shares = (start - self.start) / width, (end - self.start) / width
        # in whole numbers, which need no common factors taken out after each step
        whole = math.lcm(*(share.denominator for share in shares))
        a, b = (share.numerator * (whole // share.denominator) for share in shares)
        unit *= whole**degree
        points: list[Vec3] = []
        for _ in range(degree + 1):
            left = rows
            while len(left) > 1:
                left = (whole - a) * left[:-1] + a * left[1:]
            x, y, z = left[0]
            points.append((Fraction(x, unit), Fraction(y, unit), Fraction(z, unit)))
            if start == end:
                return points * (degree + 1)
            rows = (whole - b) * rows[:-1] + b * rows[1:]
        return points

    @cached_property
    def _whole(self) -> tuple[NDArray[np.object_], int]:
        """The Bézier points times a number that makes them whole, (n, 3), and that number."""
        unit = math.lcm(*(part.denominator for point in self.bezier for part in point))
        return np.array([[int(unit * part) for part in p] for p in self.bezier], object), unit


ExactCurve = Sequence[ExactSpan]
"""Polynomials of one degree, each from where the one before ends."""


def exact_spline(degree: int, knots: Sequence[Fraction], points: Sequence[Vec3]) -> ExactCurve:
    """A B-spline.

    Args:
        degree: of the polynomials.
        knots: not decreasing.
        points: the control points, one fewer than ``knots`` less the degree.
    """
    spans = []
    for k in range(degree, len(points)):
        start, end = knots[k], knots[k + 1]
        if start < end:
            arguments = ([start] * (degree - j) + [end] * j for j in range(degree + 1))
            bezier = [_blossom(knots, points[k - degree : k + 1], k, one) for one in arguments]
            spans.append(ExactSpan(start, end, bezier))
    return spans


def exact_quadratic(start: Fraction, end: Fraction, c0: Vec3, c1: Vec3, c2: Vec3) -> ExactSpan:
    """The quadratic c0 + c1·t + c2·t² from one parameter to another."""
    bezier = [
        (
            c0[0] + c1[0] * (a + b) / 2 + c2[0] * a * b,
            c0[1] + c1[1] * (a + b) / 2 + c2[1] * a * b,
            c0[2] + c1[2] * (a + b) / 2 + c2[2] * a * b,
        )
        for a, b in ((start, start), (start, end), (end, end))
    ]
    return ExactSpan(start, end, bezier)


def hull(curve: ExactCurve, start: Fraction, end: Fraction) -> list[Vec3]:
    """Points whose convex hull contains the curve from ``start`` to ``end``."""
    points: list[Vec3] = []
    first = bisect.bisect_right(curve, start, key=attrgetter("end"))
    for span in itertools.islice(curve, first, None):
        a, b = max(span.start, start), min(span.end, end)
        if a >= b:
            break
        points += _points(span, a, b)
    return points


@lru_cache(maxsize=4096)
def _points(span: ExactSpan, start: Fraction, end: Fraction) -> list[Vec3]:
    return span.points(start, end)


def _blossom(
    knots: Sequence[Fraction], control: Sequence[Vec3], span: int, arguments: Sequence[Fraction]
) -> Vec3:
    """Blossom of a spline's polynomial: de Boor's algorithm with an argument for each step.

    Args:
        knots: of the spline.
        control: control points of the polynomial, one more than its degree.
        span: number of the knot it begins at.
        arguments: as many as the degree.
    """
    degree, points = len(arguments), list(control)
    for level, at in enumerate(arguments, start=1):
        for i in range(degree, level - 1, -1):
            first, last = knots[span - degree + i], knots[span + i + 1 - level]
            share = (at - first) / (last - first)
            x, y, z = ((1 - share) * points[i - 1][k] + share * points[i][k] for k in range(3))
            points[i] = x, y, z
    return points[degree]
