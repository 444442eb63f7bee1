"""Poses that a motion's file states of the robot besides the motion, compared with the scene's."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import scipy

from abi.arrays import FloatArray
from abi.certification.motion import Motion
from abi.errors import MotionError, short
from abi.robot.kinematics.chain import Chain
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.urdf_joints import some_of

_FAR, _APART = 0.05, 1e-3
"""Distance of the first waypoint from the start state that is refused, and that of a joint which
stands still or follows another, [rad] or [m]."""


def check_start(motion: Motion, robot: Robot, start: Mapping[str, float]) -> None:
    """Raise where the first waypoint is not near the state in which the robot stands."""
    slides = {joint.name for joint in robot.joints if joint.kind == "prismatic"}
    for name in start:
        if name not in motion.joints:
            raise MotionError(
                f"The start state names {name}, which the motion does not move.",
                f"Name some of {some_of(motion.joints, 8)}.",
                joint=name,
            )
    for name, first in zip(motion.joints, motion.positions[0].tolist(), strict=True):
        if abs(first - start.get(name, first)) > _FAR:
            unit = "m" if name in slides else "rad"
            raise MotionError(
                f"Row 1 is far from the start state: {name} is at {first:.4g} {unit} there and "
                f"stands at {start[name]:.4g} {unit}.",
                "Add the way from the start state to the motion.",
                row=1,
                joint=name,
            )


def check_followers(given: Motion, motion: Motion, chain: Chain) -> None:
    """Raise where a file has a joint that follows another elsewhere than that takes it.

    Args:
        given: the motion as its file has it.
        motion: of the chain's coordinates.
        chain: the robot's joints.
    """
    columns = dict(zip(motion.joints, motion.positions.T, strict=True))
    still = {name: np.full(len(motion.times), at) for name, at in chain.held.items()}
    places = {**still, **columns}
    for joint in chain.robot.joints:
        if joint.kind == "fixed" or joint.mimic is None:
            continue
        master, factor, offset = joint.mimic
        follows = factor * places[master] + offset
        if joint.name in given.joints:
            column = given.positions[:, given.joints.index(joint.name)]
            row = int(np.abs(column - follows).argmax())
            if abs(column[row] - follows[row]) > _APART:
                raise MotionError(
                    f"In row {row + 1} {joint.name} is at {column[row]:.4g}, and by its <mimic> it "
                    f"follows {master} to {follows[row]:.4g}.",
                    "Leave its column out if it does, or give a robot without that <mimic>.",
                    row=row + 1,
                    joint=joint.name,
                )
        first = motion.start.joints.get(joint.name, follows[0])
        if abs(first - follows[0]) > max(1.0, abs(factor)) * _FAR:
            raise MotionError(
                f"The file's start state has {joint.name} at {first:.4g}, and by its <mimic> it "
                f"follows {master} to {follows[0]:.4g}.",
                "Correct the state, or give a robot without that <mimic>.",
                joint=joint.name,
            )


def check_state(motion: Motion, chain: Chain, holds: bool) -> None:
    """Raise where a motion's file says otherwise than the scene what stands still, or is held."""
    joints, objects, base = motion.start
    for name, at in chain.held.items():
        given = joints.get(name, at)
        if abs(given - at) > _APART:
            raise MotionError(
                f"The file's start state has {name} at {given:.4g}, and here it stands at "
                f"{at:.4g}.",
                f"Hold it there: arm.gripper of the scene, or a column of the motion for {name}.",
                joint=name,
            )
    if base is not None:
        _check_base(np.array(base), chain)
    if objects and not holds:
        raise MotionError(
            f"The file's robot holds {short(objects[0])}, whose shape is not read.",
            "Give it as arm.attached of the scene.",
        )


def _check_base(base: FloatArray, chain: Chain) -> None:
    """Raise where a motion's file has the robot's root, (7,), elsewhere than the scene."""
    here = next(one.pose for one in chain.carried if one.link == chain.robot.root)
    turn = scipy.spatial.transform.Rotation.from_quat(base[3:]).as_matrix()
    if np.abs(turn - here[:3, :3]).max() > _APART or np.abs(base[:3] - here[:3, 3]).max() > _APART:
        there, stands = (
            f"({', '.join(f'{number:.4g}' for number in place)}) m"
            for place in (base[:3], here[:3, 3])
        )
        raise MotionError(
            f"The file's robot stands at {there}, and here at {stands}, or it is turned otherwise.",
            "Give its place as arm.base and arm.base_wxyz of the scene.",
        )


def unused_state(motion: Motion, robot: Robot) -> list[str]:
    """A sentence on joints of the file's start state that the robot cannot move, if any."""
    moving = {joint.name for joint in robot.joints if joint.kind != "fixed"}
    others = [name for name in motion.start.joints if name not in moving]
    if not others:
        return []
    return [f"Not used of the file's start state, as nothing moves them: {some_of(others, 8)}."]
