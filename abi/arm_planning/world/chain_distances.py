"""Distances of a URDF arm's links to obstacles, to each other and to the floor.

The poses are given by the ends (k, c, 2, 3) of the arm's capsules, see :meth:`UrdfArm.place`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from abi import arguments
from abi.arm_planning.world.link_distance_kernels import link_distances, pair_distances
from abi.arrays import FloatArray, IntArray, flat, read_only
from abi.obstacles.obstacle_set import ObstacleSet
from abi.robot.bodies.allowed_contacts import AllowedContact
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
    and so may what is above ``enough``, [unit]. What a link may touch is left out.

    Returns:
        Distances (k, c), [unit], inf without obstacles; and numbers of the obstacles, -1 where the
        distance is inf.
    """
    ends = arguments.numbers("ends", ends, (-1, len(arm.capsules), 2, 3))
    if not any(isinstance(one.other, int) for one in allowed):
        return _distances(ends, arm.radii, obstacles, enough)
    distance, number = np.empty(ends.shape[:2]), np.empty(ends.shape[:2], dtype=np.int32)
    groups: dict[frozenset[int], list[int]] = {}
    for k, capsule in enumerate(arm.capsules):
        others = (one.other for one in allowed if one.link == capsule.link)
        groups.setdefault(frozenset(k for k in others if isinstance(k, int)), []).append(k)
    for left_out, capsules in groups.items():
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


def own_distances(arm: UrdfArm, ends: FloatArray) -> FloatArray:
    """Signed distances between the links of ``arm.pairs``, (k, p), [unit]."""
    ends = arguments.numbers("ends", ends, (-1, len(arm.capsules), 2, 3))
    distance = np.empty((len(ends), len(arm.pairs)))
    pair_distances(flat(ends), arm.radii, arm.bodies.pairs, distance.reshape(-1))
    return distance


def floor_distances(arm: UrdfArm, floor: float, ends: FloatArray) -> FloatArray:
    """Heights of the capsules above the floor, (k, c), [unit].

    Inf for links that stand still and for the first one that moves, which may touch the floor.
    """
    ends = arguments.numbers("ends", ends, (-1, len(arm.capsules), 2, 3))
    heights = ends[..., 2].min(axis=2) - arm.radii - floor
    resting = [one.frame < 1 for one in arm.capsules]
    heights[:, resting] = np.inf
    return np.asarray(heights)
