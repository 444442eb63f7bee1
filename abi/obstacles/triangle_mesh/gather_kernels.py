"""Triangles around a segment, gathered once for many short segments there.

A descent of the tree costs more than looking at a few triangles, and for most segments the planes
of the triangles already show that they are far. Plain Python that numba compiles with its caller.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.compilation.jitable import jitable
from abi.obstacles.triangle_mesh.bvh import TriangleTree, box_of
from abi.obstacles.triangle_mesh.segment_kernels import inverse_of, stretch_in
from abi.obstacles.triangle_mesh.triangle_kernels import THIN, segment_to_triangle
from abi.obstacles.vector_kernels import Triangle, Vec3, cross, dot, sub, triangle_at

_MOST = 96  # with more, descents are quicker


class Gathered(NamedTuple):
    """Arrays for the triangles around a segment.

    Attributes:
        numbers: (``_MOST``,) their places in the tree.
        planes: x, y and z of unit normals and the planes' products with these, (4, ``_MOST``); 0
            where a triangle is too thin to have a plane.
        boxes: x, y and z of the low corners of the boxes around them, then of the high ones,
            (6, ``_MOST``).
        beside: (``_MOST``,) room for distances.
    """

    numbers: IntArray
    planes: FloatArray
    boxes: FloatArray
    beside: FloatArray


@jitable
def no_triangles() -> Gathered:
    """Arrays for the triangles around a segment."""
    rows = np.empty((4, _MOST)), np.empty((6, _MOST))
    return Gathered(np.empty(_MOST, np.int32), *rows, np.empty(_MOST))


@jitable
def gather(
    tree: TriangleTree,
    segment: tuple[Vec3, Vec3],
    reach: float,
    doubt: float,
    gathered: Gathered,
    waiting: IntArray,
) -> int:
    """Gather the triangles that come within reach of the segment from p to q, and maybe others.

    Args:
        tree: over the triangles.
        segment: p and q, which may be the same.
        reach: distance, with room for rounding.
        doubt: bound of the error of a distance to a triangle's plane.
        gathered: written.
        waiting: room for ``DEPTH`` nodes.

    Returns:
        Their number, or -1 where there is no room for all.
    """
    _, leaves, corners, _, _ = tree
    inner = len(leaves) - 2
    p, q = segment
    inverse = inverse_of(sub(q, p))
    away = reach + doubt
    waiting[0] = 0
    waits, count = 1, 0
    while waits > 0:
        waits -= 1
        node = waiting[waits]
        low, high = box_of(tree, node)
        if stretch_in(p, inverse, low, high, reach) < 0.0:
            continue
        if node < inner:
            waiting[waits], waiting[waits + 1] = 2 * node + 1, 2 * node + 2
            waits += 2
            continue
        for number in range(leaves[node - inner], leaves[node - inner + 1]):
            triangle = triangle_at(corners, number)
            low, high = _box_around(triangle)
            if stretch_in(p, inverse, low, high, reach) < 0.0:
                continue
            normal, level = _plane_of(triangle)
            at_p, at_q = dot(normal, p) - level, dot(normal, q) - level
            if min(at_p, at_q) > away or max(at_p, at_q) < -away:
                continue
            for axis in range(3):
                gathered.planes[axis, count] = normal[axis]
                gathered.boxes[axis, count], gathered.boxes[3 + axis, count] = low[axis], high[axis]
            gathered.planes[3, count], gathered.numbers[count] = level, number
            count += 1
            if count == _MOST:
                return -1
    return count


@jitable
def comes_near_gathered(
    tree: TriangleTree,
    gathered: Gathered,
    count: int,
    segment: tuple[Vec3, Vec3],
    limit: float,
    doubt: float,
) -> bool:
    """Check whether a segment comes as near to one of the triangles gathered as a limit.

    Args:
        tree: over the triangles.
        gathered, count: what :func:`gather` found.
        segment: its ends.
        limit: distance, at least 0.
        doubt: bound of the error of a distance to a triangle's plane.
    """
    p, q = segment
    away = limit + doubt
    beside = gathered.beside
    _fill_beside(gathered, count, p, q)
    for k in range(count):
        if beside[k] > away:
            continue
        triangle = triangle_at(tree.corners, gathered.numbers[k])
        if segment_to_triangle(p, q, triangle) <= limit * limit:
            return True
    return False


@jitable
def _fill_beside(gathered: Gathered, count: int, p: Vec3, q: Vec3) -> None:
    """Write lower bounds of the segment's distances to triangles, by their planes and boxes.

    Without branches, so that several are computed at a time.
    """
    planes, boxes, beside = gathered.planes, gathered.boxes, gathered.beside
    low = (min(p[0], q[0]), min(p[1], q[1]), min(p[2], q[2]))
    high = (max(p[0], q[0]), max(p[1], q[1]), max(p[2], q[2]))
    for k in range(count):
        x, y, z, level = planes[0, k], planes[1, k], planes[2, k], planes[3, k]
        at_p = x * p[0] + y * p[1] + z * p[2] - level
        at_q = x * q[0] + y * q[1] + z * q[2] - level
        across = max(boxes[0, k] - high[0], low[0] - boxes[3, k])
        aside = max(boxes[1, k] - high[1], low[1] - boxes[4, k])
        above = max(boxes[2, k] - high[2], low[2] - boxes[5, k])
        beside[k] = max(min(at_p, at_q), -max(at_p, at_q), across, aside, above)


@jitable
def _plane_of(triangle: Triangle) -> tuple[Vec3, float]:
    """Unit normal of a triangle, and the plane's product with it; 0 of one that is thin."""
    a, b, c = triangle
    ab, ac, bc = sub(b, a), sub(c, a), sub(c, b)
    n = cross(ab, ac)
    nn = dot(n, n)
    longest = max(dot(ab, ab), dot(ac, ac), dot(bc, bc))
    if nn <= THIN * THIN * longest * longest:
        return (0.0, 0.0, 0.0), 0.0
    size = math.sqrt(nn)
    n = (n[0] / size, n[1] / size, n[2] / size)
    return n, dot(n, a)


@jitable
def _box_around(triangle: Triangle) -> tuple[Vec3, Vec3]:
    """Lowest and highest corner of the box around a triangle."""
    a, b, c = triangle
    return (
        (min(a[0], b[0], c[0]), min(a[1], b[1], c[1]), min(a[2], b[2], c[2])),
        (max(a[0], b[0], c[0]), max(a[1], b[1], c[1]), max(a[2], b[2], c[2])),
    )
