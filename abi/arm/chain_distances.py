"""Distances of a URDF arm's links to obstacles, to each other and to the floor, at given joints."""

from __future__ import annotations

import math

import numpy as np

from abi.arm.chain_capsules import segment_distances
from abi.arm.link_distance_kernels import link_distances
from abi.arm.urdf_arm import UrdfArm
from abi.arrays import FloatArray, IntArray, flat
from abi.obstacles.obstacle_set import ObstacleSet


def obstacle_distances(
    arm: UrdfArm, obstacles: ObstacleSet, positions: FloatArray, enough: float = math.inf
) -> tuple[FloatArray, IntArray]:
    """Signed distances of an arm's capsules to the nearest obstacle at joint positions (k, n).

    Of a capsule that touches nothing and is not the nearest of its pose the distance may be inf,
    and so may what is above ``enough``, [unit].

    Returns:
        Distances (k, c), [unit], inf without obstacles; and numbers of the obstacles, -1 where the
        distance is inf.
    """
    shape = len(positions), len(arm.capsules)
    distance, row = np.empty(shape), np.empty(shape, dtype=np.int32)
    if obstacles.meshes:
        link_distances.compile()  # as Python it would copy their triangles
    link_distances(
        *(flat(arm.place(positions)), arm.radii, obstacles.packed, obstacles.surfaces, enough),
        *(distance.reshape(-1), row.reshape(-1)),
    )
    return distance, np.append(obstacles.rows, np.int32(-1))[row]


def own_distances(arm: UrdfArm, positions: FloatArray) -> FloatArray:
    """Signed distances between the links of ``arm.pairs`` at positions (k, n), (k, p), [unit]."""
    ends, pairs = arm.place(positions), arm.pairs
    first, second = (ends[:, pairs[:, side]].reshape(-1, 2, 3) for side in (0, 1))
    gaps = segment_distances(first, second).reshape(len(positions), len(pairs))
    return np.asarray(gaps - arm.radii[pairs].sum(axis=1))


def floor_distances(arm: UrdfArm, floor: float, positions: FloatArray) -> FloatArray:
    """Heights of the capsules above the floor at positions (k, n), (k, c), [unit].

    Inf for links that stand still and for the first one that moves, which may touch the floor.
    """
    heights = arm.place(positions)[..., 2].min(axis=2) - arm.radii - floor
    resting = [one.frame < 1 for one in arm.capsules]
    heights[:, resting] = np.inf
    return np.asarray(heights)
