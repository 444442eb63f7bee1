"""A leg of a sequence of tasks: a waypoint, and what the gripper does there."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field, Strict

from abi.obstacles.pose import Vec3
from abi.scene.arm_end import ArmEnd
from abi.scene.arm_settings import HeldJoints
from abi.scene.held_axis import HeldAxis
from abi.scene.section import Settings
from abi.scene.settings import Count, Flag

MOST_LEGS = 50


class Leg(Settings):
    """A waypoint: a place of the tool, its pose, joints or a named state.

    It begins in the joints in which the one before ended. At its end the gripper attaches an
    obstacle, by its number from 0, or releases what it holds. ``gripper`` holds it from this leg
    on: ``open``, ``closed``, or positions by the names of its joints, [rad], slides in [unit].

    ``axis`` is a direction that the tip keeps on this leg, within a tolerance.

    The goal of the first leg is the scene's, and so are its gripper and its axis.
    """

    name: Annotated[str, Strict(), Field(max_length=80)] = ""
    goal: Vec3 | ArmEnd | None = None
    gripper: HeldJoints | None = None
    attach: Annotated[Count, Field(ge=0)] | None = None
    release: Flag = False
    axis: HeldAxis | None = None

    @property
    def grasps(self) -> bool:
        """Whether an object is taken or released at its end."""
        return self.attach is not None or self.release

    def __hash__(self) -> int:
        gripper = None if self.gripper is None else frozenset(self.gripper.items())
        return hash((self.name, self.goal, gripper, self.attach, self.release, self.axis))


def with_first_leg(data: dict[str, Any]) -> dict[str, Any]:
    """A scene's fields with goal, gripper and axis of its first leg, if it has legs.

    Whether something is taken or set down follows from that leg, too.
    """
    tasks = data.get("tasks")
    if not isinstance(tasks, list | tuple) or not tasks:
        return data
    found, of_arm = data, dict[str, Any]()
    if isinstance(tasks[0], Leg):  # of a scene that is changed
        grasps = tasks[0].grasps
    elif isinstance(tasks[0], dict):
        first = dict(tasks[0])
        goal = first.pop("goal", None)
        found = {**data, "tasks": [first, *tasks[1:]]}
        if goal is not None:
            found["goal"] = goal
        given = ((name, first.pop(name, None)) for name in ("gripper", "axis"))
        of_arm = {name: value for name, value in given if value is not None}
        grasps = first.get("attach") is not None or first.get("release") is True
    else:
        return data
    arm = data.get("arm", {})
    fields = vars(arm) if isinstance(arm, Settings) else arm
    if isinstance(fields, Mapping) and fields.get("grasping", False) is not grasps:
        of_arm["grasping"] = grasps
    return {**found, "arm": {**fields, **of_arm}} if of_arm else found
