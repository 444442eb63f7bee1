"""The triangle nearest to a point, by a bounding volume hierarchy.

Plain Python that numba compiles with its caller.
"""

from __future__ import annotations

import math

from abi.arrays import FloatArray, IntArray
from abi.compilation.jitable import jitable
from abi.obstacles.triangle_mesh.bvh import TriangleTree, highest_in_slab
from abi.obstacles.triangle_mesh.triangle_kernels import (
    closest_point,
    point_to_triangle,
    triangle_at,
)
from abi.obstacles.vector_kernels import Vec3, dot, norm, point_to_box, sub, vec3_at

DEPTH = 64
"""Room for the nodes that wait in a descent: one at each level of a tree, and there are fewer."""


@jitable
def _plane_of(tree: TriangleTree, x: Vec3, number: int, away: float) -> tuple[Vec3, float, float]:
    """The plane through the point of a triangle nearest to x, across the way from it to x.

    Returns:
        The way; its product with the points of the plane; and what rounding may add to it.
    """
    normal = sub(x, closest_point(x, triangle_at(tree.corners, number)))
    level = dot(normal, x) - away * norm(normal) * (1.0 + 1e-12)
    return normal, level, 1e-12 * (tree.size + away) * away


@jitable(forceinline=True)
def _is_beyond(tree: TriangleTree, node: int, x: Vec3, limit: float) -> bool:
    """Check whether the slab of a node is farther from x than a squared distance."""
    k = 5 * node
    height = dot(vec3_at(tree.slabs, k), x)
    beside = max(height - tree.slabs[k + 3], tree.slabs[k + 4] - height)
    beside -= 1e-12 * (tree.size + abs(height))
    beyond: bool = beside > 0.0 and beside * beside >= limit
    return beyond


@jitable
def nearest_triangle(
    tree: TriangleTree,
    x: Vec3,
    most: float,
    slack: float,
    waiting: IntArray,
    squares: FloatArray,
    guess: int = -1,
) -> tuple[float, int]:
    """Distance of x to the nearest triangle, and the triangle's place in the tree.

    Depth first, the nearer child first (Roussopoulos, Kelley and Vincent, 1995).

    Args:
        tree: over the triangles.
        x: a point.
        most: a distance; where no triangle is nearer the outcome is this, and -1.
        slack: the outcome may be above the distance by as much.
        waiting, squares: room for ``DEPTH`` nodes and their squared distances.
        guess: place of a triangle that may be the nearest, or -1: what is beyond it is then passed
            over from the first.
    """
    boxes, leaves, corners, _, _ = tree
    inner = len(leaves) - 2
    square, best, found = most * most, most, -1
    normal, level = (0.0, 0.0, 0.0), -math.inf
    doubt = 0.0
    if guess >= 0:
        distance = point_to_triangle(x, triangle_at(corners, guess), square)
        if distance < square:
            square, best, found = distance, math.sqrt(distance), guess
            normal, level, doubt = _plane_of(tree, x, found, best)
    # what is farther than this is passed over
    limit = square if slack == 0.0 or found < 0 else max(best - slack, 0.0) ** 2
    waiting[0], squares[0] = 0, point_to_box(x, boxes, 0)
    count = 1
    while count > 0:
        count -= 1
        node = waiting[count]
        if squares[count] >= limit or _is_beyond(tree, node, x, limit):
            continue
        while node < inner:
            near, far = 2 * node + 1, 2 * node + 2
            to_near, to_far = point_to_box(x, boxes, 6 * near), point_to_box(x, boxes, 6 * far)
            if to_far < to_near:
                near, far, to_near, to_far = far, near, to_far, to_near
            if to_far < limit:
                waiting[count], squares[count] = far, to_far
                count += 1
            node = near
            if to_near >= limit:
                break
        if node < inner or point_to_box(x, boxes, 6 * node) >= limit:
            continue
        if _is_beyond(tree, node, x, limit):
            continue
        if found >= 0 and highest_in_slab(tree, node, normal) + doubt < level:
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
        normal, level, doubt = _plane_of(tree, x, found, best)
        limit = square if slack == 0.0 else max(best - slack, 0.0) ** 2
    return best, found
