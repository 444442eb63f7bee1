"""A phone: the panels are one sheet, as wide as the page, in which nothing has to be looked for."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Locator

from app.server.server import Server
from app.ui.layout import TITLE
from tests.browser.page import Page

# Width of the sheet and of its content, [px].
_WIDTHS = """() => {
  const sheet = document.querySelector(".mantine-ScrollArea-viewport");
  return [sheet.clientWidth, sheet.scrollWidth];
}"""

# How far below the top of the sheet its tabs begin, [px], and how much can still be scrolled.
_TABS_BEGIN = """() => {
  const sheet = document.querySelector(".mantine-ScrollArea-viewport");
  const tabs = document.querySelector("[role=tablist]").getBoundingClientRect();
  return [tabs.top - sheet.getBoundingClientRect().top,
    sheet.scrollHeight - sheet.clientHeight - sheet.scrollTop];
}"""

# Heights of the page, and of the scene; and where the sheet begins, [px].
_SHARES = """() => [innerHeight, window.__viserMutable.canvas.getBoundingClientRect().bottom,
  document.querySelector(".mantine-ScrollArea-viewport").getBoundingClientRect().top]"""

# Whether each headline number with its name is seen whole above the sheet, clear of the buttons.
_WHOLE_HEADLINES = """() => {
  const box = part => document.querySelector(part)?.getBoundingClientRect();
  const sheet = box(".mantine-ScrollArea-viewport");
  const all = [...document.querySelectorAll("#abi-overlay .abi-numbers > div")]
    .map(each => each.getBoundingClientRect());
  const lecture = box("#abi-overlay [data-part=lecture]");
  const player = box("#abi-overlay [data-part=player]");
  return all.length === 3 && lecture.height > 0 && player.bottom <= sheet.top
    && all.every(({top, bottom, left, right}) => top >= lecture.bottom && bottom <= player.top
      && left >= 0 && right <= innerWidth);
}"""


# What is to be touched, and is less than 32 px high, or 24 px wide; its name and size.
_SMALL = """() => [...document.querySelectorAll("button, [role=tab], input:not([type=file])")]
  .filter(each => each.checkVisibility() && !each.matches(".mantine-NumberInput-control"))
  .map(each => [each, each.getBoundingClientRect(), each.type === "checkbox" ? 24 : 32])
  .filter(([, {width, height}, least]) => width > 0 && (width < 24 || height < least))
  .map(([{ariaLabel, textContent}, {width, height}]) =>
    `${ariaLabel ?? textContent}: ${width} x ${height}`)"""

# Whether a point so far above the middle of a folder's heading, [px], belongs to it.
_HEADING = """above => {
  const heading = [...document.querySelectorAll("[role=button].mantine-Paper-root")]
    .find(each => each.textContent.startsWith("2 · Graph"));
  const {left, top, height} = heading.getBoundingClientRect();
  return document.elementFromPoint(left + 20, top + height / 2 - above) === heading;
}"""


def _are_both_seen(page: Page) -> bool:
    """Check whether the scene has half of the page, down to the sheet."""
    height, scene, sheet = page.tab.evaluate(_SHARES)
    return bool(0.45 * height <= scene <= sheet + 1 <= scene + 3)


def _in_sight(page: Page) -> bool:
    """Check if the tabs are at the top of the sheet, or as far up as their content lets them be."""
    below, left = page.tab.evaluate(_TABS_BEGIN)
    return bool(0 < below < 80 or left < 2)


# How far the sheet is scrolled, [px].
_SCROLLED = """() => document.querySelector(".mantine-ScrollArea-viewport").scrollTop"""

_HINT = """() => {
  const hint = document.createElement("div");
  hint.className = "mantine-Tooltip-tooltip";
  hint.textContent = "a hint";
  document.body.append(hint);
}"""


@pytest.fixture(scope="module")
def phone(chromium: Browser, server: Server) -> Iterator[Page]:
    """A tab on a phone, its sheet folded."""
    page = Page(chromium, server.url, 390, 844)
    yield page
    page.close()


def _reaches(button: Locator) -> float:
    """How far down the page a button reaches, [px]; infinite for none."""
    box = button.bounding_box() if button.count() else None
    return math.inf if box is None else box["y"] + box["height"]


def _fold(page: Page) -> None:
    title = page.tab.get_by_text(TITLE, exact=True)
    title.click()
    page.until(lambda: title.bounding_box()["y"] > 780, "the sheet to fold")  # type: ignore[index]
    page.until(lambda: page.tab.evaluate(_SHARES)[1] > 0.9 * 844, "the scene to have it all")


def _swipe(page: Page, start: tuple[float, float], right: float, down: float) -> None:
    """Move a finger over the glass, and lift it."""
    touch = page.tab.context.new_cdp_session(page.tab)
    touch.send("Emulation.setTouchEmulationEnabled", {"enabled": True})
    x, y = start
    for k in range(11):
        at = {"x": x + right * k / 10, "y": y + down * k / 10}
        kind = "touchMove" if k else "touchStart"
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [at]})
        page.frames(1)
    touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    touch.send("Emulation.setTouchEmulationEnabled", {"enabled": False})
    touch.detach()


def _middle(page: Page, slider: Locator) -> tuple[float, tuple[float, float]]:
    """How far the sheet is scrolled with the slider in its middle, and that one's, [px]."""
    slider.evaluate("each => each.scrollIntoView({block: 'center'})")
    page.settle()
    box = slider.bounding_box()
    assert box is not None
    at = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    return float(page.tab.evaluate(_SCROLLED)), at


