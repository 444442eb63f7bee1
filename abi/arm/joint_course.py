"""Joint positions of a URDF arm along a curve, from a chosen or a given start pose."""

from __future__ import annotations

import numpy as np

from abi.arm.chain_distances import floor_distances, obstacle_distances, own_distances
from abi.arm.urdf_arm import REACHED, UrdfArm
from abi.arm.urdf_motion import JointCourse
from abi.arrays import FloatArray, read_only
from abi.curves.curve import ArcLength, Curve
from abi.obstacles.obstacle_set import ObstacleSet

_FEW, _GRID = 41, 1201
"""Points along the curve at which first poses are compared, and the chosen one is followed."""
_ENOUGH = 0.03
"""Clearance, over the arm's reach, beyond which the shorter motion counts."""


def joint_course(
    curve: Curve, arc: ArcLength, arm: UrdfArm, obstacles: ObstacleSet, floor: float
) -> JointCourse:
    """Move an arm's tool along a curve, from the start pose that keeps the arm clearest.

    Among the poses with the tool at the start it takes one from which the whole curve can be
    followed, if possible with all links clear, and among these the one with the least motion.

    Args:
        curve: path of the tool.
        arc: its arc length, above 0.
        arm: the arm.
        obstacles: obstacles that the links must keep clear of.
        floor: height that they must stay above, [unit].
    """
    few = curve(arc.parameter(np.linspace(0.0, arc.length, _FEW)))
    best, least = arm.first_poses(few[0]), (np.inf, np.inf, np.inf)
    chosen = best[0]
    reach = arm.chain.table.reach / arm.metres
    for pose in best:
        positions, missed = arm.follow(pose, few)
        gaps = (
            obstacle_distances(arm, obstacles, positions, _ENOUGH * reach)[0],
            own_distances(arm, positions),
            floor_distances(arm, floor, positions),
        )
        gap = min(float(gap.min(initial=np.inf)) for gap in gaps)
        travel = float(np.abs(np.diff(positions / arm.scales, axis=0)).sum())
        far = float(missed.max())
        rank = (far if far > REACHED * reach else 0.0, -min(gap, _ENOUGH * reach), travel)
        if rank < least:
            chosen, least = pose, rank
    return course_from(chosen, curve, arc, arm)


def course_from(
    pose: FloatArray,
    curve: Curve,
    arc: ArcLength,
    arm: UrdfArm,
    home: FloatArray | None = None,
) -> JointCourse:
    """Move an arm's tool along a curve from a given pose; redundant joints drift ``home``."""
    points = curve(arc.parameter(np.linspace(0.0, arc.length, _GRID)))
    positions, missed = arm.follow(pose, points, home)
    return JointCourse(curve, arc, arm, read_only(positions), read_only(missed))
