"""Poses that a motion's file states of the robot besides the motion, compared with the scene's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import scipy

from abi.arrays import FloatArray
from abi.certification.motion import Motion
from abi.certification.stated_object import StatedObject
from abi.errors import AbiError, short
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.pose import METRES
from abi.robot.kinematics.chain import Chain
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.urdf_joints import some_of
from abi.scene.scene import Scene

_FAR, _APART, _ROUNDED = 0.05, 1e-3, 1e-6
"""Distance of the first waypoint from the start state that is refused, that of a joint which stands
still or follows another, and that from which on a note tells of either, [rad] or [m]."""


def check_start(motion: Motion, robot: Robot, start: Mapping[str, float]) -> list[str]:
    """Raise where the first waypoint is not near the state in which the robot stands.

    Returns:
        A sentence if it is near, but another.
    """
    slides = {joint.name for joint in robot.joints if joint.kind == "prismatic"}
    for name in start:
        if name not in motion.joints:
            raise AbiError(
                f"The start state names {name}, which the motion does not move.",
                f"Name some of {some_of(motion.joints, 8)}.",
            )
    near = []
    for name, first in zip(motion.joints, motion.positions[0].tolist(), strict=True):
        unit, away = "m" if name in slides else "rad", abs(first - start.get(name, first))
        if away > _FAR:
            raise AbiError(
                f"Row 1 is far from the start state: {name} is at {first:.4g} {unit} there and "
                f"stands at {start[name]:.4g} {unit}.",
                "Add the way from the start state to the motion.",
            )
        if away > _ROUNDED:
            near.append(f"{name} by {away:.2g} {unit}")
    return [f"The way from the start state to row 1 is not proven: {some_of(near)}."] * bool(near)


def check_followers(given: Motion, motion: Motion, chain: Chain) -> list[str]:
    """Raise where a file has a joint that follows another elsewhere than that takes it.

    Args:
        given: the motion as its file has it.
        motion: of the chain's coordinates.
        chain: the robot's joints.

    Returns:
        A sentence if one is elsewhere by no more than rounding in a file.
    """
    columns = dict(zip(motion.joints, motion.positions.T, strict=True))
    still = {name: np.full(len(motion.times), at) for name, at in chain.held.items()}
    places = {**still, **columns}
    near = []
    for joint in chain.robot.joints:
        if joint.kind == "fixed" or joint.follows is None:
            continue
        follows = joint.factor * places[joint.follows] + joint.offset
        if joint.name in given.joints:
            column = given.positions[:, given.joints.index(joint.name)]
            row = int(np.abs(column - follows).argmax())
            away = abs(column[row] - follows[row])
            if away > _APART:
                raise AbiError(
                    f"In row {row + 1} {joint.name} is at {column[row]:.4g}, and by its <mimic> it "
                    f"follows {joint.follows} to {follows[row]:.4g}.",
                    "Leave its column out if it does, or give a robot without that <mimic>.",
                )
            if away > _ROUNDED:
                near.append(f"{joint.name} by {away:.2g}")
        first = motion.start.joints.get(joint.name, follows[0])
        if abs(first - follows[0]) > max(1.0, abs(joint.factor)) * _FAR:
            raise AbiError(
                f"The file's start state has {joint.name} at {first:.4g}, and by its <mimic> it "
                f"follows {joint.follows} to {follows[0]:.4g}.",
                "Correct the state, or give a robot without that <mimic>.",
            )
    return _as_here(near)


def check_state(motion: Motion, chain: Chain, scene: Scene) -> list[str]:
    """Raise where a motion's file says otherwise than the scene what stands still, or is held.

    Returns:
        A sentence if it says so by no more than rounding in a file.
    """
    state, arm, near, notes = motion.start, scene.arm, list[str](), list[str]()
    ranges = {
        joint.name: (joint.low, joint.high) for joint in chain.robot.joints if joint.follows is None
    }
    for name, at in chain.held.items():
        given = state.joints.get(name, at)
        if state.rests and name in ranges:
            given = state.joints.get(name, min(max(0.0, ranges[name][0]), ranges[name][1]))
        if abs(given - at) > _APART:
            raise AbiError(
                f"The file's start state has {name} at {given:.4g}, and here it stands at "
                f"{at:.4g}.",
                f"Hold it there: arm.gripper of the scene, or a column of the motion for {name}.",
            )
        if abs(given - at) > _ROUNDED:
            near.append(f"{name} by {abs(given - at):.2g}")
    if state.base is not None:
        away = _base_away(np.array(state.base), chain)
        near += [f"its base by {away:.2g}"] * (away > _ROUNDED)
    root = state.root or arm.whole_robot.root
    if state.root is not None and root != chain.robot.root:
        raise AbiError(
            f"The file's robot stands on its link {root}, and here on {chain.robot.root}.",
            "Say so as arm.base_link of the scene.",
        )
    if state.obstacles and not scene.obstacles:
        count = f"{state.obstacles} obstacle{'s' * (state.obstacles > 1)}"
        notes.append(f"The file's scene has {count}, and none is compared here: give that scene.")
    if state.objects:
        told, other = _held_otherwise(state.objects, scene)
        notes += told
        near += other
    elif arm.attached is not None and state.attached is None:
        none = (
            "" if state.objects is None else ", and not as in the file, by which it holds nothing"
        )
        notes.append(f"The robot holds the object that is arm.attached of the scene{none}.")
    here = {} if arm.attached is None else arm.attached.model_dump(mode="json")
    if state.attached not in (None, (scene.unit, here)):
        raise AbiError(
            "The file's robot holds an object that the scene's does not.",
            "Give it as arm.attached of the scene.",
        )
    if state.attached is not None and arm.attached is not None:
        tip = arm.model_copy(update={"tip": state.tip}).tool
        if tip != arm.tool:
            raise AbiError(
                f"The file's robot holds its object with {tip}, and the scene's with {arm.tool}.",
                "Give the same arm.tip in both scenes.",
            )
        if isinstance(arm.attached, MeshShape):
            notes.append(f"The held mesh {short(arm.attached.file)} is the one of this scene.")
    return [*notes, *_as_here(near)]


def _held_otherwise(objects: Sequence[StatedObject], scene: Scene) -> tuple[list[str], list[str]]:
    """Raise where a message's robot holds another object than the scene's, or several.

    Returns:
        A sentence if that cannot be compared, and what of it is a little otherwise.
    """
    named = short(objects[0].name)
    attached = scene.arm.attached
    if attached is None:
        raise AbiError(
            f"The file's robot holds {named}, and the scene's nothing.",
            "Give it as arm.attached of the scene.",
        )
    if len(objects) > 1:
        raise AbiError(
            f"The file's robot holds {len(objects)} objects, {named} among them, and the scene's "
            "has room for one.",
            "Give the trajectory alone, and all that is held as one mesh, arm.attached.",
        )
    away = objects[0].distance(attached, METRES[scene.unit], scene.robot, scene.arm.tool)
    if away is None:
        told = f"The file's robot holds {named}, which is not compared with arm.attached."
        return [told], []
    if away > _APART:
        raise AbiError(
            f"The file's robot holds {named}, another object than the scene's or elsewhere: the "
            f"surfaces are {away:.2g} m apart.",
            "Give the same as arm.attached of the scene, in the frame of its tip.",
        )
    return [], [f"{named} by {away:.2g} m"] * (away > _ROUNDED)


def _as_here(near: Sequence[str]) -> list[str]:
    """A sentence on what is here a little otherwise than in the file; none if nothing is."""
    return [f"Proven as it is here, and not as in the file: {some_of(near)}."] * bool(near)


def _base_away(base: FloatArray, chain: Chain) -> float:
    """How far a file's place of the robot's root, (7,), is from here; raises if that is far."""
    here = chain.places[chain.robot.root]
    turn = scipy.spatial.transform.Rotation.from_quat(base[3:]).as_matrix()
    away = max(np.abs(turn - here[:3, :3]).max(), np.abs(base[:3] - here[:3, 3]).max())
    if away > _APART:
        there, stands = (
            f"({', '.join(f'{number:.4g}' for number in place)}) m"
            for place in (base[:3], here[:3, 3])
        )
        raise AbiError(
            f"The file's robot stands at {there}, and here at {stands}, or it is turned otherwise.",
            "Give its place as arm.base and arm.base_wxyz of the scene.",
        )
    return float(away)


def unused_state(motion: Motion, robot: Robot) -> list[str]:
    """A sentence on joints of the file's start state that the robot cannot move, if any."""
    moving = {joint.name for joint in robot.joints if joint.kind != "fixed"}
    others = [name for name in motion.start.joints if name not in moving]
    if not others:
        return []
    return [f"Not used of the file's start state, as nothing moves them: {some_of(others, 8)}."]
