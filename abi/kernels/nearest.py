"""Nearest places on triangles by a tree of boxes, compiled by numba."""

from __future__ import annotations

import math

import numpy as np
from numba.extending import register_jitable

from abi.arrays import FloatArray, IntArray, read_only
from abi.kernels.compiling import compiled
from abi.kernels.triangles import over
from abi.kernels.vectors import Vector, along, cross, dot, less, point


@register_jitable
def _shorter(way: Vector, side: Vector, best: Vector) -> Vector:
    """Of ``best`` and the way to x from the nearest place on a side, which starts ``way`` from x.

    The side may have no length.
    """
    length = dot(side, side)
    t = min(max(dot(way, side) / length, 0.0), 1.0) if length > 0.0 else 0.0
    found = along(way, side, -t)
    return found if dot(found, found) < dot(best, best) else best


@register_jitable
def _way(x: Vector, a: Vector, b: Vector, c: Vector) -> Vector:
    """From the nearest place on a triangle, which may be degenerate, to x."""
    ab, bc, ca = less(b, a), less(c, b), less(a, c)
    n = cross(ab, bc)
    nn = dot(n, n)
    if nn > 0.0 and over(x, a, b, c, n):
        return along((0.0, 0.0, 0.0), n, dot(n, less(x, a)) / nn)
    way = _shorter(less(x, a), ab, less(x, a))
    way = _shorter(less(x, b), bc, way)
    return _shorter(less(x, c), ca, way)


@register_jitable
def _to_box(x: Vector, low: FloatArray, high: FloatArray, i: int) -> float:
    """Squared distance of x to a box, 0 inside."""
    squared = 0.0
    for k in range(3):
        gap = max(low[i + k] - x[k], x[k] - high[i + k], 0.0)
        squared += gap * gap
    return squared


@compiled()
def nearest_places(
    low: FloatArray,
    high: FloatArray,
    leaves: IntArray,
    corners: FloatArray,
    points: FloatArray,
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Ways from the nearest places of all triangles in a tree to points.

    The triangle nearest to the last point is tried first: of points in order it often is again.

    Args:
        low: lowest corners of the boxes, flat, see :mod:`abi.surfaces.triangle_tree`.
        high: highest corners.
        leaves: where the triangles of each leaf begin, and the end of the last.
        corners: of the triangles, flat.
        points: (n, 3).

    Returns:
        distance (n,); way (n, 3) from the nearest place to the point; nearest triangle (n,), in
        the order of the tree.
    """
    distances, ways = np.empty(len(points)), np.empty((len(points), 3))
    triangles = np.empty(len(points), np.int32)
    inner = len(leaves) - 2
    stack = np.empty(128, np.int32)
    bounds = np.empty(128)
    chosen = 0
    for i in range(len(points)):
        x = point(points[i], 0)
        way = _way(
            x, point(corners, chosen), point(corners, chosen + 3), point(corners, chosen + 6)
        )
        best = dot(way, way)
        stack[0] = 0
        bounds[0] = _to_box(x, low, high, 0)
        waiting = 1
        while waiting > 0:
            waiting -= 1
            box = stack[waiting]
            if bounds[waiting] >= best:
                continue
            if box >= inner:
                for t in range(9 * leaves[box - inner], 9 * leaves[box - inner + 1], 9):
                    other = _way(x, point(corners, t), point(corners, t + 3), point(corners, t + 6))
                    squared = dot(other, other)
                    if squared < best:
                        best, way, chosen = squared, other, t
                continue
            near, far = 2 * box + 1, 2 * box + 2
            to_near, to_far = _to_box(x, low, high, 3 * near), _to_box(x, low, high, 3 * far)
            if to_far < to_near:
                near, far = far, near
                to_near, to_far = to_far, to_near
            stack[waiting], bounds[waiting] = far, to_far
            stack[waiting + 1], bounds[waiting + 1] = near, to_near
            waiting += 2
        distances[i] = math.sqrt(best)
        ways[i, 0], ways[i, 1], ways[i, 2] = way
        triangles[i] = chosen // 9
    return distances, ways, triangles


def warm() -> None:
    """Compile the kernel, or load it from numba's cache."""
    leaves, corners = read_only(np.array([0, 1], dtype=np.int32)), read_only(np.zeros(9))
    box = read_only(np.zeros(3))
    nearest_places(box, box, leaves, corners, np.ones((1, 3)))
