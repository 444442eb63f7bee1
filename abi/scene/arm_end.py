"""Start or goal of an arm, given by more than the position of its tool."""

import math
import sys
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import Field, PlainValidator, Strict, model_serializer, model_validator

from abi.errors import SceneError
from abi.obstacles.pose import Number, Quaternion, Vec3
from abi.robot.urdf.held_joints import held_in_metres, planned_joints
from abi.robot.urdf.joint import Joint
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.urdf_joints import some_of
from abi.scene.section import Settings

_PAST = 1e-9
"""Distance by which a joint may exceed its limit, [rad] or [m]."""
_FEW = 8

ENDS: tuple[Literal["start", "goal"], ...] = ("start", "goal")

Joints = tuple[tuple[str, float], ...] | tuple[float, ...]
"""Positions by the names of joints, or of all planned joints in order."""


def _read(value: object) -> Joints | None:
    """Parse joint positions from plain data.

    Raises:
        ValueError: they are none; says what would be.
    """
    if value is None:
        return None
    named = value if isinstance(value, Mapping) else {}
    rows = list(value) if isinstance(value, list | tuple) else []
    if rows and all(isinstance(row, list | tuple) and len(row) == 2 for row in rows):
        named, rows = dict(rows), []  # as it is kept
    numbers = [*named.values(), *rows]
    largest = sys.float_info.max  # a whole number may be larger; NaN is not within it either
    fits = all(type(number) in (int, float) and abs(number) <= largest for number in numbers)
    if not numbers or not fits or not all(isinstance(name, str) for name in named):
        raise ValueError("a number for each joint, by its name or in their order")
    if named:
        return tuple((name, float(number)) for name, number in named.items())
    return tuple(map(float, rows))


def _plain(joints: Joints | None) -> Any:
    """Joint positions as plain data."""
    if joints is None or not isinstance(joints[0], tuple):
        return None if joints is None else list(joints)
    return {name: number for name, number in joints if isinstance(name, str)}


class ArmEnd(Settings):
    """Start or goal of an arm: its joints, a named state of its SRDF, or the pose of its tool.

    ``joints`` are positions by name, or a list in their order, [rad], slides in [unit]; ``state``
    is the name of one that the SRDF gives. ``position`` [unit] and ``wxyz``, a quaternion, are the
    pose of the tip in the world; ``position_tolerance`` [unit] and ``angle_tolerance`` [rad] say
    how far from it the tip may be.
    """

    joints: Annotated[Joints | None, PlainValidator(_read)] = None
    state: Annotated[str, Strict(), Field(min_length=1, max_length=100)] | None = None
    position: Vec3 | None = None
    wxyz: Quaternion | None = None
    position_tolerance: Annotated[Number, Field(ge=0, le=1e6)] = 0.0
    angle_tolerance: Annotated[Number, Field(ge=0, le=math.pi)] = 0.0

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        given = [self.joints, self.state, self.position]
        if sum(one is not None for one in given) != 1:
            raise ValueError("one of joints, state and position")
        tolerances = self.position_tolerance, self.angle_tolerance
        if self.position is None and (self.wxyz is not None or any(tolerances)):
            raise ValueError("wxyz and tolerances with position alone")
        if self.position is not None and self.wxyz is None:
            raise ValueError("wxyz with position: without an orientation it is a point")
        return self

    @model_serializer
    def _given(self) -> dict[str, Any]:
        """The given fields as plain data."""
        if self.position is None:
            return {"state": self.state} if self.joints is None else {"joints": _plain(self.joints)}
        return {name: getattr(self, name) for name in _OF_POSE}

    @property
    def is_pose(self) -> bool:
        """Whether it is a pose of the tool; otherwise it gives positions of all joints."""
        return self.position is not None

    def positions(self, field: str, robot: Robot, tip: str, metres: float) -> dict[str, float]:
        """Positions of all planned joints by name, [rad] or [m]; not for a pose.

        Args:
            field: its own name in the scene, for errors.
            robot: the robot.
            tip: name of the link that is the tool.
            metres: one [unit] of the scene in metres.

        Raises:
            SceneError: it does not name all planned joints, and no others, within their limits.
        """
        planned = {name: _joint(robot, name) for name in planned_joints(robot, tip)}
        found = self._named(field, robot, tuple(planned), metres)
        missing = [name for name in planned if name not in found]
        if missing:
            expected = f"a position for {some_of(missing, _FEW)}, too"
            raise SceneError(field, some_of([*found], _FEW), expected)
        for name, joint in planned.items():
            if not joint.low - _PAST <= found[name] <= joint.high + _PAST:
                slides = joint.kind == "prismatic"
                low, high = (
                    limit / metres if slides else limit for limit in (joint.low, joint.high)
                )
                value = found[name] / metres if slides else found[name]
                expected = f"{low:g} to {high:g}{'' if slides else ' rad'}, the limits of {name}"
                raise SceneError(f"{field}.joints.{name}", value, expected)
        return {name: min(max(found[name], one.low), one.high) for name, one in planned.items()}

    def _named(
        self, field: str, robot: Robot, planned: tuple[str, ...], metres: float
    ) -> dict[str, float]:
        """Positions by name, [rad] or [m], that are given or belong to the named state."""
        if self.state is not None:
            if self.state not in robot.states:
                known = some_of([*robot.states], _FEW)
                expected = f"a state of its SRDF: {known or 'it has none'}"
                raise SceneError(f"{field}.state", self.state, expected)
            return {name: at for name, at in robot.states[self.state].items() if name in planned}
        plain = _plain(self.joints)
        if isinstance(plain, list):
            if len(plain) != len(planned):
                expected = f"{len(planned)} numbers, one for each of {some_of(planned, _FEW)}"
                raise SceneError(f"{field}.joints", plain, expected)
            plain = dict(zip(planned, plain, strict=True))
        unknown = [name for name in plain if name not in planned]
        if unknown:
            expected = f"a joint that is planned: {some_of(planned, _FEW)}"
            raise SceneError(f"{field}.joints", unknown[0], expected)
        return held_in_metres(robot, plain, metres)


