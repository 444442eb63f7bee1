"""Poses of links by other readers of URDF: yourdfpy, Pinocchio, and the numbers of the file."""

from __future__ import annotations

import io
import types
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np
import yourdfpy

from abi.arrays import FloatArray
from abi.robot.kinematics.chain import Chain
from abi.robot.urdf.robot import MOST_JOINTS, Robot
from tests.random_robots import link_poses, robot_of

States = Mapping[str, FloatArray]
"""Positions (k,) of each joint that moves by itself, [rad] or [m]."""

Poses = Mapping[str, FloatArray]
"""Poses (k, 4, 4) of every link in the root, [m], at each of some states."""

PosesAt = Callable[[States], Poses]


def poses_of(robot: Robot, states: States) -> Poses:
    """Poses of all links as planning has them, all joints that move by themselves planned."""
    if not states:
        still = {robot.root: np.eye(4)[None]}
        for joint in robot.joints:
            still[joint.child] = still[joint.parent] @ joint.origin
        return still
    return _poses_of_chain(Chain.moved_by(robot, tuple(states)), states)


def poses_with_tip(robot: Robot, state: Mapping[str, float]) -> Poses:
    """The same at one state, with the joints to one tip planned and all others held."""
    count = {robot.root: 0}
    for joint in robot.joints:
        count[joint.child] = count[joint.parent] + (joint.kind != "fixed")
    tips = [link for link, moving in count.items() if 1 <= moving <= MOST_JOINTS]
    planned = Chain.of(robot, tips[-1]).names
    held = {name: at for name, at in state.items() if name not in planned}
    chain = Chain.of(robot, tips[-1], held=held)
    return _poses_of_chain(chain, {name: np.array([state[name]]) for name in planned})


def _poses_of_chain(chain: Chain, states: States) -> Poses:
    frames = chain.poses(np.stack([states[name] for name in chain.names], axis=1))
    last = np.broadcast_to([0.0, 0, 0, 1], (*frames.shape[:2], 1, 4))
    frames = np.concatenate([frames, last], axis=2)
    still = np.broadcast_to(np.eye(4), (len(frames), 4, 4))
    return {
        link: (frames[:, frame] if frame >= 0 else still) @ chain.places[link]
        for link, frame in chain.frames.items()
    }


def by_yourdfpy(content: bytes) -> PosesAt:
    """Those of yourdfpy."""
    robot = yourdfpy.URDF.load(
        io.BytesIO(content), load_meshes=False, build_collision_scene_graph=False
    )
    return partial(_yourdfpy_poses, robot)


def _yourdfpy_poses(robot: yourdfpy.URDF, states: States) -> Poses:
    found = []
    for state in _each(states):
        robot.update_cfg({name: state.get(name, 0.0) for name in robot.actuated_joint_names})
        found.append([robot.get_transform(link) for link in robot.link_map])
    return dict(zip(robot.link_map, np.swapaxes(found, 0, 1), strict=True))


def _each(states: States) -> Iterator[Mapping[str, float]]:
    """The states one by one; one of no joint if none moves."""
    rows = np.stack([*states.values()], axis=1) if states else np.zeros((1, 0))
    for row in rows.tolist():
        yield dict(zip(states, row, strict=True))


def by_pinocchio(content: bytes) -> PosesAt:
    """Those of Pinocchio, which is of the extra ``bench``."""
    import pinocchio

    model = pinocchio.buildModelFromXML(content.decode(), True)
    return partial(_pinocchio_poses, pinocchio, model, model.createData())


def _pinocchio_poses(pinocchio: types.ModuleType, model: Any, data: Any, states: States) -> Poses:
    bodies = {
        frame.name: number
        for number, frame in enumerate(model.frames)
        if frame.type == pinocchio.FrameType.BODY
    }
    found = []
    for state in _each(states):
        at = pinocchio.neutral(model)
        for name, joint in zip(model.names, model.joints, strict=True):
            if name in state and joint.nq:
                position = state[name]
                turning = (np.cos(position), np.sin(position))  # of a joint without limits
                at[joint.idx_q : joint.idx_q + joint.nq] = position if joint.nq == 1 else turning
        pinocchio.framesForwardKinematics(model, data, at)
        found.append([data.oMf[number].homogeneous for number in bodies.values()])
    return dict(zip(bodies, np.swapaxes(found, 0, 1), strict=True))


def by_numbers(content: bytes) -> PosesAt:
    """Those that the file's own numbers give, multiplied out."""
    return partial(link_poses, robot_of(content))


READERS: Mapping[str, Callable[[bytes], PosesAt]] = {
    "yourdfpy": by_yourdfpy,
    "Pinocchio": by_pinocchio,
    "its numbers": by_numbers,
}
"""Readers by their names, from the content of a URDF."""

MOST_STATES: Mapping[str, int] = {"yourdfpy": 50}
"""States at which a reader is asked at most, where it takes long for each."""
