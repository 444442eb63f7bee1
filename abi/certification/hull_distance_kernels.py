"""Differences of a robot's hulls from obstacles and from each other, for the search of directions.

:func:`abi.robot.bodies.hull_kernels.separation` takes them. What a direction proves is computed
anew from all points, so that errors here can lose a proof but never make a false one.
"""

from __future__ import annotations

import math

from abi.arrays import FloatArray
from abi.compilation.jitable import jitable
from abi.obstacles.primitive_kernels import axes_of, centre_of, core_of, in_body, in_world
from abi.obstacles.vector_kernels import Vec3, axpy, sub, vec3_at

Points = tuple[FloatArray, int, int]
"""Points, flat, the first of a hull and the one behind its last, [unit], world."""


@jitable
def lowest_of(hull: Points, way: Vec3) -> Vec3:
    """Point of a hull that is lowest along a direction."""
    points, first, last = hull
    best, which = math.inf, first
    x, y, z = way
    for k in range(first, last):
        product = x * points[3 * k] + y * points[3 * k + 1] + z * points[3 * k + 2]
        if product < best:
            best, which = product, k
    return vec3_at(points, 3 * which)


@jitable
def radius_of(primitives: FloatArray, s: int) -> float:
    """Radius around a primitive's core, [unit]; 0 of a cylinder, whose core is all of it."""
    core = core_of(primitives, s)
    return 0.0 if core.is_cylinder == 1 else core.radius


@jitable
def from_row(pair: tuple[Points, FloatArray, int], way: Vec3) -> Vec3:
    """Lowest point of a hull less the highest of a primitive's core, without its radius."""
    hull, primitives, s = pair
    core, axes = core_of(primitives, s), axes_of(primitives, s)
    x, y, z = in_body(axes, way)
    c = core.z if z >= 0 else -core.z
    if core.is_cylinder == 1:
        across = math.sqrt(x * x + y * y)
        share = core.x / across if across > 0 else 0.0
        point = (share * x, share * y, c)
    else:
        point = (core.x if x >= 0 else -core.x, core.y if y >= 0 else -core.y, c)
    highest = axpy(1.0, in_world(axes, point), centre_of(primitives, s))
    return sub(lowest_of(hull, way), highest)


@jitable
def from_hull(pair: tuple[Points, Points], way: Vec3) -> Vec3:
    """Lowest point of a hull less the highest of another."""
    hull, other = pair
    return sub(lowest_of(hull, way), lowest_of(other, (-way[0], -way[1], -way[2])))
