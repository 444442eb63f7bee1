"""Winding numbers of a surface around points, by a tree of dipoles.

From afar a group of triangles looks like one dipole: its summed normals at its centre (Barill and
others, Fast winding numbers for soups and clouds, 2018). Near triangles are taken one by one, with
their exact solid angles (Van Oosterom and Strackee, The solid angle of a plane triangle, 1983).
Plain Python that numba compiles with its caller.
"""

from __future__ import annotations

import math

from abi.arrays import IntArray
from abi.compilation.jitable import jitable
from abi.obstacles.triangle_mesh.bvh import (
    Dipoles,
    TriangleTree,
    box_of,
)
from abi.obstacles.vector_kernels import Vec3, cross, dot, sub, vec3_at

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
    tree: TriangleTree,
    dipoles: Dipoles,
    opening: float,
    stack: IntArray,
) -> tuple[float, float]:
    """Generalised winding number around x, 1 inside a surface that faces outward.

    Args:
        x: a point.
        tree: over the triangles.
        dipoles: of the nodes of the tree.
        opening: distance, in radii, from which a node is a dipole; exact where it is inf.
        stack: room for 128 nodes.

    Returns:
        The number, and the area seen as dipoles, over its distances squared by 4 pi.
    """
    leaves, corners = tree.leaves, tree.corners
    centres, radii, normals, areas = dipoles
    inner = len(leaves) - 2
    halves, far_field, strain = 0.0, 0.0, 0.0
    stack[0] = 0
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
            for t in range(9 * leaves[node - inner], 9 * leaves[node - inner + 1], 9):
                a, b = sub(vec3_at(corners, t), x), sub(vec3_at(corners, t + 3), x)
                halves += _half_solid_angle(a, b, sub(vec3_at(corners, t + 6), x))
        else:
            stack[waiting], stack[waiting + 1] = 2 * node + 1, 2 * node + 2
            waiting += 2
    return halves / (2 * math.pi) + far_field / (4 * math.pi), strain / (4 * math.pi)


@jitable
def is_inside(tree: TriangleTree, dipoles: Dipoles, x: Vec3, stack: IntArray) -> bool:
    """Check whether a closed surface winds around x; in doubt it does.

    Args:
        tree: over the triangles of the surface.
        dipoles: of the nodes of the tree.
        x: a point.
        stack: room for 128 nodes.
    """
    low, high = box_of(tree, 0)
    if not (low[0] <= x[0] <= high[0] and low[1] <= x[1] <= high[1] and low[2] <= x[2] <= high[2]):
        return False
    opening, most = OPENING, _STRAIN
    for attempt in range(_DOUBLINGS + 2):
        if attempt > _DOUBLINGS:
            opening = math.inf
        number, strain = winding_number(x, tree, dipoles, opening, stack)
        if strain <= most and abs(number - round(number)) <= _FRACTION:
            return abs(number) > 0.5
        opening, most = 2.0 * opening, 4.0 * most
    return True
