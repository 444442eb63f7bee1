"""Numbers and choices: sliders, boxes and lists, good and bad."""

from __future__ import annotations

import re

import numpy as np
import pytest

import abi
from abi.obstacles.primitives import Box
from app.drawing import lines
from app.tab.session import Session
from app.ui import style
from tests.browser import drawn
from tests.browser.page import Page

SPEED = "speed [cm/s]"
RATES = "speed up, brake [cm/s²]"
PITCH = "spacing [cm]"
_SCENE_LEFT = "() => window.__viserMutable.canvas.getBoundingClientRect().left"


def _scene(session: Session) -> abi.Scene:
    assert session.plan is not None
    return session.plan.scene


def _size(session: Session) -> float:
    (box,) = _scene(session).obstacles
    assert isinstance(box, Box)
    return float(box.size[0])


def _heading_of_the_mesh(session: Session) -> str:
    assert session.plan is not None
    assert session.plan.mesh is not None
    assert session.plan.free is not None
    return f"1 · Mesh — {session.plan.free.nodes:,} free nodes"


def test_the_hint_of_a_control_comes_up_for_its_name(page: Page) -> None:
    hint = page.tab.locator(".mantine-Tooltip-tooltip")
    for name, words in (
        ("degree", "Of the curve's polynomials"),
        ("shortcut the corners", "Cuts the zigzag"),
        (RATES, "Acceleration from rest"),
    ):
        label = page.tab.locator("label", has_text=name).filter(visible=True)
        label.hover()
        page.until(lambda: hint.filter(has_text=words).count() == 1, words)  # noqa: B023
        told, box = hint.bounding_box(), label.bounding_box()
        assert told is not None
        assert box is not None
        # over the scene: in the panel it would cover what is above
        assert told["x"] >= page.tab.evaluate(_SCENE_LEFT)
        page.tab.mouse.move(640, 300)
        page.until(lambda: hint.count() == 0, "it to go")


def _pitch_is(page: Page, session: Session, pitch: float) -> None:
    page.until(lambda: _scene(session).mesh.pitch == pytest.approx(pitch), f"a pitch of {pitch}")
    page.reads(_heading_of_the_mesh(session))
    page.until(lambda: drawn.shows(page, session.plan), "the new path and curves")


def test_a_typed_pitch_changes_the_mesh(page: Page, session: Session) -> None:
    before = _heading_of_the_mesh(session)
    page.set_number(PITCH, 0.9)
    _pitch_is(page, session, 0.9)
    assert before not in page.text()
    assert session.plan is not None
    assert session.plan.free is not None
    page.until(
        lambda: len(page.points("/mesh/nodes")) == session.plan.free.nodes,  # type: ignore[union-attr]
        "the nodes of the new mesh",
    )


def test_arrow_keys_move_the_pitch_step_by_step(page: Page, session: Session) -> None:
    page.set_number(PITCH, 1.2)
    _pitch_is(page, session, 1.2)
    thumb = page.row(PITCH).get_by_role("slider")
    for key, pitch in (("ArrowRight", 1.21), ("ArrowRight", 1.22), ("ArrowLeft", 1.21)):
        thumb.press(key)
        _pitch_is(page, session, pitch)
    assert page.row(PITCH).locator("input:visible").input_value() == "1.21"


def test_a_notice_of_a_number_half_typed_goes_when_it_is_typed(
    page: Page, session: Session
) -> None:
    page.click("Scene")
    box = page.row("size [cm]").locator("input:visible").first
    notice = page.tab.locator(".mantine-Notification-root", has_text="Not changed")
    box.fill("0")
    notice.wait_for()
    box.fill("0.5")
    page.until(lambda: _size(session) == 0.5, "the size")
    notice.wait_for(state="detached")
    assert page.complaints() == []


def test_a_bad_speed_says_why_and_keeps_the_plan(page: Page, session: Session) -> None:
    page.set_number(SPEED, 2)
    page.until(lambda: _scene(session).motion.speed == 2, "the first speed")
    page.until(lambda: drawn.shows(page, session.plan), "its picture")
    good = session.plan
    places = [_place(page, heading) for heading in ("4 · B-spline", "5 · Quadratic", "6 · Arm")]
    for bad, limit in (("-1", "above 0"), ("10000000", "at most 1,000,000"), ("0", "above 0")):
        page.set_number(SPEED, bad)
        page.reads(f"Not changed. The cruise speed must be {limit}")
        (sentence,) = page.complaints()
        assert re.search(r"The cruise speed must be .+; it is \S+\.", sentence)
        assert session.plan is good
    page.reads("5 · Quadratic — not changed ✗")
    # the hand may be on any of the widgets: none of them moves
    assert places == [
        _place(page, heading) for heading in ("4 · B-spline", "5 · Quadratic", "6 · Arm")
    ]
    assert drawn.shows(page, good)

    page.set_number(SPEED, 2.125)
    page.until(lambda: page.complaints() == [], "no complaint")
    assert _scene(session).motion.speed == 2.125


def test_what_is_no_number_is_ignored(page: Page, session: Session) -> None:
    page.set_number(SPEED, 2)
    page.until(lambda: _scene(session).motion.speed == 2, "the first speed")
    for rate, bad in enumerate(("", "abc", "-"), start=3):
        box = page.row(SPEED).locator("input:visible")
        box.fill("")
        box.press_sequentially(bad)
        box.press("Tab")

        # What was typed later arrives later: were there an answer to the first, it would be seen.
        page.set_number(RATES, rate)
        page.until(lambda rate=rate: _scene(session).motion.acceleration == rate, "the later one")  # type: ignore[misc]
        assert _scene(session).motion.speed == 2
        assert page.complaints() == []
    page.set_number(RATES, 7.625, 1)
    page.until(lambda: _scene(session).motion.deceleration == 7.625, "the braking")
    page.set_number(SPEED, 3)
    page.until(lambda: _scene(session).motion.speed == 3, "a good number")


def test_a_choice_changes_the_curve_that_the_arm_follows(page: Page, session: Session) -> None:
    page.choose("arm follows", "B-spline")
    page.until(lambda: session.plan.followed == "bspline", "the B-spline to be followed")  # type: ignore[union-attr]
    page.choose("curve", "several joined curves, none hitting")
    page.until(lambda: _scene(session).quadratic.mode == "pieces", "the pieces")
    page.until(lambda: drawn.shows(page, session.plan), "their picture")
    assert "/path/taut" in page.shown()
    assert drawn.is_nothing(page.points("/path/taut"))
    page.tick("shortcut the corners", True)
    page.until(lambda: not drawn.is_nothing(page.points("/path/taut")), "the taut path")
    page.until(lambda: drawn.shows(page, session.plan), "the curves along it")
    assert session.plan is not None
    assert session.plan.taut is not None
    dashes = page.points("/path/taut")
    longest = max(session.plan.scene.workspace.size)
    expected = lines.dashes(session.plan.taut.points, style.DASHES["taut"][0] * longest)
    np.testing.assert_allclose(dashes, expected, atol=drawn.SINGLE)
    assert drawn.same(session.plan, abi.plan(session.plan.scene))


def _place(page: Page, heading: str) -> float:
    """Height at which a heading stands in the page, [px]."""
    box = page.tab.get_by_text(heading, exact=False).first.bounding_box()
    assert box is not None, f"{heading!r} is not to be seen"
    return box["y"]
