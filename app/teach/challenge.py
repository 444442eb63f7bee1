"""Challenges: a scene, and a goal for whoever opens the link."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Annotated

from pydantic import Field, ValidationError

from abi.planner.plan import Plan
from abi.scene.arm_settings import ArmSettings
from abi.scene.scene import Scene
from abi.scene.section import Settings
from app.shared.computed_once import once_a_plan
from app.state.frame import Frame
from app.teach.lesson import Condition
from app.teach.measures import MEASURES, text
from app.teach.result_code import FLOOR, fingerprint, result_code
from app.ui import style

_SHORTER = 0.97
_FARTHER = 1 / 30
"""Distance to gain, over the workspace's longest side."""
_LEAST_GAP = 0.005
"""Relative excess over the optimum below which there is nothing left to gain."""
_OF_ARM = tuple(f"arm.{name}" for name in ArmSettings.model_fields)
_SAME = "with start, goal, obstacles, floor and arm as they are"
MAY_CHANGE = (
    *("workspace", "mesh", "search", "spline", "quadratic", "motion"),
    *("arm.base", "arm.base_wxyz", "arm.q5", "arm.elbow", "arm.search", "arm.avoid"),
    "arm.clearance",
)
"""Fields of a scene that are a student's own choice where nothing else is said."""
TASK = tuple(
    name
    for section in (*Scene.model_fields, FLOOR)
    for name in (_OF_ARM if section == "arm" else (section,))
    if name not in ("version", *MAY_CHANGE)
)
"""What defines the planning problem: all fields but those of :data:`MAY_CHANGE`, and the floor."""
_ARM_OF_TASK = frozenset(TASK) & {*_OF_ARM}
_COMPLETE = Condition(measure="plan.complete", at_least=1)
_TOOL_COMPLETE = Condition(measure="plan.tool_complete", at_least=1)
_CODE = ' style="overflow-wrap:anywhere;user-select:all;pointer-events:auto"'
"""Style of a code to hand in: shown whole at any width, selected by one click."""


class Challenge(Settings):
    """A challenge: conditions that a plan has to meet.

    Attributes:
        text: in words.
        until: conditions, all of which must hold.
        task: fingerprint of what must stay; empty where all may change.
        scene: name of the scene that it is for; empty for that of the link.
        keep: fields of the scene that must stay, where any must.
        homework: whether whoever meets it gets a code to hand in.
    """

    text: Annotated[str, Field(max_length=200)]
    until: Annotated[tuple[Condition, ...], Field(min_length=1, max_length=4)]
    task: Annotated[str, Field(max_length=64)] = ""
    scene: str = ""
    keep: Annotated[tuple[str, ...], Field(max_length=64)] = TASK
    homework: bool = False

    def is_met(self, frame: Frame) -> bool:
        """Check whether all conditions hold now."""
        return self.keeps_task(frame) and all(one.holds(frame) for one in self.until)

    def keeps_task(self, frame: Frame) -> bool:
        """Check whether all that must stay is as it was."""
        return self.task in ("", _task(frame.plan, self.keep))

    def html(self, met: bool, frame: Frame) -> str:
        """The challenge and the present number, as HTML for the layer over the scene."""
        colour = style.readable(style.GOOD if met else style.BAD)
        now = ", ".join(text(one.measure, frame) for one in self.until if one.measure in _SHOWN)
        sign = f'<b style="color:{colour}">{"✓ Done" if met else "Challenge"}:</b>'
        number = f" (now {now})" if now else ""
        moved = (
            "" if self.keeps_task(frame) else f" <b>{html.escape(self.changed)} have changed.</b>"
        )
        code = _code(frame.plan, self.keep) if met and self.homework else ""
        handed_in = f"<br>To hand in: <code{_CODE}>{code}</code>" if code else ""
        return f"{sign} {html.escape(self.text)}{number}.{moved}{handed_in}"

    @property
    def changed(self) -> str:
        """Names of protected parts that may have been changed, the arm's usual ones as one."""
        names = ("arm" if one in _ARM_OF_TASK else one for one in self.keep if one != "unit")
        *most, last = dict.fromkeys(names) or ["units"]
        return (f"{', '.join(most)} or {last}" if most else last).capitalize()


