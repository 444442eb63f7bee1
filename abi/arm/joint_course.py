"""Joints of a URDF arm along a curve: first pose chosen, joints as splines of the distance."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy

from abi.arm.joint_path_clearance import floor_distances, obstacle_distances, own_distances
from abi.arm.urdf_arm import REACHED, UrdfArm
from abi.arrays import FloatArray, read_only
from abi.curves.curve import ArcLength, Curve
from abi.obstacles.obstacle_set import ObstacleSet

_FEW, _GRID = 41, 1201
"""Points along the curve at which first poses are compared, and the chosen one is followed."""
_ENOUGH = 0.03
"""Clearance, over the arm's reach, beyond which the shorter motion counts."""


@dataclass(frozen=True, eq=False)
class JointCourse:
    """Joints as functions of the distance along a curve.

    Attributes:
        curve: path of the tool.
        arc: its arc length.
        arm: the arm.
        positions: joint positions at equal distances, shape (k, n), [rad] or [unit].
        missed: distance by which the tool misses the curve there, shape (k,), [unit].
    """

    curve: Curve
    arc: ArcLength
    arm: UrdfArm
    positions: FloatArray
    missed: FloatArray

    @property
    def speeds(self) -> FloatArray:
        """Largest speed of each joint, (n,), [rad/s] or [unit/s]."""
        return np.asarray(self.arm.chain.speeds * self.arm.scales)

    @property
    def scales(self) -> FloatArray:
        """A limit of [rad/s²] or [m/s²] in [rad/s²] or [unit/s²], (n,)."""
        return self.arm.scales

    @cached_property
    def _spline(self) -> Any:
        distances = np.linspace(0.0, self.arc.length, len(self.positions))
        return scipy.interpolate.CubicSpline(distances, self.positions)

    def at(self, distances: FloatArray) -> FloatArray:
        """Joint positions at distances (k,), (k, n), within the limits."""
        limits = self.arm.limits
        return np.asarray(np.clip(self._spline(distances), limits[:, 0], limits[:, 1]))


def joint_course(
    curve: Curve, arc: ArcLength, arm: UrdfArm, obstacles: ObstacleSet, floor: float
) -> JointCourse:
    """Lead an arm's tool along a curve, from the first pose that keeps it clearest.

    Of the poses that put the tool on the start it takes one from which the whole curve can be
    followed, with the links clear of everything if possible, and of these with the least motion.

    Args:
        curve: path of the tool.
        arc: its arc length, above 0.
        arm: the arm.
        obstacles: what the links are to keep clear of.
        floor: height that they are to stay above, [unit].
    """
    few = curve(arc.parameter(np.linspace(0.0, arc.length, _FEW)))
    best, least = arm.first_poses(few[0]), (np.inf, np.inf, np.inf)
    chosen = best[0]
    reach = arm.chain.table.reach / arm.metres
    for pose in best:
        positions, missed = arm.follow(pose, few)
        gaps = (
            obstacle_distances(arm, obstacles, positions)[0],
            own_distances(arm, positions),
            floor_distances(arm, floor, positions),
        )
        gap = min(float(gap.min(initial=np.inf)) for gap in gaps)
        travel = float(np.abs(np.diff(positions / arm.scales, axis=0)).sum())
        far = float(missed.max())
        rank = (far if far > REACHED * reach else 0.0, -min(gap, _ENOUGH * reach), travel)
        if rank < least:
            chosen, least = pose, rank
    points = curve(arc.parameter(np.linspace(0.0, arc.length, _GRID)))
    positions, missed = arm.follow(chosen, points)
    return JointCourse(curve, arc, arm, read_only(positions), read_only(missed))
