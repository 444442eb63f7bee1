"""Reader of motions as mappings: ROS 2 messages, plans of ours, and plain motions.

A ``trajectory_msgs/msg/JointTrajectory`` may stand alone or inside MoveIt's ``RobotTrajectory`` or
``DisplayTrajectory``. A plan is what ``abi plan`` writes. A plain motion has ``joints``,
``positions`` and, if known, ``times``, ``velocities`` and ``accelerations``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence, Set
from dataclasses import replace
from typing import Any

import numpy as np

from abi.arrays import FloatArray
from abi.certification.motion import Motion, RobotState
from abi.certification.stated_object import StatedObject, is_turn
from abi.errors import AbiError, short
from abi.obstacles.pose import METRES
from abi.robot.urdf.urdf_joints import some_of
from abi.scene.settings import MOST_SAMPLES, SAMPLES

_INSIDE = ("joint_trajectory", "trajectory", "solution", "motion")
_STATES = ("trajectory_start", "start_state")
_DEEPEST = 4
_UNIT = re.compile(r"unit|degree", re.IGNORECASE)
_SI = (
    None,
    False,
    "rad",
    "radian",
    "radians",
    "m",
    "s",
    "si",
    "SI",
    {"angle": "rad", "length": "m"},
)
_POINT = ("positions", "velocities", "accelerations", "time_from_start")
_DURATIONS = (("sec",), ("sec", "nanosec"), ("sec", "nsec"), ("secs",), ("secs", "nsecs"))
"""Names of a duration's seconds, and of the nanoseconds beside them."""
_LARGEST = 10**300
_OF_JOINTS = "name", "position"
_EVENLY = 1e-9
"""Rounding of evenly spaced times that is let pass, over their last one."""
_STATE, _LONGEST_STATE = "state", 500
_MESSAGE = frozenset(
    (
        *("header", "joint_names", "points", _STATE, *_INSIDE, *_STATES),
        *("model_id", "group_name", "planning_time", "error_code"),
        *("multi_dof_joint_trajectory",),
    )
)
_PLAIN = frozenset(
    ("joints", "positions", "velocities", "accelerations", "timed", _STATE, *_STATES)
)
"""Fields of messages that are read, or say nothing of the motion."""


def read_message(data: object, slides: Sequence[str]) -> Motion:
    """Read a motion from plain data, as JSON and YAML hold it.

    Args:
        data: the mapping.
        slides: names of the robot's sliding joints; a plan has their positions in its own unit.

    Raises:
        AbiError: it is none of the known forms, or a part of it is missing or wrong.
    """
    found, starts, notes = data, list[RobotState](), list[str]()
    for _ in range(_DEEPEST):
        if isinstance(found, list) and len(found) == 1:
            found = found[0]
        if not isinstance(found, dict):
            break
        _check_base(found)
        _check_single(found)
        notes += told(found.get(_STATE))
        starts += [_state(found[name]) for name in _STATES if found.get(name) is not None]
        if "joint_names" in found and "points" in found:
            motion = _trajectory(found)
            notes += _unused(found, _MESSAGE)
            return replace(motion, start=_only(starts), notes=(*motion.notes, *notes))
        if "joints" in found and "positions" in found:
            motion, used = _plain(found), {"times" if "times" in found else "time"}
            notes += _unused(found, _PLAIN | used)
            return replace(motion, start=_only(starts), notes=(*motion.notes, *notes))
        if found.get("scene") is not None:
            if not isinstance(found["scene"], dict):
                raise AbiError(f"The file's scene is {short(found['scene'])}, and no scene.")
            planned = found.get("arm")
            if "legs" in found:
                _check_legs(found["scene"].get("tasks"))
                planned = found.get("trajectory")
            if isinstance(planned, dict):
                return _planned(planned, found, slides)
            # a verdict, or a motion beside the scene that it was made in: what moves is not held
            state, beside = _state_of_scene(found["scene"], slides), found.get("motion")
            moved = beside.get("joints") if isinstance(beside, dict) else None
            named = moved if isinstance(moved, list) else []
            held = {name: at for name, at in state.joints.items() if name not in named}
            starts.append(state._replace(joints=held))
        notes += _unused(found, _MESSAGE | {"scene"})
        found = next((found[name] for name in _INSIDE if name in found), None)
    if isinstance(found, list) and len(found) > 1:
        raise AbiError(f"The file holds {len(found)} motions.", "Give one of them.")
    raise AbiError(
        "The file holds no motion.",
        "Give a JointTrajectory with joint_names and points, a plan, or joints and positions.",
    )