@once_a_plan
def _task(plan: Plan, keep: tuple[str, ...]) -> str:
    """Fingerprint of the protected fields of a plan's scene."""
    return fingerprint(plan.scene, keep)


@once_a_plan
def _code(plan: Plan, keep: tuple[str, ...]) -> str:
    """Code of a plan's scene to hand in."""
    return result_code(plan.scene, keep)


_SHOWN = {"curve.length", "arm.clearance"}


def _shorter(frame: Frame) -> Challenge | None:
    length, best = MEASURES["curve.length"](frame), MEASURES["optimum.length"](frame)
    if length is None or best is None or length < (1 + _LEAST_GAP) * best:
        return None
    most = float(f"{max(_SHORTER * length, (length + best) / 2):.4g}")
    wording = f"make the arm's curve shorter: {most} {frame.plan.scene.unit} or less, {_SAME}"
    return _with_arm(frame, wording, Condition(measure="curve.length", at_most=most), still=True)


def _quadratic(frame: Frame) -> Challenge | None:
    condition = Condition(measure="quadratic.clear", at_least=1)
    wording = f"keep the quadratic clear of all obstacles, {_SAME}"
    return _with_arm(frame, wording, condition, still=True)


def _arm(frame: Frame) -> Challenge | None:
    scene, distance = frame.plan.scene, MEASURES["arm.clearance"](frame)
    if distance is None or not abs(distance) < 1e6:
        return None
    least = float(f"{distance + _FARTHER * max(scene.workspace.size):.3g}")
    farther = f"bring the whole arm {least} {scene.unit} or more from the obstacles"
    wording = f"{farther}; move what you like"
    condition = Condition(measure="arm.clearance", at_least=least)
    return Challenge(text=wording, until=(condition, _COMPLETE))


def _plan(frame: Frame) -> Challenge | None:
    return _with_arm(frame, "move what you like until there is a plan")


def _with_arm(frame: Frame, wording: str, *conditions: Condition, still: bool = False) -> Challenge:
    """The challenge with the condition that the whole arm is clear; ``still`` protects the task.

    A scene that is planned for the tool alone, and whose arm goes through something, asks for the
    tool alone, and says so: no arm may get through.
    """
    plan, task = frame.plan, _task(frame.plan, TASK) if still else ""
    touches = plan.arm_clearance is not None and bool(plan.arm_clearance.contacts)
    if touches and not plan.scene.arm.avoid:
        text = f"{wording} (for the tool tip alone, whatever the arm touches)"
        return Challenge(text=text, until=(*conditions, _TOOL_COMPLETE), task=task)
    text = f"{wording}, with the whole arm clear"
    return Challenge(text=text, until=(*conditions, _COMPLETE), task=task)


GOALS: Mapping[str, Callable[[Frame], Challenge | None]] = MappingProxyType(
    {
        "make it shorter": _shorter,
        "keep the quadratic clear": _quadratic,
        "keep the arm farther away": _arm,
        "find a plan": _plan,
    }
)
"""Goals by name, each a function that makes a challenge of the present plan, or None."""


def challenge_of(goal: str, frame: Frame) -> Challenge | None:
    """The challenge of a goal; None if the plan lacks what it needs."""
    return GOALS[goal](frame) if goal in GOALS else None


def whole_plan(scene: Scene) -> Condition:
    """Conditions of every goal: a complete plan, with the arm if the scene avoids with it."""
    return _COMPLETE if scene.arm.avoid else _TOOL_COMPLETE


def parsed(data: str) -> Challenge | None:
    """Parse a challenge from an untrusted link; None if it is invalid."""
    try:
        return Challenge.model_validate_json(data) if data else None
    except ValidationError:
        return None
