"""Poses of a URDF arm beside that of its motion: those that put the tool at the same place."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from abi.arrays import FloatArray, read_only
from abi.obstacles.pose import Vec3
from abi.planner.plan import Plan
from abi.robot.urdf_arm import REACHED, UrdfArm
from app.drawing.lines import rows_at
from app.layers.arm.arm_playback import samples_of
from app.shared.once_a_plan import once_a_plan

_OTHERS = 4
"""Other poses, at most: more hide each other."""
_ALIKE = 0.05
"""Links that are nowhere further from each other than this look the same, over the reach."""


class OtherPoses(NamedTuple):
    """Another pose that leads the tool along the motion.

    Attributes:
        time: of the samples, (k,), [s].
        positions: joints, (k, n), [rad] or [unit].
        missed: by how much the tool is beside its place, (k,), [unit].
    """

    time: FloatArray
    positions: FloatArray
    missed: FloatArray


def poses_at(arm: UrdfArm, point: Vec3) -> tuple[FloatArray, ...]:
    """Those that put the tool at the point; none where it is out of reach."""
    place = np.array(point, dtype=float)
    poses = arm.first_poses(place)
    missed = np.linalg.norm(arm.tool(np.stack(poses)) - place, axis=1)
    return tuple(
        pose for pose, by in zip(poses, missed.tolist(), strict=True) if by <= 1e-3 * arm.reach
    )


def end_pose(plan: Plan, arm: UrdfArm, end: str) -> FloatArray | None:
    """Pose (n,) with the tool at the ``start`` or ``goal``; None where that is out of reach."""
    if plan.motion is not None:
        pose: FloatArray = plan.motion.positions[0 if end == "start" else -1]
        return pose
    return next(iter(poses_at(arm, getattr(plan.scene, end))), None)


def other_poses(plan: Plan, arm: UrdfArm, time: float) -> FloatArray:
    """Other poses (k, n) that put the tool where it is at a time [s]."""
    found = []
    for other in other_joint_paths(plan):
        at = int(np.searchsorted(other.time, time).clip(0, len(other.time) - 1))
        if other.missed[max(at - 1, 0) : at + 1].max() <= REACHED * arm.reach:
            found.append(rows_at(time, other.time, other.positions))
    return np.array(found).reshape(len(found), len(arm.joints))


@once_a_plan
def other_joint_paths(plan: Plan) -> tuple[OtherPoses, ...]:
    """Joint paths of the other first poses; without a motion these poses alone."""
    arm, motion = plan.arm, plan.motion
    assert isinstance(arm, UrdfArm)
    first = end_pose(plan, arm, "start")
    if first is None:
        return ()
    others = _different(arm, first, poses_at(arm, plan.scene.start))[:_OTHERS]
    if motion is None:
        nothing = read_only(np.zeros(1))
        return tuple(OtherPoses(nothing, read_only(pose[None]), nothing) for pose in others)
    rows = samples_of(motion)
    joint_paths = [arm.follow(pose, motion.tool[rows]) for pose in others]
    return tuple(OtherPoses(motion.time[rows], *joint_path) for joint_path in joint_paths)


def _different(arm: UrdfArm, first: FloatArray, poses: Sequence[FloatArray]) -> list[FloatArray]:
    """Poses that do not look like the first, nor like one before."""
    kept: list[FloatArray] = []
    seen = [arm.place(first[None])[0]]
    for pose in poses:
        ends = arm.place(pose[None])[0]
        if all(np.abs(ends - other).max() > _ALIKE * arm.reach for other in seen):
            kept.append(pose)
            seen.append(ends)
    return kept
