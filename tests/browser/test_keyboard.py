"""Everything on the page can be reached, named and used by keys alone."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import CDPSession

from app.tab.session import Session
from tests.browser.page import Page

_TABS = ("Learn", "Search", "Plots", "Scene", "Layers", "Result")
_USED = {"button", "checkbox", "combobox", "slider", "spinbutton", "tab", "textbox"}
"""Roles of what a hand uses."""
_CAMERA = "window.__viserMutable.camera.position.toArray()"
_FOCUSED = "document.activeElement.textContent"


@pytest.fixture
def tree(page: Page) -> Iterator[CDPSession]:
    """What a screen reader is told of the page."""
    session = page.tab.context.new_cdp_session(page.tab)
    yield session
    session.detach()


def _controls(tree: CDPSession) -> list[tuple[str, str]]:
    """Role and name of each control."""
    nodes: list[dict[str, Any]] = tree.send("Accessibility.getFullAXTree")["nodes"]
    read = [(node["role"]["value"], node["name"]["value"]) for node in nodes if not node["ignored"]]
    return [(role, name) for role, name in read if role in _USED]


def test_every_control_has_a_name(page: Page, tree: CDPSession) -> None:
    for stage in ("2 · Graph", "6 · Arm"):
        page.tab.get_by_role("button", name=stage).click()
    for tab in _TABS:
        page.click(tab)
        page.settle()
        found = _controls(tree)
        assert len(found) > 30
        assert [role for role, name in found if not name.strip()] == []
    names = [name.replace(" ", "") for _, name in found]
    for name in ("speedup[cm/s²]", "brake[cm/s²]", "column[cm]", "basey[cm]", "spacing[cm]"):
        assert name in names
    for stage in ("2 · Graph", "6 · Arm"):
        page.tab.get_by_role("button", name=stage).click()


def test_names_follow_the_unit(page: Page, session: Session, tree: CDPSession) -> None:
    page.click("Scene")
    page.choose("scene", "kitchen-ur5e")
    page.until(lambda: session.resting and session.frame.plan.scene.unit == "m", "another unit")
    page.until(lambda: page.row("spacing [m]").count() == 1, "its label")
    # only now, since a browser that tells names does so again and again while a page changes
    named = "spacing[m]"
    page.until(lambda: named in [name.replace(" ", "") for _, name in _controls(tree)], named)
    page.choose("scene", "paper")
    page.until(lambda: session.resting and session.frame.plan.scene.unit == "cm", "the paper's")
    page.click("Result")


@pytest.mark.parametrize("key", ["Enter", "Space"])
def test_a_folder_unfolds_by_keys(page: Page, session: Session, key: str) -> None:
    heading = page.tab.get_by_role("button", name="2 · Graph")
    playing = session.playback.playing
    heading.focus()
    for folded in (False, True):
        page.tab.keyboard.press(key)
        expanded = str(not folded).lower()
        page.until(lambda: heading.get_attribute("aria-expanded") == expanded, key)  # noqa: B023
    page.settle()
    assert session.playback.playing == playing
    page.tab.keyboard.press("Tab")
    assert page.tab.evaluate(_FOCUSED).startswith("3 · Search")


def test_keys_on_a_control_do_nothing_else(page: Page, session: Session) -> None:
    camera = page.tab.evaluate(_CAMERA)
    thumb = page.row("degree").get_by_role("slider")
    thumb.focus()
    thumb.press("ArrowLeft")
    page.until(lambda: session.frame.plan.scene.spline.degree == 3, "the degree")
    page.frames(5)
    assert page.tab.evaluate(_CAMERA) == camera
    # one press, one toggle: not the button's and the page's
    play = page.tab.locator("#abi-overlay .abi-play")
    play.focus()
    for playing in (True, False):
        page.tab.keyboard.press("Space")
        page.until(lambda: session.playback.playing is playing, "one toggle")  # noqa: B023


def test_space_plays_after_a_click(page: Page, session: Session) -> None:
    page.click("Search")
    page.click("Result")
    page.tab.locator("#abi-overlay .abi-play").click()
    page.until(lambda: session.playback.playing, "it to play")
    page.tab.keyboard.press("Space")
    page.until(lambda: not session.playback.playing, "it to stand")
