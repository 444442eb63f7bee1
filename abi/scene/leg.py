"""A leg of a sequence of tasks: a waypoint, and what the gripper does there."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field, Strict

from abi.errors import SceneError
from abi.obstacles.pose import Vec3
from abi.scene.arm_end import ArmEnd
from abi.scene.arm_settings import ArmSettings, HeldJoints
from abi.scene.held_axis import HeldAxis
from abi.scene.section import Settings
from abi.scene.settings import Count, Flag

MOST_LEGS = 50
_SAME = 1e-6
"""Difference of two positions of a joint that counts as none, over the larger and 1 [unit]."""


class Leg(Settings):
    """A waypoint: a place of the tool, its pose, joints or a named state.

    It begins in the joints in which the one before ended. At its end the gripper attaches an
    obstacle, by its number from 0, or releases what it holds. ``gripper`` holds it from this leg
    on: ``open``, ``closed``, or positions by the names of its joints, [rad], slides in [unit].

    ``axis`` is a direction that the tip keeps on this leg, within a tolerance.

    The goal of the first leg is the scene's, and so are its gripper and its axis. What its gripper
    does not name is held as ``arm.gripper`` says.
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
    """A scene's fields with goal and axis of its first leg, if it has legs.

    Whether something is taken or set down follows from that leg, too. Its gripper becomes the arm's
    by :func:`held_on_first_leg`, once both are positions.
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
        axis = first.pop("axis", None)
        of_arm = {} if axis is None else {"axis": axis}
        grasps = first.get("attach") is not None or first.get("release") is True
    else:
        return data
    arm = data.get("arm", {})
    fields = vars(arm) if isinstance(arm, Settings) else arm
    if isinstance(fields, Mapping) and fields.get("grasping", False) is not grasps:
        of_arm["grasping"] = grasps
    return {**found, "arm": {**fields, **of_arm}} if of_arm else found


def held_on_first_leg(
    arm: ArmSettings, tasks: tuple[Leg, ...]
) -> tuple[ArmSettings, tuple[Leg, ...]]:
    """The arm, which holds what its first leg names as that says, and the legs without that."""
    if not tasks or tasks[0].gripper is None:
        return arm, tasks
    held = {**arm.gripper, **tasks[0].gripper}
    first = tasks[0].model_copy(update={"gripper": None})
    return arm.model_copy(update={"gripper": held}), (first, *tasks[1:])


def check_held_alike(data: Mapping[str, Any], arm: ArmSettings, metres: float) -> None:
    """Raise a SceneError where a file's arm and its first leg hold a joint at two positions.

    Args:
        data: the fields of the file.
        arm: of the scene, as its first leg holds it.
        metres: one [unit] of the scene in metres.
    """
    given = (data.get("arm") or {}).get("gripper")
    for name, at in arm.held("arm.gripper", given or {}, metres).items():
        if abs(at - arm.gripper[name]) > _SAME * max(1.0, abs(at)):
            expected = f"{name} at {at:g}, as in arm.gripper, or {name} there alone"
            raise SceneError("tasks[0].gripper", data["tasks"][0]["gripper"], expected)
