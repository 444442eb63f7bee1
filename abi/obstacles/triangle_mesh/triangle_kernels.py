"""Squared distances to a triangle, the nearest triangle of a tree, and winding numbers.

The formulas of distances are Ericson's (Real-Time Collision Detection, 2005, sections 5.1.3, 5.1.9
and 5.1.10). From afar a group of triangles winds around a point as one dipole does: its summed
normals at its centre (Barill and others, Fast winding numbers for soups and clouds, 2018). Near
triangles are taken one by one, with their exact solid angles (Van Oosterom and Strackee, The solid
angle of a plane triangle, 1983). Plain Python that numba compiles with its caller.
"""

from __future__ import annotations

import math

from abi.arrays import FloatArray, IntArray
from abi.compilation.jitable import jitable
from abi.obstacles.triangle_mesh.bvh import (
    Dipoles,
    TriangleTree,
    box_of,
    highest_in_slab,
)
from abi.obstacles.vector_kernels import (
    Triangle,
    Vec3,
    axpy,
    cross,
    dot,
    norm,
    point_to_box,
    sub,
    triangle_at,
    vec3_at,
)

THIN = 3e-8
"""A triangle whose height is below this part of its longest side counts as its sides."""


@jitable
def clamp(t: float) -> float:
    """The number in [0, 1] nearest to t."""
    return min(max(t, 0.0), 1.0)


@jitable
def on_side(x: Vec3, a: Vec3, e: Vec3) -> float:
    """Parameter of the point a + t e, t in [0, 1], nearest to x."""
    ee = dot(e, e)
    return clamp(dot(e, sub(x, a)) / ee) if ee > 0.0 else 0.0


@jitable
def point_to_triangle(x: Vec3, triangle: Triangle, most: float) -> float:
    """Squared distance of a point and a triangle; ``most`` where it is not below that.

    The plane counts where x is over the triangle, but for one that is too thin to have a plane; the
    sides count otherwise.
    """
    a, b, c = triangle
    ab, ac, bc = sub(b, a), sub(c, a), sub(c, b)
    to_a = sub(x, a)
    n = cross(ab, ac)
    nn = dot(n, n)
    longest = max(dot(ab, ab), dot(ac, ac), dot(bc, bc))
    if nn > THIN * THIN * longest * longest:
        height = dot(n, to_a)
        square = height * height / nn
        if square >= most:
            return most
        if (
            dot(cross(ab, to_a), n) >= 0.0
            and dot(cross(bc, sub(x, b)), n) >= 0.0
            and dot(cross(ac, to_a), n) <= 0.0
        ):
            return square
    for start, side in ((a, ab), (a, ac), (b, bc)):
        gap = sub(axpy(on_side(x, start, side), side, start), x)
        most = min(most, dot(gap, gap))
    return most


@jitable
def closest_point(x: Vec3, triangle: Triangle) -> Vec3:
    """The point of a triangle nearest to x."""
    a, b, c = triangle
    ab, ac, bc = sub(b, a), sub(c, a), sub(c, b)
    n = cross(ab, ac)
    nn = dot(n, n)
    longest = max(dot(ab, ab), dot(ac, ac), dot(bc, bc))
    if nn > THIN * THIN * longest * longest and over_triangle(x, a, b, c, n):
        return axpy(-dot(n, sub(x, a)) / nn, n, x)
    best, closest = math.inf, a
    for start, side in ((a, ab), (a, ac), (b, bc)):
        there = axpy(on_side(x, start, side), side, start)
        gap = sub(there, x)
        if dot(gap, gap) < best:
            best, closest = dot(gap, gap), there
    return closest


@jitable
def over_triangle(x: Vec3, a: Vec3, b: Vec3, c: Vec3, n: Vec3) -> bool:
    """Check whether the projection of x along the normal n lies in the triangle."""
    return (
        dot(cross(sub(b, a), sub(x, a)), n) >= 0.0
        and dot(cross(sub(c, b), sub(x, b)), n) >= 0.0
        and dot(cross(sub(a, c), sub(x, c)), n) >= 0.0
    )


@jitable
def segment_to_triangle(p: Vec3, q: Vec3, triangle: Triangle) -> float:
    """Squared distance of the segment from p to q and a triangle, which may be degenerate.

    0 where it passes through; else the closest point is at an end of it or on a side.
    """
    a, b, c = triangle
    d = sub(q, p)
    n = cross(sub(b, a), sub(c, a))
    nn = dot(n, n)
    best: float = math.inf
    if nn > 0.0:
        at_p, at_q = dot(n, sub(p, a)), dot(n, sub(q, a))
        through = at_p * at_q <= 0.0 and at_p != at_q
        if through and over_triangle(axpy(at_p / (at_p - at_q), d, p), a, b, c, n):
            return 0.0
        if over_triangle(p, a, b, c, n):
            best = at_p * at_p / nn
        if over_triangle(q, a, b, c, n):
            best = min(best, at_q * at_q / nn)
    for start, side in ((a, sub(b, a)), (b, sub(c, b)), (c, sub(a, c))):
        gap = between_segments(p, d, start, side)
        best = min(best, dot(gap, gap))
    return best


