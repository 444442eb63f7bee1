"""The branch of an arm whose motion is sought in the space of its joints, without a mesh.

It is taken where joints, or a pose of the tool, are asked for at start or goal, and where the mesh
of places of the tool leads to no motion. The arm then follows no curve of the tool: its joints
follow one of their own.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from abi import progress
from abi.arm_planning.arm_errors import NoJointMotion
from abi.arm_planning.certificates.chain_certificate import chain_refutation
from abi.arm_planning.joint_search.held_direction import HeldDirection
from abi.arm_planning.joint_search.joint_motion import passage_of, proven_motion
from abi.arm_planning.joint_search.joint_space import JointSpace
from abi.arm_planning.joint_search.joint_spline import spline_near
from abi.arm_planning.joint_search.search_joints import (
    JointSearch,
    JointSearchEffort,
    search_joints,
)
from abi.arm_planning.joint_search.tool_poses import tool_poses
from abi.arm_planning.motion.arm_clearance import named
from abi.arm_planning.motion_law import motion_law
from abi.arm_planning.world.chain_distances import inside_meshes, obstacle_distances
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arm_planning.world.link_contact import link_contact
from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.pose import METRES, rotation
from abi.planner.held_direction_motion import move_holding
from abi.planner.planning_problem import sample_count
from abi.planner.stage_results import TimedMotion
from abi.robot.kinematics.start_poses import REACHED
from abi.robot.urdf_arm import UrdfArm
from abi.scene.arm_end import ENDS
from abi.scene.arm_settings import ArmSettings
from abi.scene.scene import Scene

THOROUGH, HASTY = (
    JointSearchEffort(samples=3_000, shortcuts=60),
    JointSearchEffort(samples=200, shortcuts=10),
)
"""How long a motion is sought at rest, and while somebody waits for one of many plans."""
_MOST_POSES = 64
"""Joint positions, at most, that are tried at a start or goal which leaves a choice."""

End = Literal["start", "goal"]


def asks_for_joints(arm: ArmSettings) -> bool:
    """Check whether a motion is to be sought in the space of the joints alone."""
    asked = any(one is not None for one in (arm.start, arm.goal, arm.held_axis))
    return arm.search == "joints" or (arm.search == "auto" and asked)


def may_search_joints(arm: ArmSettings) -> bool:
    """Check whether a motion may be sought there where the mesh has none.

    The direction of the tip is not held there.
    """
    return arm.model == "urdf" and arm.search == "auto" and arm.avoid and arm.axis is None


def move_joints(
    scene: Scene,
    arm: UrdfArm,
    obstacles: ObstacleSet,
    collision_world: CollisionWorld,
    effort: JointSearchEffort,
) -> tuple[JointSearch, TimedMotion]:
    """Find a motion in the space of an arm's joints, all of it proven clear.

    Args:
        scene: the scene.
        arm: its arm.
        obstacles: its obstacles.
        collision_world: everything around the arm.
        effort: how long to search.

    Returns:
        What was found there, and the motion along a smooth curve near its path.

    Raises:
        NoJointMotion: none was found; tells why.
        DirectionNotHeld: none was found that keeps the direction of the tool.
    """
    progress.tell("searching in the space of the joints")
    space = JointSpace(arm, collision_world, scene.arm.clearance)
    starts, goals = (_clear_poses(space, obstacles, scene, end) for end in ENDS)
    if scene.arm.held_axis is not None:
        part = HeldDirection.of(arm, scene.arm.held_axis)
        return move_holding(part, space, scene, obstacles, (starts, goals), effort)
    search = search_joints(space, starts, goals, effort)
    if search.path is None:
        raise NoJointMotion("path", samples=search.samples)
    if search.length == 0:
        raise NoJointMotion("same")
    spline = spline_near(space, search.path)
    if spline is None:
        raise NoJointMotion("curve")
    passage = passage_of(spline, arm)
    profile = motion_law(passage, scene.motion)
    count = sample_count(profile, scene.motion)
    around = obstacles, collision_world, scene.arm.clearance
    moved = TimedMotion(profile, *proven_motion(passage, profile, count, *around))
    if not moved.is_clear:
        raise NoJointMotion("curve")
    return search, moved


def _clear_poses(space: JointSpace, obstacles: ObstacleSet, scene: Scene, end: End) -> FloatArray:
    """Joint positions (k, n) at an end that are proven clear, and inside no closed mesh.

    Raises:
        NoJointMotion: there are none.
    """
    arm, around = space.arm, space.collision_world
    poses = _poses(arm, scene, end)
    if not len(poses):
        raise NoJointMotion(end)
    kept: list[FloatArray] = []
    first: tuple[FloatArray, int, int] | None = None
    for pose in poses:
        still = np.stack([pose, pose])
        fault = chain_refutation(arm, still, around, space.margin)
        if fault is not None:
            found = pose, fault.capsule, fault.obstacle
        else:
            if not inside_meshes(arm, obstacles, pose, around.allowed):
                kept.append(pose)
                continue
            away, numbers = obstacle_distances(
                arm, obstacles, arm.place(pose[None]), allowed=around.allowed
            )
            capsule = int(away[0].argmin())
            found = pose, capsule, int(numbers[0, capsule])
        first = first or found
    if not kept:
        assert first is not None
        pose, capsule, number = first
        pair = arm.capsule_links[capsule], named(number, arm)
        contact = link_contact(arm, obstacles, around, pose, pair, space.margin)
        raise NoJointMotion(end, *pair, len(poses), contact=contact)
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
