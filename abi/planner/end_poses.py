"""Joint positions of a URDF arm at the start or the goal of a scene."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np

from abi.arm_planning.arm_errors import no_joint_motion
from abi.arm_planning.joint_search.joint_space import JointSpace
from abi.arm_planning.joint_search.tool_poses import tool_poses
from abi.arm_planning.motion.arm_clearance import named
from abi.arm_planning.world.chain_distances import inside_meshes, obstacle_distances
from abi.arm_planning.world.link_contact import link_gap
from abi.arrays import FloatArray
from abi.curves.clearance.certificate import Refutation
from abi.obstacles.pose import METRES, rotation
from abi.robot.kinematics.start_poses import REACHED
from abi.robot.urdf_arm import UrdfArm
from abi.scene.scene import Scene

_MOST_POSES = 64
"""Joint positions, at most, that are tried at a start or goal which leaves a choice."""

End = Literal["start", "goal"]


def clear_end_poses(
    space: JointSpace,
    scene: Scene,
    end: End,
    refuted: Callable[[FloatArray], Refutation | None],
) -> FloatArray:
    """Joint positions (k, n) at an end that are proven clear, and inside no closed mesh.

    Args:
        space: the arm and what it keeps clear of.
        scene: the scene.
        end: which end.
        refuted: finds where the arm is not clear along joint positions (k, n), k >= 2.

    Raises:
        NoJointMotion: there are none.
    """
    arm, around = space.arm, space.collision_world
    poses = _poses(arm, scene, end)
    if not len(poses):
        raise no_joint_motion(end)
    kept: list[FloatArray] = []
    first: tuple[FloatArray, int, int] | None = None
    for pose in poses:
        fault = refuted(np.stack([pose, pose]))
        if fault is not None:
            found = pose, fault.capsule, fault.obstacle
        else:
            if not inside_meshes(arm, around, pose):
                kept.append(pose)
                continue
            away, numbers = obstacle_distances(
                arm, around.obstacles, arm.place(pose[None]), allowed=around.allowed
            )
            capsule = int(away[0].argmin())
            found = pose, capsule, int(numbers[0, capsule])
        first = first or found
    if not kept:
        assert first is not None
        pose, capsule, number = first
        pair = arm.capsule_links[capsule], named(number, arm)
        gap = link_gap(arm, around, pose, pair)
        raise no_joint_motion(end, *pair, len(poses), gap=gap, clearance=space.margin)
    return np.array(kept)


def _poses(arm: UrdfArm, scene: Scene, end: End) -> FloatArray:
    """Joint positions (k, n) with the tool where an end asks for it; k may be 0."""
    asked, metres = getattr(scene.arm, end), METRES[scene.unit]
    joints = scene.arm.joints_at(end, metres)
    if joints is not None:
        return np.array([[joints[name] for name in arm.joints]]) * arm.scales
    place = np.array(getattr(scene, end))
    if asked is not None:
        tolerances = asked.position_tolerance, asked.angle_tolerance
        return tool_poses(arm, place, rotation(asked.wxyz), tolerances)[:_MOST_POSES]
    poses = np.array(arm.first_poses(place, _MOST_POSES))
    held = scene.arm.held_axis
    if held is not None:
        aiming = arm.aiming(held.direction).first_poses(place, _MOST_POSES)
        poses = np.concatenate([aiming, poses])
    missed = np.linalg.norm(arm.tool(poses) - place, axis=1)
    return np.asarray(poses[missed <= REACHED * arm.reach])
