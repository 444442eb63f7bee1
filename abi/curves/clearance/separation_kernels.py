"""Bézier pieces of a curve and the planes that separate them, shared by all kernels that certify.

Plain Python that numba compiles with its caller; uncompiled it runs on lists. A point is three
successive numbers of a flat array; a piece of the curve is a run of such points, whose convex
hull contains that stretch of the curve. De Casteljau's algorithm divides it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from abi.arrays import FloatArray
from abi.compilation.jitable import jitable
from abi.obstacles.vector_kernels import Vec3, dot, vec3_at

# inlined: calls for each piece of a curve, in which lists and arrays would be counted in and out
_inlined = jitable(forceinline=True)

Numbers = FloatArray | list[float]


@_inlined
def divide(
    points: Numbers, piece: int, into: Numbers, left: int, right: int, width: int, share: float
) -> None:
    """De Casteljau: both parts of a curve, divided at a share of it.

    Args:
        points: the curve's are the ``width`` ones from ``points[piece]`` on.
        piece: index.
        into: takes the parts, from ``into[left]`` and ``into[right]`` on; written.
        left, right: indices.
        width: points of the curve.
        share: in (0, 1).
    """
    for i in range(3 * width):
        into[right + i] = points[piece + i]
    for order in range(width):
        for k in range(3):
            into[left + 3 * order + k] = into[right + k]
        for i in range(right, right + 3 * (width - 1 - order)):
            into[i] = (1 - share) * into[i] + share * into[i + 3]


@_inlined
def extent_of(points: Numbers, start: int, stop: int) -> tuple[Vec3, Vec3]:
    """Low and high corner of the box around the points in ``points[start:stop]``."""
    x0, y0, z0 = vec3_at(points, start)
    x1, y1, z1 = x0, y0, z0
    for i in range(start + 3, stop, 3):
        x0, x1 = min(x0, points[i]), max(x1, points[i])
        y0, y1 = min(y0, points[i + 1]), max(y1, points[i + 1])
        z0, z1 = min(z0, points[i + 2]), max(z1, points[i + 2])
    return (x0, y0, z0), (x1, y1, z1)


CERTIFIED, REFUTED, UNDECIDED = 0, 1, 2
FINEST = 2.0**-36
"""Pieces smaller than this part of the largest coordinate are not halved."""

UNIT = 2.0**-53
"""Largest rounding error of one operation, as a part of its result."""
PER_SIZE = 128
"""Rounding of a separation, in units of ``UNIT`` times the coordinates: what is always there."""
PER_DEGREE = 16
"""The same for each degree: of the Bézier points."""
PER_HALVING = 12
"""The same for each degree and halving."""
PER_MARGIN = 64
"""The same in units of ``UNIT`` times the margin: normals are nearly of length 1."""
TINY = 2.0**-510
"""Length from which on a direction can be trusted: squares of shorter ones lose digits."""


class SeparatingPlane(NamedTuple):
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


NO_PLANE = SeparatingPlane(0.0, 0.0, 0, (0.0, 0.0, 0.0), 0.0)
"""First of every list of planes, so that its type is known."""

Outcome = tuple[int, float, int, float, FloatArray]
"""The decision; parameter, obstacle and distance of the place that is not certified; the planes
(k, 7)."""


@jitable
def table_of(planes: list[SeparatingPlane]) -> FloatArray:
    """The planes as rows (k, 7), without the first, which means nothing."""
    table = np.empty((len(planes) - 1, 7))
    for i in range(1, len(planes)):
        plane, row = planes[i], table[i - 1]
        row[0], row[1], row[2] = plane.start, plane.end, plane.obstacle
        row[3], row[4], row[5] = plane.direction
        row[6] = plane.level
    return table


@jitable
def allowance_of(scale: float, degree: int, halvings: int, margin: float) -> float:
    """Rounding error of a separation, [unit]: see ``abi.curves.clearance.certificate``."""
    per_scale = PER_SIZE + (PER_DEGREE + PER_HALVING * halvings) * degree
    return UNIT * (per_scale * scale + PER_MARGIN * abs(margin))


@jitable
def apart_along_axis(low: Vec3, high: Vec3, extent: tuple[Vec3, Vec3]) -> tuple[float, Vec3]:
    """Distance along an axis from a box low..high to that around a piece, and the direction.

    A long piece that passes a face obliquely is behind that face all the same.
    """
    (x0, y0, z0), (x1, y1, z1) = extent
    gx = max(x0 - high[0], low[0] - x1)
    gy = max(y0 - high[1], low[1] - y1)
    gz = max(z0 - high[2], low[2] - z1)
    gap = max(gx, gy, gz)
    if gz == gap:
        return gap, (0.0, 0.0, 1.0 if z0 - high[2] == gap else -1.0)
    if gx == gap:
        return gap, (1.0 if x0 - high[0] == gap else -1.0, 0.0, 0.0)
    return gap, (0.0, 1.0 if y0 - high[1] == gap else -1.0, 0.0)


@jitable
def least_product(points: FloatArray, first: int, last: int, direction: Vec3) -> float:
    """Least product of a direction with the points from ``first`` up to ``last``."""
    least = math.inf
    for i in range(3 * first, 3 * last, 3):
        level = dot(direction, vec3_at(points, i))
        if level < least:
            least = level
    return least
