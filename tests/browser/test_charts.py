"""Plots show all of their data, whatever scene came before, and what a hand draws out of them."""

from __future__ import annotations

import numpy as np
import pytest
from playwright.sync_api import Locator

from app.server.server import Server
from app.tab.session import Session
from tests.browser import drawn
from tests.browser.charts import ends, is_whole
from tests.browser.conftest import Tabs
from tests.browser.page import Page


def test_a_part_of_the_time_is_drawn_out_by_hand(page: Page, session: Session) -> None:
    box = page.tab.locator(".u-over").first.bounding_box()
    assert box is not None
    y = box["y"] + box["height"] / 2
    page.tab.mouse.move(box["x"] + 0.5 * box["width"], y)
    page.tab.mouse.down()
    page.tab.mouse.move(box["x"] + 0.8 * box["width"], y, steps=4)
    page.tab.mouse.up()
    duration = session.frame.duration
    page.until(lambda: 0.4 * duration < ends(page)[0] < 0.6 * duration, "the part drawn out")
    page.tab.wait_for_timeout(1000)
    assert 0.7 * duration < ends(page)[1] < 0.9 * duration, "it stays"
    page.tab.mouse.dblclick(box["x"] + 0.5 * box["width"], y)
    page.until(lambda: is_whole(page, duration), "the whole motion again")
    assert not page.errors


def _read(page: Page, over: Locator) -> list[str]:
    """Hover over three quarters of a plot; the lines of what is told there."""
    over.scroll_into_view_if_needed()
    box = over.bounding_box()
    assert box is not None
    page.tab.mouse.move(box["x"] + 0.75 * box["width"], box["y"] + 0.5 * box["height"])
    card = over.locator(".abi-read")
    card.wait_for()
    assert card.bounding_box()["x"] < box["x"] + 0.25 * box["width"], "not under the pointer"  # type: ignore[index]
    return card.inner_text().splitlines()


def test_a_plot_tells_time_and_values_at_the_pointer(page: Page, session: Session) -> None:
    motion = session.frame.plan.motion
    assert motion is not None
    page.settle()
    over = page.tab.locator(".u-over").filter(visible=True).first
    for enlarged in (False, True):
        if enlarged:
            page.tab.locator(".uplot-container:hover").get_by_role("button").click()
            over = page.tab.locator(".mantine-Modal-body .u-over")
            over.wait_for()
        moment, *lines = _read(page, over)
        time = float(moment.removeprefix("at ").removesuffix(" s"))
        assert time == pytest.approx(0.75 * session.frame.duration, abs=0.03)
        velocity = motion.tool_velocity[np.abs(motion.time - time).argmin()]
        assert [line.split()[0] for line in lines] == ["speed", "x", "y", "z"]
        told = [float(line.split()[1].replace("−", "-")) for line in lines]
        assert told == pytest.approx([np.linalg.norm(velocity), *velocity], abs=0.03)
    page.tab.keyboard.press("Escape")
    over.wait_for(state="detached")
    page.tab.mouse.move(640, 300)
    page.until(lambda: page.tab.locator(".abi-read").count() == 0, "no reading")


_ALL = """() => Object.values(window.__viserTestpoints.uplots).filter(({chart}) => chart).length"""


def test_plots_behind_their_tab_come_when_it_is_opened_and_follow_a_drag(
    tabs: Tabs, server: Server
) -> None:
    page = tabs()
    session = server.sessions[page.client]
    page.until(lambda: page.tab.evaluate(_ALL) == 1, "the speed alone")
    page.click("Plots")
    page.until(lambda: page.tab.evaluate(_ALL) > 6, "the plots")
    before = session.frame.duration
    page.until(lambda: is_whole(page, before), "the whole motion")
    page.drag_arrow(drawn.obstacles(page)[0], 2, -1.0)
    page.until(lambda: session.frame.duration != before, "another motion")
    page.until(lambda: is_whole(page, session.frame.duration), "the whole of it")


# Where the playback's speed is, and how high what scrolls with it is, [px].
_PLACE = """() => {
  const label = [...document.querySelectorAll("label")]
    .find(each => each.textContent === "playback speed" && each.checkVisibility());
  const panel = label.closest(".mantine-ScrollArea-viewport");
  return [label.getBoundingClientRect().top, panel.scrollHeight];
}"""


def test_nothing_moves_below_the_plot_of_no_motion(page: Page, session: Session) -> None:
    page.settle()
    before = page.tab.evaluate(_PLACE)
    page.click("Scene")
    for axis in range(3):
        page.set_number("goal [cm]", 3, axis)
        # the page tells only the last of two edits within 50 ms
        page.until(lambda: session.frame.plan.scene.goal[axis] == 3, "it")  # noqa: B023
    page.click("Result")
    page.until(lambda: session.resting and session.frame.plan.motion is None, "no motion")
    page.reads("No motion, nothing to plot.")
    page.settle()
    assert page.tab.evaluate(_PLACE) == pytest.approx(before, abs=1.5)
