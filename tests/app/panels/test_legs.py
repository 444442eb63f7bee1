"""Legs of a sequence of tasks in a tab: one after the other, and back."""

from __future__ import annotations

import re
from functools import partial
from html import unescape

import pytest

from abi.scene.scene import load_scene
from app.tab.session import Session
from tests.app.fake_tab import FakeTab, until


def told(session: Session) -> str:
    shown = session.panels.layout.overlay.shown.get("message", "")
    return unescape(re.sub(r"<.*?>", " ", shown)).replace("\N{NO-BREAK SPACE}", " ")


def at_leg(session: Session, number: int) -> bool:
    plans = session.panels.messages.legs._plans
    return session.resting and len(plans) > number and session.frame.plan is plans[number]


@pytest.mark.slow  # three plans of a real arm
def test_the_object_is_taken_along_from_leg_to_leg_and_stands_again_where_one_goes_back(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    legs, whole = session.panels.messages.legs, load_scene("pick-and-place")
    assert legs.html() == ""
    fake.set(session.panels.files.choice, "pick-and-place")
    until(lambda: at_leg(session, 0))
    assert "Leg 1 of 6 : above the block." in told(session)

    for number in (1, 2):
        until(lambda: legs.state()[2] is True)
        last = session.frame.plan.motion
        assert last is not None
        fake.set(legs.go_on, True)
        until(partial(at_leg, session, number))
        motion = session.frame.plan.motion
        assert motion is not None
        assert abs(motion.positions[0] - last.positions[-1]).max() <= 1e-9
        assert f"Leg {number + 1} of 6" in told(session)
    scene = session.frame.plan.scene
    assert len(scene.obstacles) == len(whole.obstacles) - 1
    assert scene.arm.attached is not None

    for number in (1, 0):
        fake.set(legs.go_back, True)
        until(partial(at_leg, session, number))
        assert session.frame.plan.scene.arm.attached is None
    assert session.frame.plan.scene == whole
    fake.set(session.panels.files.choice, "paper")
    until(lambda: session.resting and session.frame.plan.scene.arm.model == "abi")
    until(lambda: "Leg" not in told(session))
