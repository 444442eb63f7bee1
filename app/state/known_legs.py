"""Legs of a sequence of tasks that are known: the scene of each, where it ends, and how long."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Sequence
from typing import Any, NamedTuple, Self

import numpy as np

from abi.arrays import FloatArray
from abi.errors import AbiError, SceneError
from abi.obstacles.pose import METRES, rotation
from abi.planner.plan import Plan
from abi.planner.task_scenes import scene_from
from abi.robot.urdf_arm import UrdfArm, urdf_arm
from abi.scene.scene import Scene

_LARGEST = 1e6
_NEAR = 1e-5
"""Accepted error where a leg ends, of a joint [rad] or [m], and of the tool over the reach."""


class KnownLeg(NamedTuple):
    """A leg that has been planned.

    Attributes:
        scene: of the leg; that of the first has all tasks.
        joints: positions in which it ends, by name, [rad] or [unit]; empty without a motion.
        duration: of its motion, [s]; 0 without one.
        plan: of the leg; None where it is not at hand.
    """

    scene: Scene
    joints: tuple[tuple[str, float], ...]
    duration: float
    plan: Plan | None = None

    @classmethod
    def of(cls, plan: Plan) -> Self:
        """The leg of a plan."""
        motion = plan.motion
        if motion is None:
            return cls(plan.scene, (), 0.0, plan)
        pairs = zip(motion.joints, motion.positions[-1].tolist(), strict=True)
        return cls(plan.scene, tuple(pairs), float(motion.time[-1]), plan)


def as_data(legs: Sequence[KnownLeg]) -> list[Any]:
    """Number of the leg after ``legs``, where each of them ends and how long it takes: for JSON."""
    return [len(legs), [[dict(one.joints), one.duration] for one in legs]]


def legs_of(whole: Scene, data: object) -> tuple[KnownLeg, ...]:
    """The legs before one that is shown, as untrusted data tell; none if they are of no such scene.

    Args:
        whole: the scene with all tasks, which is that of the first leg.
        data: by :func:`as_data`.
    """
    match data:
        case [int(number), [*given]] if 0 < number < len(whole.tasks):
            ends = [_end(one) for one in given[: len(whole.tasks)]]
            known = [one for one in ends if one is not None]
            if number <= len(known) == len(ends):
                with contextlib.suppress(AbiError):
                    return _legs(whole, known[:number])
    return ()


def _legs(whole: Scene, ends: Sequence[tuple[dict[str, float], float]]) -> tuple[KnownLeg, ...]:
    """The first legs of a sequence by the joints in which each ends, and their durations.

    Raises:
        SceneError: the ends are of other joints, or none of that scene.
    """
    found: list[KnownLeg] = []
    scene = whole
    for number, (joints, duration) in enumerate(ends, start=1):
        settings = scene.arm
        stands = settings.base, settings.exact_axis, scene.unit, settings.base_wxyz
        arm = urdf_arm(settings.robot, settings.tool, *stands, settings.gripper)
        if tuple(joints) != arm.joints:
            raise SceneError("tasks", [*joints], f"the joints {', '.join(arm.joints)}")
        if not _is_at_goal(scene, arm, np.array([*joints.values()])):
            raise SceneError("tasks", joints, f"the goal of leg {number}")
        found.append(KnownLeg(scene, tuple(joints.items()), duration))
        if number < len(ends):
            scene = scene_from(whole, number, scene, arm, joints)
    return tuple(found)


def _is_at_goal(scene: Scene, arm: UrdfArm, positions: FloatArray) -> bool:
    """Check whether joint positions (n,), [rad] or [unit], are what a leg's scene ends in."""
    low, high = arm.limits.T
    if (positions < low - _NEAR).any() or (positions > high + _NEAR).any():
        return False
    end, metres = scene.arm.goal, METRES[scene.unit]
    pose = arm.chain.poses(positions[None] / arm.scales)[0, -1]
    away = np.abs(pose[:, 3] / metres - np.array(scene.goal)).max()
    near = _NEAR * arm.reach + (0.0 if end is None else end.position_tolerance)
    if away > near:
        return False
    if end is not None and end.is_pose:
        turn = pose[:, :3] @ rotation(end.wxyz).T
        cosine = (float(np.trace(turn)) - 1) / 2
        return math.acos(min(max(cosine, -1.0), 1.0)) <= end.angle_tolerance + 2 * _NEAR
    asked = scene.arm.joints_at("goal", metres) or {}
    there = dict(zip(arm.joints, positions / arm.scales, strict=True))
    return all(abs(there[name] - at) <= _NEAR for name, at in asked.items())


def _end(data: object) -> tuple[dict[str, float], float] | None:
    """Joints in which a leg ends, and its duration, of untrusted data."""
    match data:
        case [dict() as joints, int() | float() as duration] if duration >= 0:
            if all(map(_is_number, [*joints.values(), duration])):
                return {str(name): float(at) for name, at in joints.items()}, float(duration)
    return None


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and abs(value) < _LARGEST