_SAME = 1e-6
"""Difference of two points that counts as none, over the largest coordinate and 1 [unit]."""
_OF_POSE = ("position", "wxyz", "position_tolerance", "angle_tolerance")


def _joint(robot: Robot, name: str) -> Joint:
    return next(joint for joint in robot.joints if joint.name == name)


def with_arm_ends(data: dict[str, Any]) -> dict[str, Any]:
    """A scene's fields; a ``start`` or ``goal`` that is more than a point is moved into its arm."""
    given = {name: data[name] for name in ENDS if isinstance(data.get(name), Mapping)}
    if not given:
        return data
    arm = data.get("arm", {})
    fields = vars(arm) if isinstance(arm, Settings) else arm
    if not isinstance(fields, Mapping):
        return data
    others = {name: value for name, value in data.items() if name not in given}
    return {**others, "arm": {**fields, **given}}


def without_stale_ends(data: dict[str, Any], before: Mapping[str, Any]) -> dict[str, Any]:
    """A changed scene's fields, without the arm's requests for an end that was moved.

    Args:
        data: the fields after the change.
        before: those of the scene that is changed.
    """
    arm, own = data["arm"], before["arm"]
    fields = vars(arm) if isinstance(arm, Settings) else arm
    if not isinstance(fields, Mapping):
        return data
    moved = [
        name
        for name in ENDS
        if data[name] is not before[name]
        and fields.get(name) is not None
        and fields.get(name) is getattr(own, name)
    ]
    return {**data, "arm": {**fields, **dict.fromkeys(moved)}} if moved else data


def check_said_once(data: Mapping[str, Any]) -> None:
    """Raise a SceneError where a scene's file says two things of its ends, or of its first leg."""
    arm, tasks = data.get("arm"), data.get("tasks")
    of_arm = arm if isinstance(arm, Mapping) else {}
    leg = tasks[0] if isinstance(tasks, list | tuple) and tasks else None
    of_leg = leg if isinstance(leg, Mapping) else {}
    pairs = [
        *((name, data.get(name), f"arm.{name}", of_arm.get(name)) for name in ENDS),
        ("goal", data.get("goal"), "tasks[0].goal", of_leg.get("goal")),
        *(
            (f"arm.{name}", of_arm.get(name), f"tasks[0].{name}", of_leg.get(name))
            for name in ("goal", "axis")
        ),
    ]
    for name, value, other, again in pairs:
        unsaid = value is None or again is None or value == {}
        points_alone = other.startswith("arm.") and not isinstance(value, Mapping)
        if not unsaid and not points_alone and value != again:
            raise SceneError(other, again, f"nothing beside {name}, or the same as that")


def check_said_so(data: Mapping[str, Any], arm: Settings, places: Mapping[str, Vec3]) -> None:
    """Raise a SceneError where a point of a file is not where its arm's request puts the tool.

    Args:
        data: the fields of the file.
        arm: of the scene.
        places: the tool's at both ends, by name, [unit].
    """
    for name, place in places.items():
        given = data.get(name)
        if getattr(arm, name) is None or not isinstance(given, list | tuple):
            continue
        away = max(abs(one - other) for one, other in zip(given, place, strict=True))
        if away > _SAME * max(1.0, *map(abs, place)):
            at = [round(one, 6) for one in place]
            expected = f"no point beside arm.{name}, or where that puts the tool, {at}"
            raise SceneError(name, given, expected)
