"""What the certificates share: pieces of a curve, and the planes that separate them.

Plain Python that numba compiles with its caller; uncompiled it runs on lists. A point is three
successive numbers of a flat array; a piece of the curve is a run of such points that holds the
curve's stretch in its convex hull.
"""

from __future__ import annotations

import math

import numpy as np
from numba.extending import register_jitable

from abi.arrays import FloatArray

CERTIFIED, REFUTED, UNDECIDED = 0, 1, 2
MOST_HALVINGS = 48
"""Of one polynomial: it is then finer than any distance worth deciding."""

_UNIT = 2.0**-53
TINY = 1e-140  # squares of anything smaller lose digits

Plane = tuple[float, float, int, float, float, float, float]
"""First and last parameter, obstacle, direction x, y, z, and its least product with the piece."""

Outcome = tuple[int, float, int, float, FloatArray]
"""What was decided, then the parameter, obstacle and distance of the place where it was not
certified, then the planes found (k, 7)."""


@register_jitable
def table_of(planes: list[Plane]) -> FloatArray:
    """The planes as rows, but for the first, which means nothing."""
    table = np.empty((len(planes) - 1, 7))
    for i in range(1, len(planes)):
        start, end, obstacle, x, y, z, level = planes[i]
        row = table[i - 1]
        row[0], row[1], row[2] = start, end, obstacle
        row[3], row[4], row[5], row[6] = x, y, z, level
    return table


@register_jitable
def allowance_of(scale: float, degree: int, halvings: int, margin: float) -> float:
    """What rounding can take from a separation, [unit]: see ``abi.clearance.certificate``."""
    return _UNIT * ((256 + 16 * degree + 12 * degree * halvings) * scale + 64 * abs(margin))


@register_jitable
def halve(points: FloatArray, piece: int, left: int, right: int, width: int, ratio: float) -> None:
    """De Casteljau: the two parts, divided at ``ratio``, of the Bézier piece at point ``piece``."""
    for i in range(3 * width):
        points[3 * right + i] = points[3 * piece + i]
    for level in range(width):
        for k in range(3):
            points[3 * (left + level) + k] = points[3 * right + k]
        for i in range(3 * right, 3 * (right + width - 1 - level)):
            points[i] = (1 - ratio) * points[i] + ratio * points[i + 3]


@register_jitable
def least_product(points: FloatArray, first: int, last: int, x: float, y: float, z: float) -> float:
    """Least product of a direction with the points from ``first`` up to ``last``."""
    least = math.inf
    for i in range(3 * first, 3 * last, 3):
        level = x * points[i] + y * points[i + 1] + z * points[i + 2]
        if level < least:
            least = level
    return least


@register_jitable
def extent_of(
    points: FloatArray, first: int, last: int
) -> tuple[float, float, float, float, float, float]:
    """Low and high corner of the box around the points from ``first`` up to ``last``."""
    x0, y0, z0 = points[3 * first], points[3 * first + 1], points[3 * first + 2]
    x1, y1, z1 = x0, y0, z0
    for i in range(3 * first + 3, 3 * last, 3):
        x0, x1 = min(x0, points[i]), max(x1, points[i])
        y0, y1 = min(y0, points[i + 1]), max(y1, points[i + 1])
        z0, z1 = min(z0, points[i + 2]), max(z1, points[i + 2])
    return x0, y0, z0, x1, y1, z1
