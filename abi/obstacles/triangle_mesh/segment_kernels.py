"""Distances of segments to the triangles of a tree.

Plain Python that numba compiles with its caller.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from abi.arrays import FloatArray, IntArray
from abi.compilation.jitable import jitable
from abi.obstacles.triangle_mesh.bvh import TriangleTree, box_of, highest, highest_in_slab
from abi.obstacles.triangle_mesh.triangle_kernels import (
    clamp,
    closest_point,
    nearest_triangle,
    on_side,
    segment_to_triangle,
)
from abi.obstacles.vector_kernels import Triangle, Vec3, add, axpy, dot, norm, sub, triangle_at

_TRIES = 4  # steps towards the nearest triangle, until it is the same again


class Way(NamedTuple):
    """A segment on its way through a tree.

    Attributes:
        first: its first end.
        inverse: what :func:`inverse_of` gives for it.
        normal: a direction, of a length up to 1.
        along: its second end less the first.
        per_square: 1 over the square of its length.
        doubt: bound of the error of its distance to the middle of a box, by rounding.
    """

    first: Vec3
    inverse: Vec3
    normal: Vec3
    along: Vec3
    per_square: float
    doubt: float


@jitable
def inverse_of(d: Vec3) -> Vec3:
    """1 over each component; a component that is 0 counts as next to nothing."""
    x, y, z = d
    tiny = 1e-300
    return (
        1.0 / (x if x != 0.0 else tiny),
        1.0 / (y if y != 0.0 else tiny),
        1.0 / (z if z != 0.0 else tiny),
    )


@jitable(forceinline=True)
def stretch_in(p: Vec3, inverse: Vec3, low: Vec3, high: Vec3, limit: float) -> float:
    """Part of a segment in a box that is widened by a limit; below 0 where it passes by.

    The slab method (Kay and Kajiya, 1986).

    Args:
        p: first end.
        inverse: 1 over the components of the second end less the first.
        low, high: corners of the box.
        limit: distance.
    """
    # written out: a loop over the axes takes half as long again
    a, b = (low[0] - limit - p[0]) * inverse[0], (high[0] + limit - p[0]) * inverse[0]
    c, d = (low[1] - limit - p[1]) * inverse[1], (high[1] + limit - p[1]) * inverse[1]
    e, f = (low[2] - limit - p[2]) * inverse[2], (high[2] + limit - p[2]) * inverse[2]
    first = max(max(min(a, b), min(c, d)), max(min(e, f), 0.0))
    last = min(min(max(a, b), max(c, d)), min(max(e, f), 1.0))
    return last - first


@jitable
def near_triangle(
    tree: TriangleTree, p: Vec3, q: Vec3, limit: float, normal: Vec3, waiting: IntArray
) -> int:
    """A triangle as near to the segment from p to q as a limit: its place, or -1.

    A node is passed over where the segment passes by its box, widened by the limit, or is higher
    above it than the limit, and so is a triangle. The child with more of the segment comes first,
    for the first triangle found ends the descent.

    Args:
        tree: over the triangles.
        p, q: ends of the segment, which may be the same.
        limit: distance, at least 0.
        normal: about the way from the triangles to the segment, or 0; of a length up to 1.
        waiting: room for ``DEPTH`` nodes.
    """
    _, leaves, corners, _, _ = tree
    inner = len(leaves) - 2
    way = _way(tree, p, sub(q, p), normal)
    level = min(dot(normal, p), dot(normal, q)) - limit
    nearest, at = math.inf, 0.5
    waiting[0] = 0
    count = 1
    while count > 0:
        node, count = _next_leaf(tree, way, limit, level, waiting, count)
        if node < 0:
            continue
        for number in range(leaves[node - inner], leaves[node - inner + 1]):
            a, b, c = triangle = triangle_at(corners, number)
            if max(dot(normal, a), dot(normal, b), dot(normal, c)) < level:
                continue
            low = (min(a[0], b[0], c[0]), min(a[1], b[1], c[1]), min(a[2], b[2], c[2]))
            high = (max(a[0], b[0], c[0]), max(a[1], b[1], c[1]), max(a[2], b[2], c[2]))
            if stretch_in(p, way.inverse, low, high, limit) < 0.0:
                continue
            square = segment_to_triangle(p, q, triangle)
            if square <= limit * limit:
                return number
            if square < nearest:
                # beyond its plane there is little when it is the nearest of all
                nearest = square
                at, normal = _way_from(triangle, p, way.along, at)
                way = _way(tree, p, way.along, normal)
                level = min(dot(normal, p), dot(normal, q)) - limit
    return -1


@jitable
def _way_from(triangle: Triangle, p: Vec3, d: Vec3, t: float) -> tuple[float, Vec3]:
    """Place on the segment p + t d nearest to a triangle, about, and the way to it: a unit vector.

    Goes to and fro between both from the place t on.
    """
    way = (0.0, 0.0, 0.0)
    for _ in range(_TRIES):
        closest = closest_point(axpy(t, d, p), triangle)
        t = on_side(closest, p, d)
        way = sub(axpy(t, d, p), closest)
    size = norm(way) * (1.0 + 1e-12)
    if size > 0.0:
        way = (way[0] / size, way[1] / size, way[2] / size)
    return t, way


@jitable
def _way(tree: TriangleTree, p: Vec3, d: Vec3, normal: Vec3) -> Way:
    """The segment from p to p + d on its way through a tree."""
    doubt = 1e-12 * (tree.size + norm(d))
    return Way(p, inverse_of(d), normal, d, 1.0 / max(dot(d, d), 1e-300), doubt)


@jitable
def _next_leaf(
    tree: TriangleTree, way: Way, limit: float, level: float, waiting: IntArray, count: int
) -> tuple[int, int]:
    """The leaf below the last node that waits where most of a segment may be near, or -1.

    And how many wait then.

    Args:
        tree: over the triangles.
        way: the segment.
        limit: distance.
        level: what is nowhere as far along the direction is not near.
        waiting, count: nodes still to look at, and how many; those passed on the way join them.
    """
    inner = len(tree.leaves) - 2
    count -= 1
    node = waiting[count]
    if _stretch_near(tree, node, way, limit, level) < 0.0:
        return -1, count
    while 0 <= node < inner:
        near, far = 2 * node + 1, 2 * node + 2
        in_near = _stretch_near(tree, near, way, limit, level)
        in_far = _stretch_near(tree, far, way, limit, level)
        if in_far > in_near:
            near, far, in_near, in_far = far, near, in_far, in_near
        if in_far >= 0.0:
            waiting[count] = far
            count += 1
        node = near if in_near >= 0.0 else -1
    return node, count


@jitable(forceinline=True)
def _stretch_near(tree: TriangleTree, node: int, way: Way, limit: float, level: float) -> float:
    """Part of a segment that may be near to the box of a node; below 0 where none is.

    A box that is widened reaches farther at its edges than the limit, so the ball around the box
    counts, too.
    """
    p, inverse, normal, d, per_square, doubt = way
    low, high = box_of(tree, node)
    if highest(normal, low, high) < level:
        return -1.0
    stretch = stretch_in(p, inverse, low, high, limit)
    if stretch < 0.0:
        return stretch
    half = (0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1]), 0.5 * (high[2] - low[2]))
    centre = sub(add(low, half), p)
    gap = axpy(-clamp(dot(centre, d) * per_square), d, centre)
    reach = (limit + norm(half)) * (1.0 + 1e-9) + doubt
    if dot(gap, gap) > reach * reach or highest_in_slab(tree, node, normal) < level - doubt:
        return -1.0
    return stretch


@jitable
def towards_nearest(
    tree: TriangleTree,
    segment: tuple[Vec3, Vec3],
    t: float,
    most: float,
    waiting: IntArray,
    squares: FloatArray,
) -> tuple[float, Vec3]:
    """A distance of the segment from p to q to a triangle, mostly the nearest, and the way to it.

    From the place at p + t (q - p) it goes to the point nearest to the triangle nearest there, and
    so on for some steps. Where no triangle is found nearer the distance is ``most``, the way 0.

    Args:
        tree: over the triangles.
        segment: p and q, which may be the same.
        t: where to begin, in [0, 1].
        most: a distance.
        waiting, squares: room for ``DEPTH`` nodes and their squared distances.
    """
    best, normal = most, (0.0, 0.0, 0.0)
    p, q = segment
    d = sub(q, p)
    before = -1
    for _ in range(_TRIES):
        x = axpy(t, d, p)
        _, found = nearest_triangle(tree, x, math.inf, 0.0, waiting, squares)
        if found < 0 or found == before:
            break
        before = found
        triangle = triangle_at(tree.corners, found)
        away = math.sqrt(segment_to_triangle(p, q, triangle))
        closest = closest_point(x, triangle)
        t = on_side(closest, p, d)
        if away < best:
            best = away
            normal = sub(axpy(t, d, p), closest)
        if best == 0.0:
            break
    size = norm(normal) * (1.0 + 1e-12)
    if size > 0.0:
        normal = (normal[0] / size, normal[1] / size, normal[2] / size)
    return best, normal


@jitable
def segment_distance(
    tree: TriangleTree, p: Vec3, q: Vec3, most: float, normal: Vec3, waiting: IntArray
) -> float:
    """Distance of the segment from p to q to the nearest triangle; ``most`` where that is less.

    What is passed over is what :func:`near_triangle` passes over, of the nearest distance so far.

    Args:
        tree: over the triangles.
        p, q: ends of the segment, which may be the same.
        most: a distance.
        normal: about the way from the triangles to the segment, or 0; of a length up to 1.
        waiting: room for ``DEPTH`` nodes.
    """
    _, leaves, corners, _, _ = tree
    inner = len(leaves) - 2
    way = _way(tree, p, sub(q, p), normal)
    best = most
    lowest = min(dot(normal, p), dot(normal, q))
    waiting[0] = 0
    count = 1
    while count > 0 and best > 0.0:  # nothing is nearer than what it passes through
        node, count = _next_leaf(tree, way, best, lowest - best, waiting, count)
        if node < 0:
            continue
        for number in range(leaves[node - inner], leaves[node - inner + 1]):
            a, b, c = triangle = triangle_at(corners, number)
            if max(dot(normal, a), dot(normal, b), dot(normal, c)) >= lowest - best:
                best = min(best, math.sqrt(segment_to_triangle(p, q, triangle)))
    return best
