"""Scenes of the legs of a sequence of tasks, each from where the last leg left arm and objects."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import scipy

from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import Obstacle
from abi.obstacles.pose import rotation
from abi.planner.plan import Plan
from abi.robot.any_arm import AnyArm
from abi.scene.held_axis import plain_axis
from abi.scene.scene import Scene
from abi.scene.without_obstacles import without_obstacles


def first_scene(scene: Scene) -> Scene:
    """Scene of the first leg: the scene itself, without its tasks."""
    return scene.replace(tasks=[], arm={"grasping": scene.arm.grasping})


def number_in_scene(scene: Scene, leg: int, obstacle: int) -> int:
    """Number of an obstacle in the scene of all tasks; while one is held, those after it have less.

    Args:
        scene: the scene with all tasks.
        leg: number of a leg, from 0.
        obstacle: its number in that leg's scene, from 0.
    """
    held = None
    for task in scene.tasks[:leg]:
        held = None if task.release else held if task.attach is None else task.attach
    return obstacle + (held is not None and obstacle >= held)


def next_scene(scene: Scene, number: int, last: Plan) -> Scene:
    """Scene of a leg, from the end of the one before.

    While an object is held, the obstacles after it have numbers that are less by one.

    Args:
        scene: the scene with all tasks.
        number: of the leg, from 1.
        last: plan of the leg before, with a motion.
    """
    motion = last.motion
    assert motion is not None
    assert last.arm is not None
    joints = dict(zip(motion.joints, motion.positions[-1].tolist(), strict=True))
    return scene_from(scene, number, last.scene, last.arm, joints)


def scene_from(
    scene: Scene, number: int, last: Scene, arm_before: AnyArm, joints: Mapping[str, float]
) -> Scene:
    """Scene of a leg, from the joints in which the one before ended.

    Args:
        scene: the scene with all tasks.
        number: of the leg, from 1.
        last: scene of the leg before.
        arm_before: its arm.
        joints: positions in which it ended by name, in the arm's order, [rad] or [unit].
    """
    leg = scene.tasks[number]
    tool = _tool_pose(arm_before, np.array([*joints.values()]))
    here = _after_gripper(scene, number - 1, last, tool)
    arm: dict[str, Any] = {
        "start": {"joints": dict(joints)},
        "goal": None,
        "axis": plain_axis(leg.axis),
        "grasping": leg.grasps or scene.tasks[number - 1].grasps,
    }
    if leg.gripper is not None:
        arm["gripper"] = {**last.arm.gripper, **leg.gripper}
    goal = leg.goal if isinstance(leg.goal, tuple) or leg.goal is None else leg.goal.model_dump()
    return here.replace(goal=goal, arm=arm, tasks=[])


def _after_gripper(scene: Scene, number: int, here: Scene, tool: FloatArray) -> Scene:
    """The scene ``here`` of a leg after what the gripper does at its end.

    Args:
        scene: the scene with all tasks.
        number: of the leg.
        here: its scene.
        tool: pose of the tool at its end, (4, 4), [unit].
    """
    leg = scene.tasks[number]
    if leg.attach is not None:
        inverse = np.linalg.inv(tool).astype(np.float64)
        held = _moved(here.obstacles[leg.attach], inverse)
        change = without_obstacles(here, (leg.attach,))
        return here.replace(**{**change, "arm": {**change.get("arm", {}), "attached": held}})
    if leg.release:
        assert here.arm.attached is not None
        taken = [one.attach for one in scene.tasks[:number] if one.attach is not None]
        obstacles = [*here.obstacles]
        place = taken[-1] if taken else len(obstacles)
        obstacles.insert(place, _moved(here.arm.attached, tool))
        # all obstacles have the numbers again that the scene has for them
        arm = {"attached": None, "allowed": scene.arm.allowed}
        return here.replace(obstacles=obstacles, arm=arm)
    return here


def _tool_pose(arm: AnyArm, joints: FloatArray) -> FloatArray:
    """World from tip at joint positions (n,), (4, 4), [unit]."""
    pose = np.eye(4)
    pose[:3] = arm.chain.poses(joints[None] / arm.scales)[0, -1]
    pose[:3, 3] /= arm.metres
    return pose


def _moved(shape: Obstacle, pose: FloatArray) -> Obstacle:
    """A shape in another frame, whose pose is that of the shape's frame there, (4, 4), [unit]."""
    turn = scipy.spatial.transform.Rotation.from_matrix(pose[:3, :3] @ rotation(shape.wxyz))
    x, y, z, w = turn.as_quat().tolist()
    position = (pose[:3, :3] @ np.array(shape.position) + pose[:3, 3]).tolist()
    place = {"position": tuple(position), "wxyz": (w, x, y, z)}
    return shape.model_copy(update=place)
