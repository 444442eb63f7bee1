"""Shortest ways around one solid widened by a radius, in the solid's own axes.

A shortest way around a convex body is straight, then a geodesic of its surface, then straight, with
one tangent all along. Where the surface is developable (flat faces, round edges, a cylinder's side)
it unrolls into a plane, in which that whole way is one straight line. What is left, ways that touch
a rounded corner or an end, is bounded from below.

Compiled by numba; ``around`` runs uncompiled too, by its ``py_func`` on plain lists. Points are
triples of numbers, [unit]. Widened means: all points within the radius of the solid. A way is its
length, below which there is none, [unit], and whether there is one of that length.
"""

from __future__ import annotations

import math

import numpy as np
from numba.extending import register_jitable

from abi.arrays import BoolArray, FloatArray
from abi.compiled import FLOATS, compiled
from abi.obstacles.primitive_kernels import (
    WIDTH,
    Axes,
    Core,
    axes_of,
    centre_of,
    core_of,
    in_body,
    segment_within,
    signed_distance,
)
from abi.obstacles.vector_kernels import Vec3, distance, sub
from abi.taut.geodesic_box_kernels import around_box
from abi.taut.geodesic_round_kernels import Way, around_ball, around_bar

_SAMPLES = 65  # of the straight line and of a bar's axis, for balls that bound
_PRISMS = 4  # square prisms inscribed in a cylinder, turned evenly


@register_jitable
def _by_balls(core: Core, clearance: float, start: Vec3, goal: Vec3) -> float:
    """Bound by the largest ball in the widened solid around a place of the straight line."""
    radius, place = -math.inf, start
    for k in range(_SAMPLES):
        t = k / (_SAMPLES - 1)
        x = start[0] + t * (goal[0] - start[0])
        y = start[1] + t * (goal[1] - start[1])
        z = start[2] + t * (goal[2] - start[2])
        room = clearance - signed_distance(core, (x, y, z))
        if room > radius:
            radius, place = room, (x, y, z)
    x, y, z = place
    return around_ball(
        radius,
        (start[0] - x, start[1] - y, start[2] - z),
        (goal[0] - x, goal[1] - y, goal[2] - z),
    )


@register_jitable
def _by_balls_on_axis(radius: float, half: float, start: Vec3, goal: Vec3) -> float:
    """Bound by balls around places of the z axis up to ``half``."""
    bound = 0.0
    for k in range(_SAMPLES):
        height = half * (2 * k / (_SAMPLES - 1) - 1)
        bound = max(
            bound,
            around_ball(
                radius,
                (start[0], start[1], start[2] - height),
                (goal[0], goal[1], goal[2] - height),
            ),
        )
    return bound


@register_jitable
def _by_prisms(radius: float, half: float, clearance: float, start: Vec3, goal: Vec3) -> float:
    """Bound by square prisms within a cylinder."""
    side = radius / math.sqrt(2)
    bound = 0.0
    for k in range(_PRISMS):
        c, s = math.cos(k * math.pi / 2 / _PRISMS), math.sin(k * math.pi / 2 / _PRISMS)
        a = (c * start[0] + s * start[1], c * start[1] - s * start[0], start[2])
        b = (c * goal[0] + s * goal[1], c * goal[1] - s * goal[0], goal[2])
        core = (side, side, half, 0.0, 0.0)
        if segment_within(core, clearance, a, sub(b, a)):
            bound = max(bound, around_box((side, side, half), clearance, a, b)[0])
    return bound


@register_jitable
def _around(core: Core, clearance: float, start: Vec3, goal: Vec3) -> Way:
    """Way around a solid that is in the way, see ``abi.obstacles.primitive_kernels``."""
    if min(signed_distance(core, start), signed_distance(core, goal)) < clearance:
        return distance(start, goal), False
    radius, half = core[3], core[2]
    if core[4] == 0 and radius == 0:
        length, exact = around_box((core[0], core[1], half), clearance, start, goal)
        other = 0.0 if exact else _by_balls(core, clearance, start, goal)
    elif core[4] == 0 and half == 0:
        return around_ball(radius + clearance, start, goal), True
    elif core[4] == 0:
        length, exact = around_bar(radius + clearance, half, start, goal)
        other = 0.0 if exact else _by_balls_on_axis(radius + clearance, half, start, goal)
    else:
        length, exact = around_bar(core[0] + clearance, half, start, goal)
        other = 0.0
        if not exact:
            inner = min(core[0], half)
            other = max(
                _by_balls_on_axis(inner + clearance, half - inner, start, goal),
                _by_prisms(core[0], half, clearance, start, goal),
            )
    return max(length, other), exact


@compiled(example=(FLOATS, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0))
def around(
    solids: FloatArray,
    clearance: float,
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
) -> tuple[FloatArray, BoolArray]:
    """Bounds of the ways from a to b around each of the solids alone.

    Args:
        solids: (k WIDTH,) rows, one after the other.
        clearance: distance to keep from them, [unit].
        ax, ay, az: start, [unit], world.
        bx, by, bz: goal.

    Returns:
        No way is shorter, (k,), [unit], 0 for a solid that is not in the way; and whether there is
        one of that length (k,).
    """
    count = len(solids) // WIDTH
    lengths, exact = np.zeros(count), np.zeros(count, np.bool_)
    for s in range(count):
        axes: Axes = axes_of(solids, s)
        core = core_of(solids, s)
        start = in_body(axes, sub((ax, ay, az), centre_of(solids, s)))
        goal = in_body(axes, sub((bx, by, bz), centre_of(solids, s)))
        if segment_within(core, clearance, start, sub(goal, start)):
            lengths[s], exact[s] = _around(core, clearance, start, goal)
    return lengths, exact