@pytest.mark.slow
def test_a_finger_that_begins_on_a_slider_scrolls_unless_it_goes_sideways(phone: Page) -> None:
    phone.tab.get_by_text(TITLE, exact=True).click()
    phone.until(lambda: _are_both_seen(phone), "the sheet")
    slider = phone.tab.locator(".mantine-Slider-root:visible").first
    knob = slider.locator("[role=slider]")
    before = knob.get_attribute("aria-valuenow")
    scrolled, at = _middle(phone, slider)
    _swipe(phone, at, 80, 3)
    phone.until(lambda: knob.get_attribute("aria-valuenow") != before, "the slider to move")
    assert phone.tab.evaluate(_SCROLLED) == scrolled

    phone.settle()
    before = knob.get_attribute("aria-valuenow")
    scrolled, at = _middle(phone, slider)
    _swipe(phone, at, 3, -120)
    phone.until(lambda: phone.tab.evaluate(_SCROLLED) > scrolled + 30, "the sheet to scroll")
    assert knob.get_attribute("aria-valuenow") == before
    _fold(phone)
    assert not phone.errors


@pytest.mark.slow
def test_a_sheet_shows_what_is_chosen_and_can_be_folded(phone: Page) -> None:
    title = phone.tab.get_by_text(TITLE, exact=True)
    phone.settle()
    phone.until(lambda: phone.tab.evaluate(_SMALL) == [], "what a finger can hit")
    title.click()
    phone.until(lambda: _are_both_seen(phone), "the scene above the sheet")
    phone.until(lambda: phone.tab.evaluate(_HEADING, 14), "a finger's width of the heading")
    phone.settle()
    for corner in ([0.0, 0.0, 0.0], [6.0, 6.0, 6.0], [6.0, 0.0, 6.0], [0.0, 6.0, 0.0]):
        # the camera follows what the server hears of the sheet
        phone.until(lambda: phone.is_free(phone.pixel("/workspace", corner)), f"{corner}")  # noqa: B023
    tabs = phone.tab.get_by_text("Result · Learn ·").or_(phone.tab.get_by_role("tab"))
    tabs.first.click()
    phone.until(lambda: _in_sight(phone), "the tabs")
    for name in ("Plots", "Scene", "Layers", "Learn", "Search", "Result"):
        phone.click(name)
        phone.until(lambda: _in_sight(phone), f"the tab {name}")
        phone.settle()
        assert phone.tab.evaluate(_WIDTHS) == [390, 390]
        assert _are_both_seen(phone)
        assert phone.tab.evaluate(_SMALL) == [], name
    # hints rarely open without a mouse, so one is put there
    phone.tab.evaluate(_HINT)
    hint = phone.tab.locator(".mantine-Tooltip-tooltip")
    assert hint.count() == 1
    phone.frames(3)
    assert not hint.is_visible(), "a hint over the sheet"
    _fold(phone)
    phone.click("Lessons")
    phone.reads("1. ")
    phone.until(lambda: _in_sight(phone), "the lessons")
    phone.click("1. The mesh")
    phone.click("They are removed")
    on = phone.tab.get_by_role("button", name="Next", exact=True)
    phone.until(lambda: _reaches(on) <= 844, "what is said to the answer, and the way on")
    phone.click("Next")
    # at once, while what the clicks before asked for is still being drawn
    phone.click("Go to stage 1")
    spacing = phone.row("spacing [cm]")
    phone.until(lambda: 422 < spacing.bounding_box()["y"] < 800, "the stage of the task")  # type: ignore[index]
    phone.tab.wait_for_timeout(2_000)
    assert 422 < spacing.bounding_box()["y"] < 800  # type: ignore[index]
    phone.click("Back to lesson")
    phone.until(lambda: _in_sight(phone), "the lesson")
    phone.click("End lesson")
    _fold(phone)
    assert not phone.errors


@pytest.mark.slow
def test_a_lecture_shows_every_headline_whole(phone: Page) -> None:
    phone.settle()
    phone.tab.keyboard.press("l")
    for height in (844, 790):
        phone.tab.set_viewport_size({"width": 390, "height": height})
        phone.until(lambda: bool(phone.tab.evaluate(_WHOLE_HEADLINES)), f"them at {height}")
    assert not phone.errors