def _only(starts: Sequence[RobotState]) -> RobotState:
    """The start state of a motion, of all that its file has.

    Raises:
        AbiError: they differ.
    """
    if any(one != starts[0] for one in starts[1:]):
        raise AbiError("The file has several start states, which differ.", "Keep one of them.")
    return starts[0] if starts else RobotState({})


def told(state: object) -> list[str]:
    """A sentence with what a file says of its motion in words; none if it says nothing."""
    return [f"The file says: {state[:_LONGEST_STATE]}"] if isinstance(state, str) else []


def _unused(message: Mapping[str, Any], known: Set[str]) -> list[str]:
    """A sentence on fields of a file that are not read, none if there are none.

    Raises:
        AbiError: one is a unit that is not read.
    """
    others = [str(name) for name in message if name not in known]
    for name in filter(_UNIT.search, others):
        if message.get(name) not in _SI:
            raise AbiError(
                f"{name[:60]} of the motion is {short(message[name])}, which is not read.",
                "Give angles in rad, lengths in m and times in s.",
            )
    left = [name for name in others if not _UNIT.search(name)]
    return [f"Not used of the file: {some_of(left, 8)}."] if left else []


def _check_base(message: Mapping[str, Any]) -> None:
    """Raise where a message moves a robot's base, or another joint of several coordinates."""
    moved = message.get("multi_dof_joint_trajectory")
    if moved and not (isinstance(moved, dict) and not moved.get("points")):
        names = moved.get("joint_names") if isinstance(moved, dict) else moved
        raise AbiError(
            f"The message moves {short(names)} in space, which is not read.",
            "Give the motion of a robot whose base stands still.",
        )


def _check_single(message: Mapping[str, Any]) -> None:
    """Raise where a message holds two motions."""
    held = [name for name in (*_INSIDE, "points", "positions") if message.get(name)]
    if len(held) > 1 and not isinstance(message.get("scene"), dict):
        raise AbiError(
            f"The file holds more than one motion: {', '.join(held)}.", "Give one of them."
        )


def _state(state: object) -> RobotState:
    """Where a message says that the robot stands, and what it holds."""
    if state is None:
        return RobotState({})
    if not isinstance(state, dict):
        raise AbiError(f"The message's start state is {short(state)}, and no state.")
    held = state.get("attached_collision_objects") or []
    objects = [StatedObject.of(one) for one in (held if isinstance(held, list) else [held])]
    is_said = bool(objects) or state.get("is_diff") is not True  # else it holds what it held before
    joints = state.get("joint_state") or {}
    fields = [joints.get(name) or [] if isinstance(joints, dict) else None for name in _OF_JOINTS]
    names, at = (one if isinstance(one, list | tuple) else None for one in fields)
    if names is None or at is None or len(names) != len(at) or not all(map(_is_number, at)):
        raise AbiError("The message's start state has not one position for each joint.")
    named = dict(zip(_names(names), map(float, at), strict=True))
    base = _base(state.get("multi_dof_joint_state"))
    return RobotState(named, tuple(objects) if is_said else None, base)


def _base(joints: object) -> tuple[float, ...] | None:
    """Where a message says that the robot's root stands; None if it does not."""
    places = joints.get("transforms") if isinstance(joints, dict) else joints
    if not places:
        return None
    place = places[0] if isinstance(places, list) and len(places) == 1 else None
    parts = (
        [place.get(name) for name in ("translation", "rotation")] if isinstance(place, dict) else []
    )
    numbers = [
        part.get(axis) if isinstance(part, dict) else None
        for part, axes in zip(parts, ("xyz", "xyzw"), strict=False)
        for axis in axes
    ]
    if not _is_pose(numbers):
        raise AbiError(
            "The message's start state has no single place of the robot's root in the world.",
            "Give one transform with translation and rotation, or no multi_dof_joint_state.",
        )
    return tuple(map(float, numbers))  # type: ignore[arg-type]


def _trajectory(message: dict[str, Any]) -> Motion:
    """Motion of a ``JointTrajectory``."""
    points = message["points"]
    if not isinstance(points, list) or not all(isinstance(point, dict) for point in points):
        raise AbiError("The trajectory's points are no list of points.")
    names = _names(message["joint_names"])
    times = np.array([_time(k, point) for k, point in enumerate(points, start=1)])
    rates = [_rows(names, points, name) for name in ("velocities", "accelerations")]
    positions = _rows(names, points, "positions")
    if positions is None:
        raise AbiError("The trajectory has no positions.", "Give them for each point.")
    notes = []
    if len(times) and times[0] > 0:
        notes.append(f"The motion begins at {times[0]:g} s; how the robot gets there is not known.")
    given = {name: value for point in points for name, value in point.items() if value != []}
    notes += [one.replace("the file", "the points") for one in _unused(given, {*_POINT})]
    return Motion(names, times, positions, rates[0], rates[1], notes=tuple(notes))


