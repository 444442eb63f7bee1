"""Challenges: a scene, and a condition to be met by whoever opens the link."""

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

_SHORTER, _FARTHER = 0.97, 0.2


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
        """Whether all conditions hold now."""
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
    clear = Condition(measure="plan.complete", at_least=1)
    return Challenge(text=wording, until=(Condition(measure="curve.length", at_most=most), clear))


def _quadratic(frame: Frame) -> Challenge | None:
    condition = Condition(measure="quadratic.clear", at_least=1)
    return Challenge(text="keep the quadratic clear of all obstacles", until=(condition,))


def _arm(frame: Frame) -> Challenge | None:
    distance = value("arm.clearance", frame)
    if distance is None or not abs(distance) < 1e6:
        return None
    least = float(f"{distance + _FARTHER:.3g}")
    wording = f"bring the whole arm {least} {frame.plan.scene.unit} or more from the obstacles"
    reached = Condition(measure="plan.complete", at_least=1)
    return Challenge(
        text=wording, until=(Condition(measure="arm.clearance", at_least=least), reached)
    )


def _plan(frame: Frame) -> Challenge | None:
    condition = Condition(measure="plan.complete", at_least=1)
    return Challenge(text="find a plan", until=(condition,))


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
