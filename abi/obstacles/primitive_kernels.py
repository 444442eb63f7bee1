"""Convex primitives as rows of numbers: their signed distance, and tests against a margin.

Plain Python that numba compiles with its caller; uncompiled it runs on lists. Most arguments are
numbers and tuples, because passing arrays costs reference counting at every call.

A primitive is ``WIDTH`` numbers: centre (3), the body's axes in the world (9), half sizes of its
core (3), radius around the core, 1 for a cylinder and 0 otherwise, its bounds low and high (6), and
nine of the tree that several make, see ``primitive_tree_kernels``. A box is a core alone, a sphere
and a capsule are a core with a radius. A cylinder's core is its own radius, twice, and its half
height.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from abi.arrays import FloatArray
from abi.compilation.jitable import jitable
from abi.obstacles.vector_kernels import Vec3, axpy, dot, sub, vec3_at

WIDTH = 32
"""Numbers that describe a primitive."""
CORE, BOUNDS = 12, 17
"""Where its core and its bounds begin among them."""

Axes = tuple[Vec3, Vec3, Vec3]
"""The body's axes in the world."""

_STEPS = 90


class Core(NamedTuple):
    """A solid in its body's frame: a box or a cylinder, and what is within a radius of it.

    Attributes:
        x, y, z: half sizes, [unit]; x is a cylinder's radius, z half its height.
        radius: around it, [unit].
        is_cylinder: 1 for a cylinder, 0 for a box.
    """

    x: float
    y: float
    z: float
    radius: float
    is_cylinder: float


@jitable
def core_of(primitives: FloatArray, s: int) -> Core:
    """Core of primitive s."""
    k = WIDTH * s + CORE
    x, y, z = vec3_at(primitives, k)
    return Core(x, y, z, primitives[k + 3], primitives[k + 4])


@jitable
def axes_of(primitives: FloatArray, s: int) -> Axes:
    """Axes of primitive s."""
    k = WIDTH * s + 3
    return (
        (primitives[k], primitives[k + 1], primitives[k + 2]),
        (primitives[k + 3], primitives[k + 4], primitives[k + 5]),
        (primitives[k + 6], primitives[k + 7], primitives[k + 8]),
    )


@jitable
def centre_of(primitives: FloatArray, s: int) -> Vec3:
    """Centre of primitive s, [unit], world."""
    k = WIDTH * s
    return primitives[k], primitives[k + 1], primitives[k + 2]


@jitable
def in_body(axes: Axes, p: Vec3) -> Vec3:
    """A direction of the world in the body's axes."""
    return (
        axes[0][0] * p[0] + axes[0][1] * p[1] + axes[0][2] * p[2],
        axes[1][0] * p[0] + axes[1][1] * p[1] + axes[1][2] * p[2],
        axes[2][0] * p[0] + axes[2][1] * p[1] + axes[2][2] * p[2],
    )


@jitable
def in_world(axes: Axes, p: Vec3) -> Vec3:
    """A direction of the body's axes in the world."""
    return (
        axes[0][0] * p[0] + axes[1][0] * p[1] + axes[2][0] * p[2],
        axes[0][1] * p[0] + axes[1][1] * p[1] + axes[2][1] * p[2],
        axes[0][2] * p[0] + axes[1][2] * p[1] + axes[2][2] * p[2],
    )


@jitable
def signed_distance(core: Core, p: Vec3) -> float:
    """Signed distance of a body point."""
    a, b, c = abs(p[0]) - core.x, abs(p[1]) - core.y, abs(p[2]) - core.z
    if core.is_cylinder == 1:
        a = math.sqrt(p[0] * p[0] + p[1] * p[1]) - core.x
        b = -core.x
    most = max(a, max(b, c))
    if most > 0:
        a, b, c = max(a, 0.0), max(b, 0.0), max(c, 0.0)
        most = math.sqrt(a * a + b * b + c * c)
    return most - core.radius


@jitable
def distance_to(primitives: FloatArray, s: int, x: Vec3) -> float:
    """Signed distance of a point to primitive s, [unit], world."""
    p = in_body(axes_of(primitives, s), sub(x, centre_of(primitives, s)))
    return signed_distance(core_of(primitives, s), p)


@jitable
def signed_distance_gradient(core: Core, p: Vec3) -> tuple[float, Vec3]:
    """Signed distance of a body point, and a unit subgradient of it."""
    x, y, z = p
    side = 1.0 if x >= 0 else -1.0
    front = 1.0 if y >= 0 else -1.0
    top = 1.0 if z >= 0 else -1.0
    if core.is_cylinder == 1:
        radial = math.sqrt(x * x + y * y)
        u, v = (x / radial, y / radial) if radial > 0 else (1.0, 0.0)
        a, c = radial - core.x, abs(z) - core.z
        if a > 0 and c > 0:
            distance = math.sqrt(a * a + c * c)
            return distance, (a / distance * u, a / distance * v, c / distance * top)
        if a >= c:
            return a, (u, v, 0.0)
        return c, (0.0, 0.0, top)
    a, b, c = abs(x) - core.x, abs(y) - core.y, abs(z) - core.z
    e, f, g = max(a, 0.0), max(b, 0.0), max(c, 0.0)
    distance = math.sqrt(e * e + f * f + g * g)
    if distance > 0:
        way = (e / distance * side, f / distance * front, g / distance * top)
        return distance - core.radius, way
    if a >= b and a >= c:
        return a - core.radius, (side, 0.0, 0.0)
    if b >= c:
        return b - core.radius, (0.0, front, 0.0)
    return c - core.radius, (0.0, 0.0, top)


@jitable(forceinline=True)
def support(core: Core, direction: Vec3) -> float:
    """Greatest product of a body direction with a primitive."""
    x, y, z = abs(direction[0]), abs(direction[1]), abs(direction[2])
    if core.is_cylinder == 1:
        across: float = math.sqrt(x * x + y * y) * core.x + z * core.z
        return across
    return x * core.x + y * core.y + z * core.z + core.radius


@jitable
def segment_within(core: Core, margin: float, p: Vec3, d: Vec3) -> bool:
    """Check whether the segment from p to p + d, in the body's axes, comes nearer than ``margin``.

    The distance is convex along the segment, so a tangent at t bounds it from below: on one side
    of t it stays above the margin, on the other it does so for a known stretch. The rest is
    sampled where the slope is likely to be zero.
    """
    low, high = 0.0, 1.0
    before, falling, after, rising = 0.0, 0.0, 1.0, 0.0  # the last slopes, and where
    square = dot(d, d)
    # nearest to the centre: there most segments that come too near do so
    t = min(max(-dot(p, d) / square, 0.0), 1.0) if square > 0 else 0.0
    for step in range(_STEPS):
        distance, gradient = signed_distance_gradient(core, axpy(t, d, p))
        if distance < margin:
            return True
        slope = dot(gradient, d)
        if slope < 0:
            low = max(low, t - (distance - margin) / slope)
            before, falling = t, slope
        elif slope > 0:
            high = min(high, t - (distance - margin) / slope)
            after, rising = t, slope
        else:
            return False
        if low >= high:
            return False
        if falling == 0:
            t = low
        elif rising == 0:
            t = high
        else:
            t = before - falling * (after - before) / (rising - falling)
            if step % 3 == 2 or t <= low or t >= high:
                t = (low + high) / 2
    return False