def _plain(data: dict[str, Any]) -> Motion:
    """Motion of ``joints``, ``positions`` and what else is known."""
    names = _names(data["joints"])
    positions = _table("positions", data["positions"])
    rates = [
        None if data.get(name) is None else _table(name, data[name])
        for name in ("velocities", "accelerations")
    ]
    times, timed = data.get("times", data.get("time")), data.get("timed", True) is not False
    if times is None:
        numbers = np.arange(float(len(positions)))
        return Motion(names, numbers, positions, rates[0], rates[1], timed=False)
    return Motion(names, _table("times", [times])[0], positions, rates[0], rates[1], timed=timed)


def _check_legs(tasks: object) -> None:
    """Raise where the legs of a plan change what the robot holds, or its gripper."""
    for number, task in enumerate(tasks if isinstance(tasks, list) else (), start=1):
        named = task if isinstance(task, dict) else {}
        changed = [name for name in ("attach", "release", "gripper") if _is_set(named.get(name))]
        if changed:
            raise AbiError(
                f"Leg {number} has {changed[0]}, which the samples of all legs do not say.",
                "Check the plan by abi verify, or certify one of its legs by itself.",
            )


def _is_set(value: object) -> bool:
    return value is not None and value is not False


def _planned(motion: dict[str, Any], plan: dict[str, Any], slides: Sequence[str]) -> Motion:
    """Motion of a plan, whose slides are in its scene's unit; straight between all its samples.

    A plan may have a part of them alone, and all in its certificate.
    """
    scene, said = plan["scene"], list[str]()
    state, metres = _state_of_scene(scene, slides), METRES[scene.get("unit", "cm")]
    plain = _plain({name: motion.get(name, []) for name in ("joints", "time", "positions")})
    positions, times, certificate = plain.positions, plain.times, motion.get("certificate")
    if isinstance(certificate, dict) and certificate.get("positions") is not None:
        own, positions = positions, _table("positions", certificate["positions"])
        times = np.linspace(times[0], times[-1], len(positions))
        step = max(1, (len(positions) - 1) // max(len(own) - 1, 1))
        if not (
            np.array_equal(own, positions[::step])
            and np.allclose(plain.times, times[::step], rtol=0.0, atol=_EVENLY * times[-1])
        ):
            raise AbiError(
                "The plan's positions are not those of its certificate, evenly in time.",
                "Give the plan as abi plan wrote it.",
            )
    elif len(times) < _samples_of(plan):
        raise AbiError(
            "The plan has only some of the samples of its motion, which moves otherwise between.",
            "Write it by abi plan --full, or give the motion that abi export writes of its scene.",
        )
    error = plan.get("error")
    if motion.get("certified") is False:
        said.append("The arm's motion is NOT proven clear.")
    if isinstance(error, dict) and isinstance(error.get("message"), str):
        said.append(error["message"])
    scale = [metres if name in slides else 1.0 for name in plain.joints]
    notes = tuple(told(" ".join(said) or None))
    return Motion(plain.joints, times, positions * np.array(scale), start=state, notes=notes)


def _samples_of(plan: Mapping[str, Any]) -> int:
    """Number of samples of a plan's motion as its scene asks for; 0 if it does not say."""
    asked, timing = plan["scene"].get("motion"), plan.get("timing")
    if not isinstance(asked, dict) or not isinstance(timing, dict):
        return 0
    step, duration, count = asked.get("time_step"), timing.get("duration"), asked.get("samples")
    if step is None:
        return count if isinstance(count, int) else SAMPLES
    known = _is_number(duration) and _is_number(step) and step > 0
    return round(min(duration / step, MOST_SAMPLES)) + 1 if known else 0


def _state_of_scene(scene: dict[str, Any], slides: Sequence[str]) -> RobotState:
    """Where the scene of a plan has its robot, what this holds, and its joints beside the arm."""
    unit, arm = scene.get("unit", "cm"), scene.get("arm")
    if not isinstance(unit, str) or unit not in METRES:
        raise AbiError(f"The unit of the plan's scene is {short(unit)}.", "Use m, cm or mm.")
    if arm is None:
        return RobotState({})
    if not isinstance(arm, dict):
        raise AbiError(
            f"The arm of the plan's scene is {short(arm)}.", "Give the plan as abi plan wrote it."
        )
    metres = METRES[unit]
    base, wxyz = arm.get("base"), arm.get("base_wxyz", [1, 0, 0, 0])
    numbers = [*base, *wxyz] if isinstance(base, list) and isinstance(wxyz, list) else []
    fields = "gripper", "base_link", "attached", "tip"
    held, root, attached, tip = (arm.get(name) for name in fields)
    held, obstacles = {} if held is None else held, scene.get("obstacles")
    if not (
        _is_pose(numbers)
        and isinstance(held, dict)
        and all(map(_is_number, held.values()))
        and isinstance(root, str | None)
        and isinstance(attached, dict | None)
        and isinstance(tip, str | None)
    ):
        raise AbiError(
            "The plan's scene does not say where its arm stands, and what this holds.",
            "Give the plan as abi plan wrote it.",
        )
    x, y, z, w, *turned = map(float, numbers)
    return RobotState(
        joints={name: at * (metres if name in slides else 1.0) for name, at in held.items()},
        objects=(),
        base=(x * metres, y * metres, z * metres, *turned, w),
        root=root or "",
        attached=None if attached is None else (unit, attached),
        rests=True,
        tip=tip,
        obstacles=len(obstacles) if isinstance(obstacles, list) else 0,
    )


def _is_pose(numbers: Sequence[object]) -> bool:
    """Whether these are a position and a quaternion that can be one of length 1."""
    if len(numbers) != 7 or not all(map(_is_number, numbers)):
        return False
    exact = [float(one) for one in numbers]  # type: ignore[arg-type]
    return all(map(math.isfinite, exact)) and is_turn(exact[3:])


def _names(value: object) -> tuple[str, ...]:
    if not isinstance(value, list | tuple) or not all(isinstance(name, str) for name in value):
        raise AbiError(f"The joints' names are {short(value)}.", "Give a list of names.")
    return tuple(value)


def _time(row: int, point: dict[str, Any]) -> float:
    """Time of a point [s], a duration of ROS 2 or ROS 1, or a number."""
    value = point.get("time_from_start")
    if isinstance(value, dict):
        names = next((one for one in _DURATIONS if {*one} == {*value}), ())
        if names and all(map(_is_number, value.values())):
            seconds, *rest = (float(value[name]) for name in names)
            return seconds + 1e-9 * sum(rest)
    if _is_number(value):
        return float(value)  # type: ignore[arg-type]
    raise AbiError(
        f"In row {row} time_from_start is {short(value)}.",
        "Give sec and nanosec, or a number of seconds.",
    )


def _rows(names: tuple[str, ...], points: list[dict[str, Any]], name: str) -> FloatArray | None:
    """Values of all points (m, n), None where none has any.

    Raises:
        AbiError: some points have them and others do not, or a number is missing.
    """
    given = [point.get(name) or [] for point in points]
    if not any(given):
        return None
    for row, values in enumerate(given, start=1):
        if not isinstance(values, list | tuple) or len(values) != len(names):
            count = len(values) if isinstance(values, list | tuple) else 1
            raise AbiError(
                f"Row {row} has {count} {name} for {len(names)} joints.",
                "Give one for each joint in every row"
                + ("." if name == "positions" else f", or no {name} at all."),
            )
        for joint, value in zip(names, values, strict=True):
            if not _is_number(value):
                raise AbiError(
                    f"In row {row} {name} of {joint} holds {short(value)}, which is no number.",
                )
    return np.array(given, dtype=float)


def _table(name: str, value: object) -> FloatArray:
    """Rows of equally many numbers."""
    if not isinstance(value, list | tuple) or not value:
        raise AbiError(f"The motion's {name} are {short(value)}.", "Give a row a waypoint.")
    for row, values in enumerate(value, start=1):
        if not isinstance(values, list | tuple) or not all(map(_is_number, values)):
            raise AbiError(f"Row {row} of {name} holds something else than numbers.")
        if len(values) != len(value[0]):
            raise AbiError(
                f"Row {row} of {name} has {len(values)} numbers, and the first {len(value[0])}.",
            )
    return np.array(value, dtype=float)


def _is_number(value: object) -> bool:
    if isinstance(value, int) and not isinstance(value, bool):
        return abs(value) < _LARGEST  # a whole number of Python may be larger than any other
    return isinstance(value, float)
