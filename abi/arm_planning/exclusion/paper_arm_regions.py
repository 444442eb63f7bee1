"""Surfaces of two regions of tool positions: the arm's shadow and its reach."""

from __future__ import annotations

import math

import numpy as np

from abi import arguments
from abi.arm_planning.exclusion import paper_arm_mask_kernels
from abi.arm_planning.exclusion import paper_arm_region_kernels as kernels
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arrays import FloatArray, flat, read_only
from abi.obstacles.pose import Vec3
from abi.robot.paper_arm.paper_arm import PaperArm
from abi.scene.arm_settings import Elbow

_SHADOW_PLACES, _MESH_PLACES, _REACH_PLACES = 20, 12, 28
"""Grid points along the longest side; fewer if there is a triangle mesh."""
_MARGIN = 1e-3  # of a cell: how far outside a region ends at the box


def shadow(
    arm: PaperArm,
    elbow: Elbow,
    extension: float,
    collision_world: CollisionWorld,
    box: tuple[Vec3, Vec3],
) -> FloatArray:
    """Surface of the tool positions at which a link would be in an obstacle.

    Args:
        arm: the arm.
        elbow: its branch.
        extension: q5, [unit].
        collision_world: the obstacles.
        box: low and high corner of the workspace, [unit].

    Returns:
        Triangles (n, 3, 3) of the region's surface, [unit], world.
    """
    places = _MESH_PLACES if collision_world.inside.any() else _SHADOW_PLACES
    points, shape = grid(*box, places)
    forearm = arm.a4 + arm.a5 + extension
    reached = np.empty(len(points), dtype=np.bool_)
    table = arm.table(elbow)
    paper_arm_mask_kernels.reached_places(flat(points), table, forearm, 0.0, reached)
    gaps = np.empty(len(points))
    most = float(np.subtract(box[1], box[0]).max()) / places
    solids = collision_world.only(collision_world.numbers >= 0).beyond(0.0)
    kernels.arm_gaps(flat(points), table, solids, forearm, read_only(reached), most, gaps)
    return surface(points, gaps, shape)


def reachable(arm: PaperArm, elbow: Elbow, extension: float, lowest: float) -> FloatArray:
    """Surface of the tool positions in reach, within the limits of q2 and q3 and above the floor.

    Args:
        arm: the arm.
        elbow: its branch.
        extension: q5, [unit].
        lowest: height of the floor, [unit].

    Returns:
        Triangles (n, 3, 3) of the region's surface, [unit], world.
    """
    forearm = arm.a4 + arm.a5 + extension
    points, shape = grid(*box_above(lowest, arm.shoulder, arm.a3 + forearm), _REACH_PLACES)
    rooms = np.empty(len(points))
    kernels.reach_rooms(flat(points), arm.table(elbow), forearm, rooms)
    return surface(points, -rooms, shape)


def box_above(floor: float, centre: FloatArray, reach: float) -> tuple[Vec3, Vec3]:
    """Low and high corner of the box around a ball, cut off at the floor, [unit]."""
    x, y, z = centre.tolist()
    return (x - reach, y - reach, max(z - reach, floor)), (x + reach, y + reach, z + reach)


def grid(low: Vec3, high: Vec3, longest: int) -> tuple[FloatArray, tuple[int, int, int]]:
    """Points (n, 3) of a grid in a box, with one layer just outside, and their number by axis."""
    sides = np.subtract(high, low)
    cell = float(sides.max()) / (longest - 1)
    axes = []
    for a, b in zip(low, high, strict=True):
        inner = np.linspace(a, b, max(2, round((b - a) / cell) + 1))
        axes.append(np.concatenate([[a - _MARGIN * cell], inner, [b + _MARGIN * cell]]))
    x, y, z = (len(axis) for axis in axes)
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3), (x, y, z)


def surface(points: FloatArray, values: FloatArray, shape: tuple[int, int, int]) -> FloatArray:
    """Surface around the points with values <= 0; none of the outermost layer has one."""
    values = arguments.numbers("values", values, (math.prod(shape),)).copy()
    points = arguments.numbers("points", points, (len(values), 3))
    field = values.reshape(shape)
    size = float(np.abs(values).max()) + 1.0
    for axis in range(3):
        ends = np.moveaxis(field, axis, 0)
        ends[0] = ends[-1] = size
    # a place at 0 exactly would have triangles of no size around it
    field[field == 0] = -1e-12 * size
    return read_only(kernels.zero_surface(flat(points), flat(values), *shape).reshape(-1, 3, 3))
