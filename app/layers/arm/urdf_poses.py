"""A URDF arm as it is drawn: its poses with the tool as its motion has it, and its regions."""

from __future__ import annotations

import functools
from collections.abc import Sequence

import numpy as np

from abi.arm_planning.branch.followed import Followed
from abi.arm_planning.exclusion.chain_regions import (
    chain_reach,
    chain_shadow,
    configurations_in,
    reach_box,
)
from abi.arm_planning.exclusion.node_configurations import NodeConfigurations
from abi.arm_planning.world.arm_worlds import chain_world
from abi.arrays import FloatArray, read_only
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.pose import Vec3
from abi.planner.plan import Plan
from abi.robot.kinematics.start_poses import REACHED
from abi.robot.urdf_arm import UrdfArm
from app.drawing.lines import rows_at
from app.layers.arm import urdf_arm
from app.layers.arm.arm_playback import samples_of
from app.shared.computed_once import once_a_plan

_OTHERS = 4
"""Other poses, at most: more hide each other."""
_ALIKE = 0.05
"""Links that are nowhere further from each other than this look the same, over the reach."""


SLOW_REGIONS = True
"""They take longer than a frame where the start is another."""
NODES = ("/robot", "base")
bodies, look, build = urdf_arm.bodies, urdf_arm.look, urdf_arm.build
rest_pose, joint_values = urdf_arm.rest_pose, urdf_arm.joint_values


def poses_at(arm: UrdfArm, point: Vec3) -> tuple[FloatArray, ...]:
    """Start poses of an arm that put the tool at a point; none where it is out of reach."""
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
    for other in other_joint_paths(plan, arm):
        at = int(np.searchsorted(other.parameters, time).clip(0, len(other.missed) - 1))
        if other.missed[max(at - 1, 0) : at + 1].max() <= REACHED * arm.reach:
            found.append(rows_at(time, other.parameters, other.joints))
    return np.array(found).reshape(len(found), len(arm.joints))


@once_a_plan
def other_joint_paths(plan: Plan, arm: UrdfArm) -> tuple[Followed, ...]:
    """Joint paths of the other first poses; without a motion these poses alone."""
    motion = plan.motion
    first = end_pose(plan, arm, "start")
    if first is None:
        return ()
    others = _different(arm, first, poses_at(arm, plan.scene.start))[:_OTHERS]
    if motion is None:
        nothing = read_only(np.zeros(1))
        return tuple(Followed(nothing, read_only(pose[None]), nothing) for pose in others)
    rows = samples_of(motion)
    joint_paths = [arm.follow(pose, motion.tool[rows]) for pose in others]
    return tuple(Followed(motion.time[rows], *joint_path) for joint_path in joint_paths)


def region_start(plan: Plan, arm: UrdfArm) -> object:
    """What its regions depend on beside its settings; None where it does not reach the start."""
    pose = end_pose(plan, arm, "start")
    return None if pose is None else (plan.scene.start, *np.round(pose, 6).tolist())


def region(name: str, plan: Plan, arm: UrdfArm) -> FloatArray:
    """Triangles (n, 3, 3) of its ``shadow`` or ``reach``, [unit], world."""
    scene, first = plan.scene, end_pose(plan, arm, "start")
    assert first is not None
    lowest = scene.workspace.min[2]
    if name == "reach":
        box = reach_box(arm, min(lowest, scene.arm.base[2]))
    else:
        box = scene.workspace.min, scene.workspace.max
    configurations = _configurations(arm, tuple(np.round(first, 6).tolist()), scene.start, box)
    if name == "reach":
        return chain_reach(configurations)
    return chain_shadow(arm, configurations, chain_world(arm, ObstacleSet(scene.obstacles), lowest))


@functools.lru_cache(8)
def _configurations(
    arm: UrdfArm, first: tuple[float, ...], start: Vec3, box: tuple[Vec3, Vec3]
) -> NodeConfigurations:
    """Configurations in a box, which stay while obstacles are dragged."""
    return configurations_in(arm, np.array(first), np.array(start, dtype=float), box)


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
