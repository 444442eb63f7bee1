"""Shortest paths around one solid widened by a radius, in the solid's own axes.

A shortest path around a convex body is straight, then a geodesic of its surface, then straight,
without a kink. Where the surface is developable (flat faces, round edges, a cylinder's side) it
unrolls into a plane, in which the whole path is one straight line. The rest, paths that touch a
rounded corner or an end, is bounded from below.

Points are triples of numbers, [unit]. Widened means: all points within the radius of the solid.
"""

from __future__ import annotations

import math

import numpy as np

from abi.arrays import BoolArray, FloatArray
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, compiled
from abi.obstacles.primitive_kernels import (
    WIDTH,
    Core,
    axes_of,
    centre_of,
    core_of,
    in_body,
    segment_within,
    signed_distance,
)
from abi.obstacles.vector_kernels import Vec3, axpy, cross, distance, dot, norm, sub
from abi.search.taut.geodesic_box_kernels import LengthBound, around_box

_SAMPLES = 65  # of the straight line and of a bar's axis, for balls that bound
_PRISMS = 4  # square prisms inscribed in a cylinder, at even angles


@jitable
def around_ball(radius: float, start: Vec3, goal: Vec3) -> float:
    """Length of the shortest path around a ball at the origin: two tangents and an arc.

    Angles are those of tangents, not cosines: near 0 and a half turn these have lost half of their
    digits.

    Args:
        radius: of the ball, [unit].
        start: not inside the ball.
        goal: not inside the ball.
    """
    a, b = norm(start), norm(goal)
    straight = distance(start, goal)
    if radius <= 0 or a <= radius or b <= radius:
        return straight
    before, after = math.sqrt((a - radius) * (a + radius)), math.sqrt((b - radius) * (b + radius))
    arc = math.atan2(norm(cross(start, goal)), dot(start, goal))
    arc -= math.atan2(before, radius) + math.atan2(after, radius)
    if arc <= 0:
        return straight
    return before + after + radius * arc


@jitable
def around_bar(radius: float, half: float, start: Vec3, goal: Vec3) -> LengthBound:
    """Shortest path around a bar along z: round in section, its ends beyond |z| = ``half``.

    The bar widened is the cylinder |z| <= half with anything beyond that lies in the cylinder's
    extension, as a capsule's caps do. A path that meets it only on the cylinder unrolls; any other
    crosses a plane |z| = half, so mirroring about that plane bounds its length.
    """
    straight = distance(start, goal)
    ends = min(_plane_bound(half, 1.0, start, goal), _plane_bound(half, -1.0, start, goal))
    a, b = math.hypot(start[0], start[1]), math.hypot(goal[0], goal[1])
    if a < radius or b < radius:
        return max(ends, straight), False
    separation = abs(math.atan2(start[1], start[0]) - math.atan2(goal[1], goal[0]))
    before, after = math.sqrt((a - radius) * (a + radius)), math.sqrt((b - radius) * (b + radius))
    unseen = math.atan2(before, radius) + math.atan2(after, radius)
    rise = goal[2] - start[2]
    best = math.inf
    for angle in (separation, 2 * math.pi - separation):
        if angle < unseen:
            return straight, False
        across = before + after + radius * (angle - unseen)
        first = start[2] + rise * before / across if across > 0 else start[2]
        last = goal[2] - rise * after / across if across > 0 else goal[2]
        if max(abs(first), abs(last)) <= half:
            best = min(best, math.hypot(across, rise))
    return min(best, ends), best <= ends


@jitable
def _plane_bound(height: float, sign: float, start: Vec3, goal: Vec3) -> float:
    """Length of the shortest path to goal by the plane z = sign height, on its side away from 0."""
    a, b = max(height - sign * start[2], 0.0), max(height - sign * goal[2], 0.0)
    if a == 0 or b == 0:
        return distance(start, goal)
    return distance((start[0], start[1], 0.0), (goal[0], goal[1], a + b))


