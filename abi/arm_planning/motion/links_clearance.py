"""Clearance of an arm's links over time, also from triangle meshes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from abi.arm_planning.motion.arm_clearance import ArmClearance
from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arrays import FloatArray, IntArray
from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.robot.any_arm import AnyArm


def links_clearance(
    clearance: ArmClearance,
    motion: ArmMotion,
    arm: AnyArm,
    obstacles: Sequence[Obstacle],
    samples: IntArray,
) -> FloatArray | None:
    """Distance of the arm's links to the obstacles at samples of a motion (k,), [unit].

    Planning measures the distance to a triangle mesh only where it may be the least of all: here it
    is measured at each of these samples, which takes a while.

    Args:
        clearance: of the arm in that motion.
        motion: the motion.
        arm: the arm.
        obstacles: the obstacles.
        samples: numbers of samples (k,).

    Returns:
        The distances, negative inside; None without obstacles.
    """
    if clearance.obstacle < 0:
        return None
    least = clearance.distances[samples].copy()
    if arm.has_exact_bodies:
        ends = arm.place(motion.positions[samples])
        p, q = ends[:, :, 0].reshape(-1, 3), ends[:, :, 1].reshape(-1, 3)
        for mesh in ObstacleSet(tuple(obstacles)).meshes:
            gaps = mesh.segment_distance(p, q).reshape(ends.shape[:2]) - arm.radii
            np.minimum(least, gaps.min(axis=1), out=least)
    return least
