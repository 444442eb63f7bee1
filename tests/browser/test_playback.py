"""Play, pause, scrub: the tool in the page is where the plan has it at the time shown."""

from __future__ import annotations

import numpy as np
import pytest

from abi.robot.urdf_arm import UrdfArm
from app.layers.arm.urdf_poses import other_poses
from app.server.server import Server
from app.tab.session import Session
from tests.browser import drawn
from tests.browser.conftest import Tabs
from tests.browser.page import Page


def _label(page: Page) -> str:
    return (
        page.tab.get_by_role("button", name="Pause")
        .or_(page.tab.get_by_role("button", name="Play", exact=True))
        .inner_text()
    )


def _tool(page: Page) -> drawn.Points:
    return np.array(page.position(drawn.TOOL))


def _plays(page: Page) -> None:
    """Make it play, whatever it did."""
    if _label(page) == "Play":
        page.click("Play")
    page.until(lambda: _label(page) == "Pause", "the button to say Pause")
    here = _tool(page)
    page.until(lambda: not np.allclose(_tool(page), here, atol=0.02), "the arm to move")


def _stands(page: Page, session: Session) -> None:
    """Wait until the arm stands still, and where it should at the time shown."""
    page.until(lambda: _label(page) == "Play", "the button to say Play")
    page.settle()
    shown = page.time()
    assert session.plan is not None
    here = _tool(page)
    page.frames(10)
    np.testing.assert_array_equal(_tool(page), here)
    assert page.time() == shown


def _is_at(page: Page, session: Session, time: float) -> None:
    """Wait until tool and trace are where they are at ``time`` [s]."""
    assert session.plan is not None
    expected = drawn.tool_at(session.plan, time)
    page.until(
        lambda: bool(np.allclose(_tool(page), expected, rtol=0, atol=1e-3)),
        f"the tool at {time:g} s",
    )
    trace = drawn.chain(page.points("/trace"))
    assert np.linalg.norm(trace[-1] - expected) < 0.1


def test_pause_holds_the_arm_and_play_moves_it(page: Page, session: Session) -> None:
    _plays(page)
    page.click("Pause")
    _stands(page, session)
    _plays(page)


def test_a_typed_time_moves_the_arm_there(page: Page, session: Session) -> None:
    for time in (1.25, 0.4, 2.9):
        page.set_time(time)
        _is_at(page, session, time)
        _stands(page, session)
        assert page.time() == time


def test_pressing_the_track_scrubs(page: Page, session: Session) -> None:
    assert session.plan is not None
    assert session.plan.profile is not None
    for part in (0.5, 0.2, 0.8):
        _plays(page)
        page.scrub(part)
        scrubbed = part * session.plan.profile.duration
        page.until(lambda scrubbed=scrubbed: abs(page.time() - scrubbed) < 0.1, "the time")  # type: ignore[misc]
        _stands(page, session)
        assert page.time() == pytest.approx(scrubbed, abs=0.1)
        _is_at(page, session, page.time())


def test_space_toggles_from_canvas_and_button(page: Page, session: Session) -> None:
    _plays(page)
    pixel = (400.0, 560.0)
    assert page.is_free(pixel)
    page.tab.mouse.click(*pixel)
    page.tab.keyboard.press("Space")
    _stands(page, session)
    page.tab.keyboard.press("Space")
    page.until(lambda: _label(page) == "Pause", "Space to play")
    page.click("Pause")  # the button has the focus now; Space is not to press it as well
    _stands(page, session)
    page.tab.keyboard.press("Space")
    page.until(lambda: _label(page) == "Pause", "Space to play")
    here = _tool(page)
    page.until(lambda: not np.allclose(_tool(page), here, atol=0.02), "the arm to move")


def test_the_page_plays_what_was_planned(page: Page, session: Session) -> None:
    _plays(page)
    assert session.plan is not None
    page.until(lambda: page.tab.evaluate("abi.motion !== null"), "the page to play")
    for time in (0.4, 1.25, 2.9):
        steps = page.tab.evaluate(
            "time => (abi.held ??= abi.motion, abi.motion = null, abi.pose(abi.held, time))",
            time,
        )
        expected = drawn.tool_at(session.plan, time)
        page.until(
            lambda expected=expected: bool(np.allclose(_tool(page), expected, atol=0.01)),  # type: ignore[misc]
            f"the tool at {time:g} s",
        )
        trace = page.points("/trace")[steps - 1, 1]
        assert np.linalg.norm(trace - expected) < 0.2
    page.tab.evaluate("abi.motion = abi.held, abi.held = undefined, abi.tick()")
    page.click("Pause")
    _stands(page, session)


def test_the_page_plays_any_arm_and_tells_when_nobody_looks(tabs: Tabs, server: Server) -> None:
    page = tabs()
    session = server.sessions[page.client]
    page.click("Scene")
    page.choose("scene", "kitchen-ur5e")
    page.until(lambda: session.resting and isinstance(session.frame.plan.arm, UrdfArm), "the plan")
    page.until(lambda: page.tab.evaluate("abi.motion?.joints.length === 6"), "the page to play")
    assert session.plan is not None
    made, motion = session.plan.arm, session.plan.motion
    assert isinstance(made, UrdfArm)
    assert motion is not None
    page.click("Layers")
    page.tick("other elbow, or other poses (ghosts)", True)
    page.until(lambda: page.tab.evaluate("!!abi.bodies?.names.length"), "the other poses to play")
    joint = "/robot/base/" + "/".join(f"joint{number}" for number in range(6))
    page.until(lambda: joint in page.names(), "the arm's nodes")
    for time in (0.4, 1.25):
        page.tab.evaluate(
            "time => (abi.held ??= abi.motion, abi.motion = null, abi.pose(abi.held, time))", time
        )
        positions = np.array([np.interp(time, motion.time, q) for q in motion.positions.T])
        expected = made.chain.poses((positions / made.scales)[None])[0, 5, :, 3] / made.metres
        page.until(
            lambda expected=expected: bool(np.allclose(page.position(joint), expected, atol=0.002)),  # type: ignore[misc]
            f"the wrist at {time:g} s",
        )
        ends = made.place(other_poses(session.plan, made, time))
        middles = ends.mean(axis=2).reshape(-1, 3)
        names = page.tab.evaluate("abi.bodies.names")
        held = np.array([page.position(name) for name in names])
        held = held[np.abs(held).max(axis=1) < 1e6]  # the others are not there at this time
        assert len(held) == len(middles) > 0
        np.testing.assert_allclose(held, middles, atol=0.004)
    for hidden in (True, False):
        page.tab.evaluate(
            "on => (Object.defineProperty(document, 'hidden', {value: on, configurable: true}),"
            " document.dispatchEvent(new Event('visibilitychange')))",
            hidden,
        )
        page.until(lambda hidden=hidden: session._view._is_hidden == hidden, "the page's word")  # type: ignore[misc]
