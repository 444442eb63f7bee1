"""The overlay: the tour, lecture mode, and the demonstration of a new tab."""

from __future__ import annotations

import math

import numpy as np
import pytest
from playwright.sync_api import Browser

import abi
from app.panels.teach.tour import STEPS
from app.server.server import start
from app.stages.catalogue import TITLES
from app.state.appearance import Appearance
from app.tab.session import Session
from tests.browser import drawn
from tests.browser.page import Page
from tests.thorough import of_each_kind

_LETTERS = "parseFloat(getComputedStyle(document.querySelector('.abi-numbers b')).fontSize)"
_WIDTH = "window.__viserMutable.canvas.getBoundingClientRect().width"


def test_the_tour_goes_through_five_steps(page: Page) -> None:
    frames = page.tab.locator(".abi-spotlight")
    page.click("Tour")
    for number in range(len(STEPS)):
        page.reads(f"{number + 1} of {len(STEPS)}.")
        page.until(lambda: frames.count() > 0, "what the step speaks of to be framed")
        if number == 1:
            page.click("Back")
            page.reads(f"1 of {len(STEPS)}.")
            page.click("Next")
            page.reads(f"2 of {len(STEPS)}.")
        page.click("Done" if number == len(STEPS) - 1 else "Next")
    page.until(lambda: "of 5." not in page.text(), "the tour's end")
    page.until(lambda: frames.count() == 0, "no frame")
    page.click("Tour")
    page.reads("1 of 5.")
    page.click("End")
    page.until(lambda: "of 5." not in page.text(), "the tour's end")


def test_in_a_lecture_the_scene_is_alone_and_in_large_letters(page: Page, session: Session) -> None:
    before, letters = page.shown(), page.tab.evaluate(_LETTERS)
    width = page.tab.evaluate(_WIDTH)
    page.click("Lecture")
    page.until(lambda: page.tab.evaluate(_WIDTH) > 1.8 * width, "the panels to fold")
    assert page.tab.evaluate(_LETTERS) > 1.5 * letters
    page.until(lambda: page.props("/goal/label")["font_screen_scale"] > 1.5, "large labels")
    player = page.tab.locator(".abi-player")
    for title in TITLES.values():
        page.click(">")
        page.reads(title)
        shows_arm = title.startswith("6")
        page.until(lambda: player.is_visible() == shows_arm, "the player with the arm")  # noqa: B023
        if title.startswith("3"):
            page.until(lambda: "/curve/bspline" not in page.shown(), "no curve")
            assert "/path/a_star" in page.shown()
    page.tab.keyboard.press("PageDown")
    page.until(lambda: page.shown() == before, "all stages again")
    page.tab.keyboard.press("PageUp")
    page.reads(TITLES["arm"])
    page.click(">")
    page.until(lambda: page.shown() == before, "all stages again")
    page.click("Top")
    page.until(lambda: session.client.camera.position[2] > 8, "the view from above")
    page.click("End lecture")
    page.until(lambda: page.tab.evaluate(_WIDTH) == pytest.approx(width, abs=2), "the panels")
    assert page.tab.evaluate(_LETTERS) == letters
    page.tab.keyboard.press("PageDown")
    page.settle()
    assert page.shown() == before


@pytest.mark.parametrize("way", ["h", "Escape", "Close", "beside"])
def test_the_sheet_of_keys_opens_and_closes(page: Page, way: str) -> None:
    def is_open() -> bool:
        return page.tab.get_by_text("show this sheet").count() > 0

    page.tab.keyboard.press("?" if way == "Escape" else "h")
    page.until(is_open, "the sheet")
    if way == "Close":
        page.click("Close")
    elif way == "beside":
        page.tab.mouse.click(640, 700)
    else:
        page.tab.keyboard.press(way)
    page.until(lambda: not is_open(), "the sheet to close")
    page.tab.keyboard.press("h")
    page.until(is_open, "the sheet again")
    page.tab.keyboard.press("h")
    page.until(lambda: not is_open(), "the sheet to close again")


def _is_under_the_mouse(page: Page, gizmo: str) -> bool:
    """Move the mouse onto what moves by itself; whether it is still there two frames later."""
    before = page.pixel(gizmo)
    page.tab.mouse.move(*before)
    page.frames(2)  # what is under the mouse is found while drawing
    return math.dist(before, page.pixel(gizmo)) < 10


@pytest.mark.parametrize("touched", of_each_kind(["a button", "the obstacle"], "the obstacle"))
def test_the_demonstration_ends_at_the_first_touch(chromium: Browser, touched: str) -> None:
    paper = abi.load_scene("paper")
    server = start(port=0, scene="paper", look=Appearance(plain=True, demo=True))
    page = Page(chromium, server.url + "/?demo=1")
    try:
        page.until(lambda: bool(server.sessions), "a session")
        (session,) = server.sessions.values()

        def scene() -> abi.Scene:
            return session.frame.plan.scene

        page.until(lambda: session._pause.demo.running and scene() != paper, "the demonstration")
        if touched == "a button":
            page.click("Pause")
            page.until(lambda: scene() == paper, "the scene as it was")
        else:
            page.until(lambda: len(drawn.obstacles(page)) == 1, "the obstacle")
            (gizmo,) = drawn.obstacles(page)
            page.until(lambda: _is_under_the_mouse(page, gizmo), "the obstacle under the mouse")
            page.tab.mouse.down()
            page.frames(2)
            x, y = page.pixel(gizmo)
            page.tab.mouse.move(x + 50, y + 40, steps=8)
            page.frames(2)
            page.tab.mouse.up()
            page.until(lambda: not session._pause.demo.running, "the end of the demonstration")
            page.until(lambda: session.resting and scene() != paper, "the obstacle's new place")
            page.until(lambda: drawn.shows(page, session.plan), "the plan")
            np.testing.assert_allclose(
                scene().obstacles[0].position, page.position(gizmo), atol=1e-5
            )
        assert not page.errors
    finally:
        page.close()
        server.stop()


def test_what_this_is_can_be_read_at_any_time(page: Page) -> None:
    page.click("What is this?")
    page.reads("A robot arm is to bring its tool tip from start to goal")
    paper = "A Hybrid Method for Constructing Optimal Motion Path for Robot Manipulators"
    assert paper in " ".join(page.text().split())
    page.tab.keyboard.press("Escape")
    page.until(lambda: "is to bring its tool tip" not in page.text(), "the sheet to close")
