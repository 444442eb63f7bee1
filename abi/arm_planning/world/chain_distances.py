"""Distances of a URDF arm's links to obstacles, to each other and to the floor.

The poses are given by the ends (k, c, 2, 3) of the arm's capsules, see :meth:`UrdfArm.place`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple, Self

import numpy as np

from abi import arguments
from abi.arm_planning.world.chain_distance_kernels import (
    hull_clearances,
    link_distances,
    pair_distances,
)
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arrays import FloatArray, IntArray, flat, read_only
from abi.obstacles.obstacle_set import ObstacleSet
from abi.robot.bodies.allowed_contacts import AllowedContact
from abi.robot.bodies.hull_kernels import hull_distances
from abi.robot.urdf_arm import UrdfArm


def obstacle_distances(
    arm: UrdfArm,
    obstacles: ObstacleSet,
    ends: FloatArray,
    enough: float = math.inf,
    allowed: Sequence[AllowedContact] = (),
) -> tuple[FloatArray, IntArray]:
    """Signed distances of an arm's capsules to the nearest obstacle.

    Of a capsule that touches nothing and is not the nearest of its pose the distance may be inf,
    and so may what is above ``enough``, [unit]. What a link may touch is left out. Those that need
    only not touch have a nearest one of their own.

    Returns:
        Distances (k, c), [unit], inf without obstacles; and numbers of the obstacles, -1 where the
        distance is inf.
    """
    ends = arguments.numbers("ends", ends, (-1, len(arm.capsules), 2, 3))
    if not any(isinstance(one.other, int) for one in allowed) and not arm.touchable.any():
        return _distances(ends, arm.radii, obstacles, enough)
    distance, number = np.empty(ends.shape[:2]), np.empty(ends.shape[:2], dtype=np.int32)
    groups: dict[tuple[frozenset[int], bool], list[int]] = {}
    for k, capsule in enumerate(arm.capsules):
        others = (one.other for one in allowed if one.link == capsule.link)
        left_out = frozenset(k for k in others if isinstance(k, int))
        groups.setdefault((left_out, bool(arm.touchable[k])), []).append(k)
    for (left_out, _), capsules in groups.items():
        rest, numbers = _without(obstacles, left_out)
        of_rest = _distances(ends[:, capsules], arm.radii[capsules], rest, enough)
        distance[:, capsules], number[:, capsules] = of_rest[0], numbers[of_rest[1]]
    return distance, number


@lru_cache(maxsize=8)
def _without(obstacles: ObstacleSet, left_out: frozenset[int]) -> tuple[ObstacleSet, IntArray]:
    """Obstacles without some, and the number of each of the rest, at last -1, (k + 1,)."""
    if not left_out:
        return obstacles, read_only(np.append(np.arange(len(obstacles)), -1).astype(np.int32))
    rest = [k for k in range(len(obstacles)) if k not in left_out]
    numbers = read_only(np.array([*rest, -1], dtype=np.int32))
    return ObstacleSet(tuple(obstacles[k] for k in rest)), numbers


def _distances(
    ends: FloatArray, radii: FloatArray, obstacles: ObstacleSet, enough: float
) -> tuple[FloatArray, IntArray]:
    """Distances (k, c) of capsules with these ends and radii, and numbers of the obstacles."""
    shape = ends.shape[:2]
    distance, row = np.empty(shape), np.empty(shape, dtype=np.int32)
    if obstacles.meshes:
        link_distances.compile()  # as Python it would copy their triangles
    link_distances(
        *(flat(ends), flat(radii), obstacles.packed, obstacles.surfaces, enough),
        *(distance.reshape(-1), row.reshape(-1)),
    )
    return distance, np.append(obstacles.rows, np.int32(-1))[row]


def inside_meshes(arm: UrdfArm, collision_world: CollisionWorld, pose: FloatArray) -> bool:
    """Check whether a body is inside a closed mesh, given that none touches its triangles.

    Args:
        arm: the arm.
        collision_world: everything around it; what it may touch is not asked about.
        pose: joint positions, (n,).
    """
    obstacles = collision_world.obstacles
    if not obstacles.meshes:
        return False
    may = {(one.link, one.other) for one in collision_world.allowed}
    corners = arm.first_corners(pose)
    return any(
        (capsule.link, number) not in may and mesh.signed_distance(corner[None])[0] < 0
        for number, mesh in zip(obstacles.mesh_numbers.tolist(), obstacles.meshes, strict=True)
        for capsule, corner in zip(arm.capsules, corners, strict=True)
    )


class Poses(NamedTuple):
    """Poses of an arm, at which distances of its hulls are measured.

    Attributes:
        positions: of its joints, (k, n), [rad] or [unit].
        ends: of its capsules, (k, c, 2, 3), [unit], world.
        packed: of its frames, in the format of the kernels.
    """

    positions: FloatArray
    ends: FloatArray
    packed: FloatArray

    @classmethod
    def of(cls, arm: UrdfArm, positions: FloatArray) -> Self:
        """Poses at joint positions (k, n)."""
        packed = arm.chain.packed_poses(positions / arm.scales)
        return cls(positions, arm.placed_at(arm.chain.unpacked(packed)), packed)


def hull_distances_to(
    arm: UrdfArm,
    poses: Poses,
    collision_world: CollisionWorld,
    of_capsules: tuple[FloatArray, IntArray],
    below: float,
) -> tuple[FloatArray, IntArray]:
    """Distances to obstacles with those of the hulls where the capsules are nearer than ``below``.

    Of a hull that overlaps an obstacle the distance is that of its capsule, which is below 0. Of
    one that touches nothing and is not the nearest of its pose the distance may be inf.

    Args:
        arm: the arm.
        poses: of it.
        collision_world: the obstacles, and what may touch them.
        of_capsules: distances (k, c) of capsules, [unit], and numbers of the obstacles (k, c).
        below: [unit].
    """
    shape, most = poses.ends.shape[:2], arguments.LARGEST_ID
    distance = arguments.numbers("of_capsules[0]", of_capsules[0], shape, infinite=True).copy()
    number = arguments.bits("of_capsules[1]", of_capsules[1], shape, -most, most).copy()
    row, column = np.nonzero(distance < below)
    if not len(row):
        return distance, number
    # a capsule that needs only not touch tells nothing of the others
    lowest = np.where(arm.touchable[column], np.inf, distance[row, column])
    order = np.lexsort((lowest, row))
    row, column = row[order], column[order]
    asked = np.stack([row, column], axis=1).astype(np.int32)
    found, rows = np.empty(len(asked)), np.empty(len(asked), dtype=np.int32)
    around = collision_world.only(collision_world.numbers >= 0).beyond(0.0)
    hull_clearances(
        *(arm.bodies, poses.packed, flat(poses.ends), around),
        *(asked.reshape(-1), flat(distance[row, column]), found, rows),
    )
    apart = found > 0
    row, column = row[apart], column[apart]
    distance[row, column] = found[apart]
    number[row, column] = np.append(collision_world.numbers, np.int32(-1))[rows[apart]]
    return distance, number


def own_distances(
    arm: UrdfArm, poses: Poses, enough: float = math.inf, together: int = 0
) -> FloatArray:
    """Signed distances between the bodies of ``arm.pairs``, (k, p), [unit].

    They are those of the capsules, and where these overlap but the hulls do not, of the hulls.
    What is above ``enough``, [unit], may be any distance above it. Of so many successive poses as
    are taken ``together`` only the least distance is right.
    """
    distance = np.empty((len(poses.ends), len(arm.pairs)))
    pairs = arm.bodies.pairs
    pair_distances(flat(poses.ends), arm.radii, pairs, enough, distance.reshape(-1))
    asked = np.argwhere(distance <= 0).astype(np.int32)
    if len(asked):
        found = np.empty(len(asked))
        hull_distances(arm.bodies, poses.packed, asked.reshape(-1), enough, together, found)
        row, column = asked[found > 0].T
        distance[row, column] = found[found > 0]
    return distance


def floor_distances(arm: UrdfArm, floor: float, poses: Poses) -> FloatArray:
    """Heights of the bodies above the floor, (k, c), [unit].

    Inf for links that may touch the floor.
    """
    heights = np.asarray(poses.ends[..., 2].min(axis=2) - arm.radii - floor)
    standing = arm.on_floor(floor)
    heights[:, [link in standing for link in arm.capsule_links]] = np.inf
    for column in np.flatnonzero((heights <= 0).any(axis=0)).tolist():
        rows = np.flatnonzero(heights[:, column] <= 0)
        lowest = arm.lowest(poses.positions[rows], column) - floor
        heights[rows, column] = np.where(lowest > 0, lowest, heights[rows, column])
    return heights
