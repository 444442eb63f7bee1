"""Distances of a URDF arm's links to obstacles, to each other and to the floor.

The poses are given by the ends (k, c, 2, 3) of the arm's capsules, see :meth:`UrdfArm.place`.
"""

from __future__ import annotations

import math

import numpy as np

from abi import arguments
from abi.arm.link_distance_kernels import link_distances, pair_distances
from abi.arm.urdf_arm import UrdfArm
from abi.arrays import FloatArray, IntArray, flat
from abi.obstacles.obstacle_set import ObstacleSet


def obstacle_distances(
    arm: UrdfArm, obstacles: ObstacleSet, ends: FloatArray, enough: float = math.inf
) -> tuple[FloatArray, IntArray]:
    """Signed distances of an arm's capsules to the nearest obstacle.

    Of a capsule that touches nothing and is not the nearest of its pose the distance may be inf,
    and so may what is above ``enough``, [unit].

    Returns:
        Distances (k, c), [unit], inf without obstacles; and numbers of the obstacles, -1 where the
        distance is inf.
    """
    ends = arguments.numbers("ends", ends, (-1, len(arm.capsules), 2, 3))
    shape = ends.shape[:2]
    distance, row = np.empty(shape), np.empty(shape, dtype=np.int32)
    if obstacles.meshes:
        link_distances.compile()  # as Python it would copy their triangles
    link_distances(
        *(flat(ends), arm.radii, obstacles.packed, obstacles.surfaces, enough),
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
