"""Points of Bézier curves, and their subdivision by de Casteljau's algorithm.

Plain Python that numba compiles with its caller; uncompiled it runs on lists. A point is three
successive numbers.
"""

from __future__ import annotations

from abi.arrays import FloatArray
from abi.compilation.jitable import jitable
from abi.obstacles.vector_kernels import Vec3, vec3_at

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
