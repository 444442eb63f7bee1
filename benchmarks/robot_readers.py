"""Poses of links by other readers of URDF: yourdfpy, Pinocchio, and the numbers of the file."""

from __future__ import annotations

import io
import types
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
import yourdfpy

from abi.arrays import FloatArray
from abi.robot.kinematics.chain import Chain
from abi.robot.urdf.robot import MOST_JOINTS, Robot
from tests.random_robots import link_poses, robot_of

Poses = Mapping[str, FloatArray]
"""Pose of every link in the root, (4, 4)."""

PosesAt = Callable[[Mapping[str, float]], Poses]
"""Poses at positions of the joints that move by themselves."""


def poses_of(robot: Robot, state: Mapping[str, float]) -> Poses:
    """Poses of all links, as planning has them, at positions of the joints."""
    count = {robot.root: 0}
    for joint in robot.joints:
        count[joint.child] = count[joint.parent] + (joint.kind != "fixed")
    tips = [link for link, moving in count.items() if 1 <= moving <= MOST_JOINTS]
    if not tips:
        found = {robot.root: np.eye(4)}
        for joint in robot.joints:
            found[joint.child] = found[joint.parent] @ joint.origin
        return found
    planned = Chain.of(robot, tips[-1]).names
    held = {name: at for name, at in state.items() if name not in planned}
    chain = Chain.of(robot, tips[-1], held=held)
    frames = chain.poses(np.array([[state[name] for name in chain.names]]))[0]
    found = {}
    for one in chain.carried:
        frame = np.vstack([frames[one.frame], [0, 0, 0, 1]]) if one.frame >= 0 else np.eye(4)
        found[one.link] = frame @ one.pose
    return found


def by_yourdfpy(content: bytes) -> PosesAt:
    """Those of yourdfpy."""
    robot = yourdfpy.URDF.load(
        io.BytesIO(content), load_meshes=False, build_collision_scene_graph=False
    )
    return partial(_yourdfpy_poses, robot)


def _yourdfpy_poses(robot: yourdfpy.URDF, state: Mapping[str, float]) -> Poses:
    robot.update_cfg({name: state.get(name, 0.0) for name in robot.actuated_joint_names})
    return {link: robot.get_transform(link) for link in robot.link_map}


def by_pinocchio(content: bytes) -> PosesAt:
    """Those of Pinocchio, which is of the extra ``bench``."""
    import pinocchio

    model = pinocchio.buildModelFromXML(content.decode(), True)
    return partial(_pinocchio_poses, pinocchio, model, model.createData())


def _pinocchio_poses(
    pinocchio: types.ModuleType, model: Any, data: Any, state: Mapping[str, float]
) -> Poses:
    at = pinocchio.neutral(model)
    for name, joint in zip(model.names, model.joints, strict=True):
        if name in state and joint.nq:
            position = state[name]
            turning = (np.cos(position), np.sin(position))  # of a joint without limits
            at[joint.idx_q : joint.idx_q + joint.nq] = position if joint.nq == 1 else turning
    pinocchio.framesForwardKinematics(model, data, at)
    return {
        frame.name: data.oMf[number].homogeneous.copy()
        for number, frame in enumerate(model.frames)
        if frame.type == pinocchio.FrameType.BODY
    }


def by_numbers(content: bytes) -> PosesAt:
    """Those that the file's own numbers give, multiplied out."""
    return partial(link_poses, robot_of(content))


READERS: Mapping[str, Callable[[bytes], PosesAt]] = {
    "yourdfpy": by_yourdfpy,
    "Pinocchio": by_pinocchio,
    "its numbers": by_numbers,
}
"""Readers by their names, from the content of a URDF."""
