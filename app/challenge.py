"""Challenges: a scene, and a goal for whoever opens the link."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from app import style
from app.frame import Frame
from app.lessons.lesson import Condition
from app.lessons.measures import text, value

_SHORTER = 0.97
_FARTHER = 1 / 30
"""Distance to gain, as a part of the workspace's longest side."""
_COMPLETE = Condition(measure="plan.complete", at_least=1)
_TOOL_COMPLETE = Condition(measure="plan.tool_complete", at_least=1)


class Challenge(BaseModel):
    """A challenge: what is to be reached.

    Attributes:
        text: in words.
        until: conditions, all of which must hold.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    text: Annotated[str, Field(max_length=200)]
    until: Annotated[tuple[Condition, ...], Field(min_length=1, max_length=3)]

    def is_met(self, frame: Frame) -> bool:
        """Check whether all conditions hold now."""
        return all(condition.holds(frame) for condition in self.until)

    def html(self, met: bool, frame: Frame) -> str:
        """The challenge and the present number, for the layer over the scene."""
        colour = style.readable(style.GOOD if met else style.BAD)
        now = ", ".join(text(one.measure, frame) for one in self.until if one.measure in _SHOWN)
        sign = f'<b style="color:{colour}">{"✓ Done" if met else "Challenge"}:</b>'
        number = f" (now {now})" if now else ""
        return f'<div class="abi-card">{sign} {html.escape(self.text)}{number}</div>'


_SHOWN = {"curve.length", "arm.clearance"}


def _shorter(frame: Frame) -> Challenge | None:
    length = value("curve.length", frame)
    if length is None:
        return None
    most = float(f"{_SHORTER * length:.4g}")
    wording = f"make the arm's curve 3 % shorter: {most} {frame.plan.scene.unit} or less"
    return _with_arm(frame, wording, Condition(measure="curve.length", at_most=most))


def _quadratic(frame: Frame) -> Challenge | None:
    condition = Condition(measure="quadratic.clear", at_least=1)
    return _with_arm(frame, "keep the quadratic clear of all obstacles", condition)


def _arm(frame: Frame) -> Challenge | None:
    scene, distance = frame.plan.scene, value("arm.clearance", frame)
    if distance is None or not abs(distance) < 1e6:
        return None
    least = float(f"{distance + _FARTHER * max(scene.workspace.size):.3g}")
    wording = f"bring the whole arm {least} {scene.unit} or more from the obstacles"
    condition = Condition(measure="arm.clearance", at_least=least)
    return Challenge(text=wording, until=(condition, _COMPLETE))


def _plan(frame: Frame) -> Challenge | None:
    return _with_arm(frame, "find a plan")


def _with_arm(frame: Frame, wording: str, *conditions: Condition) -> Challenge:
    """The challenge, met by a plan whose whole arm is clear.

    A scene that is planned for the tool alone, and whose arm goes through something, asks for the
    tool alone, and says so: no arm may get through.
    """
    plan = frame.plan
    touches = plan.arm_clearance is not None and bool(plan.arm_clearance.contacts)
    if touches and not plan.scene.arm.avoid:
        text = f"{wording} (for the tool alone, whatever the arm touches)"
        return Challenge(text=text, until=(*conditions, _TOOL_COMPLETE))
    return Challenge(text=f"{wording}, with the whole arm clear", until=(*conditions, _COMPLETE))


GOALS: Mapping[str, Callable[[Frame], Challenge | None]] = MappingProxyType(
    {
        "make it 3 % shorter": _shorter,
        "keep the quadratic clear": _quadratic,
        "keep the arm farther away": _arm,
        "find a plan": _plan,
    }
)
"""Goals by name; each makes its challenge of the present plan, or none."""


def challenge_of(goal: str, frame: Frame) -> Challenge | None:
    """The challenge of that goal; None where the plan has not what it takes."""
    return GOALS[goal](frame) if goal in GOALS else None


def parsed(data: str) -> Challenge | None:
    """The challenge of a link, which may come from anyone; None where it is none."""
    try:
        return Challenge.model_validate_json(data) if data else None
    except ValidationError:
        return None
