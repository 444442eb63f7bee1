"""The sentence over the scene on what the arm's motion lacks, and what its buttons change."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import partial
from html import unescape
from typing import Any

import pytest

import abi
from abi.planner.arm_words import arm_result
from app.panels.arm_banner import arm_banner, arm_changes
from app.tab.session import Session
from tests.app.fake_tab import FakeTab, accept, until

_TOO_NEAR: dict[str, Any] = {"arm": {"clearance": 0.5}}
_TOO_FAST: dict[str, Any] = {
    "motion": {"speed": 1.5, "acceleration": 5.0, "deceleration": 5.0, "law": "three_phase"}
}


def _plan(name: str, changes: dict[str, Any]) -> abi.Plan:
    return abi.plan(abi.load_scene(name).replace(**changes))


def _told(session: Session) -> str:
    shown = session.panels.layout.overlay.shown.get("contact", "")
    return unescape(re.sub(r"<.*?>", "", shown)).replace("\N{NO-BREAK SPACE}", " ")


@pytest.mark.parametrize("name", ["paper", "two-boxes", "kitchen-ur5e"])
def test_an_arm_that_is_proven_clear_has_no_banner(name: str) -> None:
    made = _plan(name, {})
    assert arm_banner(made) == ""
    assert arm_changes(made) == {}


@pytest.mark.parametrize(
    ("name", "changes", "sentence"),
    [
        ("paper", _TOO_NEAR, "Links too near: 0.112 cm of the 0.5 cm wanted; the gripper"),
        ("kitchen-ur5e", _TOO_FAST, "elbow_joint passes its torque limit of 150 N·m"),
        ("paper", {"motion": {"speed": 2.0}}, "q6 passes its limit of 360° at"),
        ("paper", {"motion": {"speed": 2.0}}, "Its drive in stage 6 is too strong"),
        ("wall-with-window", {}, "The slide goes 0.549 cm into obstacle 2 at 2.05 s."),
    ],
)
def test_what_only_the_arms_stage_told_is_over_the_scene(
    name: str, changes: dict[str, Any], sentence: str
) -> None:
    made = _plan(name, changes)
    assert made.error is None
    assert "✗" in arm_result(made)
    assert sentence in unescape(arm_banner(made))


def test_a_scene_that_is_shipped_with_a_fault_tells_it_calmly_until_it_is_changed() -> None:
    made = _plan("wall-with-window", {})
    shipped = arm_banner(made)
    assert "abi-error" not in shipped
    assert "✗" not in shipped
    assert "Avoid with the whole arm" in arm_changes(made)
    changed = arm_banner(_plan("wall-with-window", {"motion": {"speed": 3.9}}))
    assert "abi-error" in changed


def test_a_button_takes_the_link_clearance_that_is_kept(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    fake.set(session.panels.stages.arm.clearance, 0.5)
    until(lambda: "Links too near" in _told(session) and session.resting)
    assert "Set link clearance to 0.11 cm" in _told(session)
    accept(fake, session, "Set link clearance to 0.11 cm")
    until(lambda: session.frame.plan.is_arm_clear and session.resting)
    assert _told(session) == ""
    assert session.plan is not None
    assert session.plan.scene.arm.clearance == 0.11


def test_a_button_follows_the_curve_that_is_clear(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    fake.set(session.panels.stages.fields["motion.curve"], "quadratic")
    until(lambda: "Follow the B-spline" in _told(session) and session.resting)
    accept(fake, session, "Follow the B-spline")
    until(lambda: session.frame.plan.followed == "bspline" and session.resting)
    assert _told(session) == ""


def test_a_button_slows_the_motion_down(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    made = _plan("kitchen-ur5e", _TOO_FAST)
    assert {"acceleration", "torque"} <= {one.quantity for one in made.limits_passed}
    assert arm_changes(made) == {"Slow down for the joints": {"motion": {"law": "slowed"}}}
    until(lambda: session.resting)
    session.panels.messages._banner(made)
    accept(fake, session, "Slow down for the joints")
    until(partial(_is_slowed, session))
    slowed = _plan("kitchen-ur5e", {"motion": {**_TOO_FAST["motion"], "law": "slowed"}})
    assert slowed.error is None
    assert slowed.limits_passed == ()


def test_a_press_is_not_taken_for_a_change_that_is_offered_after_it(
    tab: tuple[FakeTab, Session],
) -> None:
    _, session = tab
    until(lambda: session.resting)
    session.close()
    messages, change = session.panels.messages, {"arm": {"avoid": True}}
    for stage in ("", "mesh"):
        messages._offered({"Avoid with the whole arm": change})
        messages._accepts[0].value = True  # type: ignore[misc]
        if stage:  # which offers nothing
            messages.draw(replace(session.frame, stage=stage))
            messages._offered({"Slow down": {"motion": {"law": "slowed"}}})
        assert messages.accepted_change() == (None if stage else change)


def _is_slowed(session: Session) -> bool:
    return session.frame.plan.scene.motion.law == "slowed"
