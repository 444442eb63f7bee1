"""Positions of a robot's joints that are held while its arm moves, such as a gripper's."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from types import MappingProxyType

from abi.errors import SceneError
from abi.robot.urdf.robot import MOST_JOINTS, Robot, joints_to
from abi.robot.urdf.urdf_joints import some_of

NOT_HELD: Mapping[str, float] = MappingProxyType({})
"""No held positions: every joint that is not planned rests nearest to 0."""
_FIELD = "arm.gripper"
_PAST = 1e-9
"""Distance by which a held joint may exceed its limit, [rad] or [m]."""


def positions_held(
    robot: Robot, planned: Collection[str], wanted: Mapping[str, float]
) -> dict[str, float]:
    """Positions of all movable joints that are not planned, [rad] or [m].

    One that follows another stands where this takes it; of the others, those that ``wanted`` does
    not name rest within their limits nearest to 0.

    Args:
        robot: the robot.
        planned: names of the joints that move, and that others follow.
        wanted: positions by name.

    Raises:
        SceneError: there is no such joint, it follows another or is planned, or the position is
            past its limits.
    """
    free = {
        joint.name: joint
        for joint in robot.joints
        if joint.kind != "fixed" and joint.follows is None and joint.name not in planned
    }
    for name, position in wanted.items():
        if name not in free:
            names = ", ".join([*free][:6]) or "none here"
            raise SceneError(_FIELD, name, f"a joint that is not planned: {names}")
        low, high = free[name].low, free[name].high
        if not math.isfinite(position) or not low - _PAST <= position <= high + _PAST:
            kind = "m" if free[name].kind == "prismatic" else "rad"
            raise SceneError(f"{_FIELD}.{name}", position, f"{low:g} to {high:g} {kind}")
    rest = {name: min(max(0.0, joint.low), joint.high) for name, joint in free.items()}
    still = {**rest, **wanted}
    followers = {
        joint.name: joint.position(still[joint.follows])
        for joint in robot.joints
        if joint.kind != "fixed" and joint.follows in still
    }
    return {**still, **followers}


def planned_joints(robot: Robot, tip: str) -> tuple[str, ...]:
    """Names of the planned joints, which move a tip, from the base on.

    Raises:
        SceneError: there is no such link, no joint moves it, or too many joints do.
    """
    way = joints_to(robot, tip)
    return tuple(dict.fromkeys(joint.coordinate for joint in way if joint.kind != "fixed"))


def held_in_metres(robot: Robot, held: Mapping[str, float], metres: float) -> dict[str, float]:
    """Positions of joints by name in [rad] or [m], converted from another unit of lengths.

    Args:
        robot: the robot.
        held: positions, [rad] or [unit].
        metres: one [unit] in metres.
    """
    slides = {joint.name for joint in robot.joints if joint.kind == "prismatic"}
    return {name: at * (metres if name in slides else 1.0) for name, at in held.items()}


def planned_sentence(robot: Robot, tip: str, wanted: Mapping[str, float]) -> str:
    """Sentence on the link of the tool tip, the joints that move it, and the held ones.

    Args:
        robot: the robot.
        tip: name of the link.
        wanted: positions of joints that are held, [rad] or [m].
    """
    planned = planned_joints(robot, tip)
    still = positions_held(robot, planned, wanted)
    slides = {joint.name: "m" for joint in robot.joints if joint.kind == "prismatic"}
    held = [
        f"{joint.name} at {still[joint.name]:.4g} {slides.get(joint.name, 'rad')}"
        for joint in robot.joints
        if joint.name in still and joint.follows is None
    ]
    text = f"The tool tip is {tip}; {some_of(planned, MOST_JOINTS)} are planned"
    return f"{text}, held: {some_of(held, 6)}." if held else f"{text}."