@jitable
def between_segments(p: Vec3, d: Vec3, a: Vec3, e: Vec3) -> Vec3:
    """Way to the segment p + s d, s in [0, 1], from a + t e, t in [0, 1], where it is shortest."""
    r = sub(p, a)
    dd, ee, er = dot(d, d), dot(e, e), dot(e, r)
    s, t = 0.0, 0.0
    if dd > 0.0:
        dr = dot(d, r)
        if ee > 0.0:
            de = dot(d, e)
            determinant = dd * ee - de * de
            if determinant > 0.0:
                s = clamp((de * er - dr * ee) / determinant)
            t = (de * s + er) / ee
            if t < 0.0:
                t = 0.0
                s = clamp(-dr / dd)
            elif t > 1.0:
                t = 1.0
                s = clamp((de - dr) / dd)
        else:
            s = clamp(-dr / dd)
    elif ee > 0.0:
        t = clamp(er / ee)
    return sub(axpy(s, d, p), axpy(t, e, a))


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


OPENING = 2.5
"""Distance, in radii, from which a group is a dipole."""

_FRACTION = 0.1
"""Largest distance of the number from a whole one, which it is around a closed surface."""

_STRAIN = 5.0
"""Balls' worth of area seen as dipoles, above which the error might reach the next whole number.

One ball, or a figure with folds, is about 1 to 3 and off by under 0.05; 100 balls in one are off
100 times as much, and that might be whole. The error falls with the square of the opening.
"""

_DOUBLINGS = 3
"""Retries with a wider opening before all triangles are taken one by one."""


@jitable
def _half_solid_angle(a: Vec3, b: Vec3, c: Vec3) -> float:
    """Half the solid angle of a triangle seen from the origin; positive seen from behind."""
    la, lb, lc = math.sqrt(dot(a, a)), math.sqrt(dot(b, b)), math.sqrt(dot(c, c))
    below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb
    return math.atan2(dot(a, cross(b, c)), below)


@jitable
def winding_number(
    x: Vec3,
    dipoles: Dipoles,
    layer: int,
    opening: float,
    stack: IntArray,
) -> tuple[float, float]:
    """Generalised winding number around x, 1 inside a surface that faces outward.

    Args:
        x: a point.
        dipoles: of the layers' trees.
        layer: number of the one that is meant.
        opening: distance, in radii, from which a node is a dipole; exact where it is inf.
        stack: room for 128 nodes.

    Returns:
        The number, and the area seen as dipoles, over its distances squared by 4 pi.
    """
    centres, radii, normals, areas, leaves, corners, layers = dipoles
    first = 2 * layers[layer] - layer
    inner = first + layers[layer + 1] - layers[layer] - 1
    leaf = layers[layer] + layer - inner
    halves, far_field, strain = 0.0, 0.0, 0.0
    stack[0] = first
    waiting = 1
    while waiting > 0:
        waiting -= 1
        node = stack[waiting]
        offset = sub(vec3_at(centres, 3 * node), x)
        far = dot(offset, offset)
        reach = opening * radii[node]
        if far > reach * reach:
            far_field += dot(vec3_at(normals, 3 * node), offset) / (far * math.sqrt(far))
            strain += areas[node] / far
        elif node >= inner:
            for t in range(9 * leaves[leaf + node], 9 * leaves[leaf + node + 1], 9):
                a, b = sub(vec3_at(corners, t), x), sub(vec3_at(corners, t + 3), x)
                halves += _half_solid_angle(a, b, sub(vec3_at(corners, t + 6), x))
        else:
            stack[waiting], stack[waiting + 1] = 2 * node + 1 - first, 2 * node + 2 - first
            waiting += 2
    return halves / (2 * math.pi) + far_field / (4 * math.pi), strain / (4 * math.pi)


@jitable
def is_inside(tree: TriangleTree, dipoles: Dipoles, x: Vec3, stack: IntArray) -> bool:
    """Check whether any layer of a closed surface winds around x; in doubt it does.

    Args:
        tree: over the triangles of the surface.
        dipoles: of the layers' trees.
        x: a point.
        stack: room for 128 nodes.
    """
    low, high = box_of(tree, 0)
    if not (low[0] <= x[0] <= high[0] and low[1] <= x[1] <= high[1] and low[2] <= x[2] <= high[2]):
        return False
    inside = False
    for layer in range(len(dipoles.layers) - 1):
        inside = inside or _is_wound(dipoles, layer, x, stack)
    return inside


@jitable
def _is_wound(dipoles: Dipoles, layer: int, x: Vec3, stack: IntArray) -> bool:
    opening, most = OPENING, _STRAIN
    for attempt in range(_DOUBLINGS + 2):
        if attempt > _DOUBLINGS:
            opening = math.inf
        number, strain = winding_number(x, dipoles, layer, opening, stack)
        if strain <= most and abs(number - round(number)) <= _FRACTION:
            return abs(number) > 0.5
        opening, most = 2.0 * opening, 4.0 * most
    return True