@jitable
def _ball_bound(core: Core, clearance: float, start: Vec3, goal: Vec3) -> float:
    """Lower bound by the largest ball in the widened solid around a point of the straight line."""
    radius, centre = -math.inf, start
    for k in range(_SAMPLES):
        t = k / (_SAMPLES - 1)
        p = axpy(t, sub(goal, start), start)
        room = clearance - signed_distance(core, p)
        if room > radius:
            radius, centre = room, p
    return around_ball(radius, sub(start, centre), sub(goal, centre))


@jitable
def _axis_balls_bound(radius: float, half: float, start: Vec3, goal: Vec3) -> float:
    """Lower bound by balls around points of the z axis up to ``half``."""
    bound = 0.0
    for k in range(_SAMPLES):
        centre = (0.0, 0.0, half * (2 * k / (_SAMPLES - 1) - 1))
        bound = max(bound, around_ball(radius, sub(start, centre), sub(goal, centre)))
    return bound


@jitable
def _prisms_bound(radius: float, half: float, clearance: float, start: Vec3, goal: Vec3) -> float:
    """Lower bound by square prisms within a cylinder."""
    side = radius / math.sqrt(2)
    bound = 0.0
    for k in range(_PRISMS):
        c, s = math.cos(k * math.pi / 2 / _PRISMS), math.sin(k * math.pi / 2 / _PRISMS)
        a = (c * start[0] + s * start[1], c * start[1] - s * start[0], start[2])
        b = (c * goal[0] + s * goal[1], c * goal[1] - s * goal[0], goal[2])
        core = Core(side, side, half, 0.0, 0.0)
        if segment_within(core, clearance, a, sub(b, a)):
            bound = max(bound, around_box((side, side, half), clearance, a, b)[0])
    return bound


@jitable
def _solid_bound(core: Core, clearance: float, start: Vec3, goal: Vec3) -> LengthBound:
    """Lower bound around a solid that blocks the line, see ``abi.obstacles.primitive_kernels``."""
    if min(signed_distance(core, start), signed_distance(core, goal)) < clearance:
        return distance(start, goal), False
    radius, half = core.radius, core.z
    if core.is_cylinder == 0 and core.x + core.y > 0:
        length, exact = around_box((core.x, core.y, half), radius + clearance, start, goal)
        other = 0.0 if exact else _ball_bound(core, clearance, start, goal)
    elif core.is_cylinder == 0 and half == 0:
        return around_ball(radius + clearance, start, goal), True
    elif core.is_cylinder == 0:
        length, exact = around_bar(radius + clearance, half, start, goal)
        other = 0.0 if exact else _axis_balls_bound(radius + clearance, half, start, goal)
    else:
        length, exact = around_bar(core.x + clearance, half, start, goal)
        other = 0.0
        if not exact:
            inner = min(core.x, half)
            other = max(
                _axis_balls_bound(inner + clearance, half - inner, start, goal),
                _prisms_bound(core.x, half, clearance, start, goal),
            )
    return max(length, other), exact


@compiled(example=(FLOATS, 0.0, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)))
def solid_bounds(
    solids: FloatArray, clearance: float, start: Vec3, goal: Vec3
) -> tuple[FloatArray, BoolArray]:
    """Lower bounds of the paths from start to goal around each of the solids alone.

    Args:
        solids: (k WIDTH,) rows, one after the other.
        clearance: distance to keep from them, [unit].
        start: start, [unit], world.
        goal: goal.

    Returns:
        The bounds (k,), [unit], 0 for a solid that does not block the line; and whether a path has
        that length (k,).
    """
    count = len(solids) // WIDTH
    lengths, exact = np.zeros(count), np.zeros(count, np.bool_)
    for s in range(count):
        axes, core = axes_of(solids, s), core_of(solids, s)
        a = in_body(axes, sub(start, centre_of(solids, s)))
        b = in_body(axes, sub(goal, centre_of(solids, s)))
        if segment_within(core, clearance, a, sub(b, a)):
            lengths[s], exact[s] = _solid_bound(core, clearance, a, b)
    return lengths, exact
