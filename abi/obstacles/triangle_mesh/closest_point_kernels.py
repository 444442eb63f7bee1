"""The triangle nearest to a point, by a bounding volume hierarchy.

Plain Python that numba compiles with its caller.
"""

from __future__ import annotations

import math

from numba.extending import register_jitable

from abi.arrays import FloatArray, IntArray
from abi.obstacles.triangle_mesh.bvh import TriangleTree
from abi.obstacles.triangle_mesh.triangle_kernels import (
    closest_point,
    point_to_box,
    point_to_triangle,
    triangle_at,
)
from abi.obstacles.vector_kernels import Vec3, dot, norm, sub

DEPTH = 64
"""Room for the nodes that wait in a descent: one at each level of a tree, and there are fewer."""


@register_jitable
def nearest_triangle(
    tree: TriangleTree,
    x: Vec3,
    most: float,
    slack: float,
    waiting: IntArray,
    squares: FloatArray,
) -> tuple[float, int]:
    """Distance of x to the nearest triangle, and the triangle's place in the tree.

    Depth first, the nearer child first (Roussopoulos, Kelley and Vincent, 1995).

    Args:
        tree: over the triangles.
        x: a point.
        most: a distance; where no triangle is nearer the outcome is this, and -1.
        slack: the outcome may be above the distance by as much.
        waiting, squares: room for ``DEPTH`` nodes and their squared distances.
    """
    boxes, leaves, corners, _ = tree
    inner = len(leaves) - 2
    square, best, found = most * most, most, -1
    normal, level = (0.0, 0.0, 0.0), -math.inf
    # what is farther than this is passed over
    limit = square
    waiting[0], squares[0] = 0, point_to_box(x, boxes, 0)
    count = 1
    while count > 0:
        count -= 1
        if squares[count] >= limit:
            continue
        node = waiting[count]
        while node < inner:
            near, far = 2 * node + 1, 2 * node + 2
            to_near, to_far = point_to_box(x, boxes, near), point_to_box(x, boxes, far)
            if to_far < to_near:
                near, far, to_near, to_far = far, near, to_far, to_near
            if to_far < limit:
                waiting[count], squares[count] = far, to_far
                count += 1
            node = near
            if to_near >= limit:
                break
        if node < inner or point_to_box(x, boxes, node) >= limit:
            continue
        before = found
        for number in range(leaves[node - inner], leaves[node - inner + 1]):
            a, b, c = triangle = triangle_at(corners, number)
            # wholly beyond the plane across the way to the closest point so far
            if level >= max(dot(normal, a), dot(normal, b), dot(normal, c)):
                continue
            distance = point_to_triangle(x, triangle, square)
            if distance < square:
                square, found = distance, number
        if found == before:
            continue
        best = math.sqrt(square)
        normal = sub(x, closest_point(x, triangle_at(corners, found)))
        level = dot(normal, x) - best * norm(normal) * (1.0 + 1e-12)
        limit = square if slack == 0.0 else max(best - slack, 0.0) ** 2
    return best, found
