"""Opening of a gripper in one word: the positions of its joints where it is open, or closed."""

from __future__ import annotations

import itertools
import math
from typing import Literal

import numpy as np

from abi.arrays import FloatArray
from abi.errors import SceneError
from abi.robot.urdf.held_joints import planned_joints, positions_held
from abi.robot.urdf.joint import Joint
from abi.robot.urdf.link import Link
from abi.robot.urdf.robot import Robot

Opening = Literal["open", "closed"]

_STATES = {"open": ("open", "opened"), "closed": ("closed", "close")}
"""Names that an SRDF gives such a state, in small letters."""


def gripper_at(field: str, robot: Robot, tip: str, opening: Opening) -> dict[str, float]:
    """Positions by name of the joints of a robot's gripper, [rad] or [m].

    They are those of the state of that name in the robot's SRDF that has joints behind the last
    that is planned. Without one, each joint there is at that end of its range at which the links
    there are farther from, or nearer to, each other.

    Args:
        field: name of what asks for it, for errors.
        robot: the robot.
        tip: name of the link that is the tool.
        opening: what is asked for.

    Raises:
        SceneError: there is no such joint, or several such states differ.
    """
    planned = planned_joints(robot, tip)
    free = {
        one.name: one
        for one in robot.joints
        if one.kind != "fixed" and one.follows is None and one.name not in planned
    }
    behind = _behind(robot, planned)
    fingers = {name: one for name, one in free.items() if one.child in behind}
    named = [
        {name: at for name, at in positions.items() if name in free}
        for state, positions in robot.states.items()
        if state.rpartition("/")[2].lower() in _STATES[opening]
        and not fingers.keys().isdisjoint(positions)
    ]
    if len({tuple(sorted(one.items())) for one in named}) > 1:
        expected = "positions by the names of joints, as its SRDF has several states of that name"
        raise SceneError(field, opening, expected)
    if named:
        return named[0]
    joints = [one for one in fingers.values() if math.isfinite(one.high - one.low)]
    if not joints:
        expected = "positions by the names of joints: none of its joints is behind the planned ones"
        raise SceneError(field, opening, expected)
    found = {}
    for one in joints:
        ends = [positions_held(robot, planned, {one.name: at}) for at in (one.low, one.high)]
        low, high = (_spread(robot, behind, still) for still in ends)
        found[one.name] = one.high if (high > low) == (opening == "open") else one.low
    return found


def _behind(robot: Robot, planned: tuple[str, ...]) -> dict[str, Joint | None]:
    """Links behind the last planned joint, parents first, each with the joint that carries it.

    That of the first one is None.
    """
    found: dict[str, Joint | None] = {}
    for joint in robot.joints:
        if joint.name == planned[-1]:
            found[joint.child] = None
        elif joint.parent in found and joint.coordinate not in planned:
            found[joint.child] = joint
    return found


def _spread(robot: Robot, behind: dict[str, Joint | None], still: dict[str, float]) -> float:
    """Sum of the distances between links where joints are held, [m]."""
    poses: dict[str, FloatArray] = {}
    for link, joint in behind.items():
        if joint is None:
            poses[link] = np.eye(4)
        else:
            moved = joint.motion(still[joint.name]) if joint.name in still else np.eye(4)
            poses[link] = poses[joint.parent] @ joint.origin @ moved
    places = [
        pose[:3, :3] @ _middle(robot.links[link]) + pose[:3, 3] for link, pose in poses.items()
    ]
    pairs = itertools.combinations(places, 2)
    return sum(float(np.linalg.norm(first - second)) for first, second in pairs)


def _middle(link: Link) -> FloatArray:
    """Middle of a link's shapes in its own frame, its origin without any, (3,), [m]."""
    middles = [
        shape.pose[:3, :3] @ shape.vertices.mean(axis=0) + shape.pose[:3, 3]
        if len(shape.vertices)
        else shape.pose[:3, 3]
        for shape in link.shapes
    ]
    return np.mean(middles, axis=0) if middles else np.zeros(3)
