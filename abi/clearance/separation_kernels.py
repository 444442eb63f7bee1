"""Pieces of a curve, and the planes that separate them: shared by the kernels that certify.

Plain Python that numba compiles with its caller; uncompiled it runs on lists. A point is three
successive numbers of a flat array; a piece of the curve is a run of such points that holds the
curve's stretch in its convex hull.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable

from abi.arrays import FloatArray
from abi.obstacles.vector_kernels import Vec3, dot, vec3_at

CERTIFIED, REFUTED, UNDECIDED = 0, 1, 2
MOST_HALVINGS = 48
"""Of one polynomial: it is then finer than any distance worth deciding."""
FINEST = 2.0**-36
"""Pieces smaller than this part of the largest coordinate are not halved."""

_UNIT = 2.0**-53
TINY = 1e-140  # squares of anything smaller lose digits


class Piece(NamedTuple):
    """A stretch of the curve.

    Attributes:
        first: point with which it begins.
        last: point before which it ends.
        halvings: how often its polynomial was halved; 0 of several.
        start: first parameter.
        end: last parameter.
    """

    first: int
    last: int
    halvings: int
    start: float
    end: float


class Plane(NamedTuple):
    """A plane between a piece of the curve and an obstacle.

    Attributes:
        start: first parameter of the piece.
        end: last parameter.
        obstacle: index.
        direction: unit normal, from the obstacle to the curve.
        level: its least product with the piece, [unit].
    """

    start: float
    end: float
    obstacle: int
    direction: Vec3
    level: float


NO_PLANE = Plane(0.0, 0.0, 0, (0.0, 0.0, 0.0), 0.0)
"""With which a list of planes begins, so that its type is known."""

Outcome = tuple[int, float, int, float, FloatArray]
"""What was decided, then the parameter, obstacle and distance of the place where it was not
certified, then the planes found (k, 7)."""


@register_jitable
def table_of(planes: list[Plane]) -> FloatArray:
    """The planes as rows, but for the first, which means nothing."""
    table = np.empty((len(planes) - 1, 7))
    for i in range(1, len(planes)):
        plane, row = planes[i], table[i - 1]
        row[0], row[1], row[2] = plane.start, plane.end, plane.obstacle
        row[3], row[4], row[5] = plane.direction
        row[6] = plane.level
    return table


@register_jitable
def allowance_of(scale: float, degree: int, halvings: int, margin: float) -> float:
    """What rounding can take from a separation, [unit]: see ``abi.clearance.certificate``."""
    return _UNIT * ((256 + 16 * degree + 12 * degree * halvings) * scale + 64 * abs(margin))


@register_jitable
def halves_of(piece: Piece, width: int, spans: int, at: float) -> tuple[Piece, Piece]:
    """Both halves of a piece: the first point of the second is in the middle of the piece.

    A run of polynomials is divided between two of them. For the halves of one polynomial there is
    room behind the points, at each number of halvings for two; :func:`halve` fills it.

    Args:
        piece: the piece.
        width: points of a polynomial.
        spans: number of polynomials.
        at: parameter at which it is divided.
    """
    if piece.last - piece.first > width:
        first, last, halvings = piece.first, piece.last, 0
        middle = (first + last) // width // 2 * width
    else:
        first, halvings = (spans + 2 * piece.halvings) * width, piece.halvings + 1
        middle, last = first + width, first + 2 * width
    ahead = Piece(first, middle, halvings, piece.start, at)
    return ahead, Piece(middle, last, halvings, at, piece.end)


@register_jitable
def halve(points: FloatArray, piece: Piece, left: int, at: float) -> None:
    """De Casteljau: both halves of a piece of one polynomial, at the points from ``left`` on."""
    width = piece.last - piece.first
    ratio = (at - piece.start) / (piece.end - piece.start)
    right = left + width
    for i in range(3 * width):
        points[3 * right + i] = points[3 * piece.first + i]
    for level in range(width):
        for k in range(3):
            points[3 * (left + level) + k] = points[3 * right + k]
        for i in range(3 * right, 3 * (right + width - 1 - level)):
            points[i] = (1 - ratio) * points[i] + ratio * points[i + 3]


@register_jitable
def least_product(points: FloatArray, first: int, last: int, direction: Vec3) -> float:
    """Least product of a direction with the points from ``first`` up to ``last``."""
    least = math.inf
    for i in range(3 * first, 3 * last, 3):
        level = dot(direction, vec3_at(points, i))
        if level < least:
            least = level
    return least


@register_jitable
def extent_of(points: FloatArray, first: int, last: int) -> tuple[Vec3, Vec3]:
    """Low and high corner of the box around the points from ``first`` up to ``last``."""
    x0, y0, z0 = vec3_at(points, 3 * first)
    x1, y1, z1 = x0, y0, z0
    for i in range(3 * first + 3, 3 * last, 3):
        x0, x1 = min(x0, points[i]), max(x1, points[i])
        y0, y1 = min(y0, points[i + 1]), max(y1, points[i + 1])
        z0, z1 = min(z0, points[i + 2]), max(z1, points[i + 2])
    return (x0, y0, z0), (x1, y1, z1)
