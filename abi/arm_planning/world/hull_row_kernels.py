"""Separation of a body's hull from a row of an arm's surroundings, or from the floor."""

from __future__ import annotations

import math

from abi.arm_planning.world.collision_world_kernels import Obstacles
from abi.arrays import FloatArray
from abi.clearance.separation_kernels import CERTIFIED, REFUTED, UNDECIDED
from abi.compilation.jitable import jitable
from abi.obstacles.primitive_kernels import (
    Axes,
    Core,
    axes_of,
    centre_of,
    core_of,
    in_body,
    in_world,
)
from abi.obstacles.vector_kernels import Vec3, add, sub
from abi.robot.bodies.capsule_table import Bodies
from abi.robot.bodies.hull_kernels import APART, OVERLAP, lowest_point, separation


@jitable
def _highest(core: Core, way: Vec3) -> Vec3:
    """Point of a core without its radius that is highest along a direction, body frame."""
    z = core.z if way[2] >= 0 else -core.z
    if core.is_cylinder == 1:
        across = math.sqrt(way[0] * way[0] + way[1] * way[1])
        if across == 0:
            return core.x, 0.0, z
        return core.x * way[0] / across, core.x * way[1] / across, z
    return (core.x if way[0] >= 0 else -core.x), (core.y if way[1] >= 0 else -core.y), z


@jitable
def _from_row(pair: tuple[Bodies, FloatArray, int, Core, Axes, Vec3], way: Vec3) -> Vec3:
    """Lowest point of a hull less the highest of a row's core, world."""
    bodies, poses, c, core, axes, centre = pair
    highest = add(centre, in_world(axes, _highest(core, in_body(axes, way))))
    return sub(lowest_point(bodies, poses, c, way), highest)


@jitable
def hull_and_row(
    bodies: Bodies, poses: FloatArray, c: int, around: Obstacles, s: int, near: float, far: float
) -> tuple[int, float, Vec3]:
    """Check if a direction keeps the hull of body c farther than ``far`` from row s, at a pose.

    Args:
        bodies: the bodies.
        poses: of the joints, flat (12 (m + 1),), [m].
        c: number of the body.
        around: what to keep clear of.
        s: its row, the last one for the floor.
        near, far: distances of the hull without its rounding, [unit].

    Returns:
        CERTIFIED, REFUTED with a distance below ``near``, or UNDECIDED; the distance; the direction
        from the row.
    """
    if s == len(around.margins) - 1:
        up = (0.0, 0.0, 1.0)
        gap = lowest_point(bodies, poses, c, up)[2] - around.floor
        return CERTIFIED if gap > far else REFUTED if gap < near else UNDECIDED, gap, up
    core, centre = core_of(around.primitives, s), centre_of(around.primitives, s)
    axes = axes_of(around.primitives, s)
    radius = 0.0 if core.is_cylinder == 1 else core.radius
    outcome, gap, way = separation(
        _from_row,
        (bodies, poses, c, core, axes, centre),
        (0.0, 0.0, 1.0),
        near + radius,
        far + radius,
    )
    if outcome == APART:
        return CERTIFIED, gap - radius, way
    return REFUTED if outcome == OVERLAP else UNDECIDED, gap - radius, way
