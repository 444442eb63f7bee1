"""Nothing is cut off, over something else or too pale, at any size and in wide and narrow fonts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray
from playwright.sync_api import Browser

from abi.scene.scene import load_scene, scene_names
from app.camera.extent import extent
from app.drawing.box import box_corners
from app.server.server import Server
from app.stages.catalogue import TITLES
from app.tab.session import Session
from app.ui.layout import TITLE
from app.ui.plan_notes import notes as stage_notes
from tests.browser.charts import counts, is_whole
from tests.browser.labels import FARTHEST, labels, shifts
from tests.browser.labels import overlapping as overlapping_labels
from tests.browser.page import Page
from tests.browser.texts import overlapping, texts
from tests.thorough import of_each_kind

_FONTS = {
    "wide": '"DejaVu Sans", Verdana, sans-serif',
    "narrow": '"Liberation Sans Narrow", "DejaVu Sans Condensed", "Arial Narrow", sans-serif',
}
_TABS = ("Learn", "Search", "Plots", "Scene", "Layers", "Result")
# the first is also what is left of 1920x1080 at a zoom of 200 %
_SMALL_SIZES = ((960, 540), (390, 844))
_SIZES = (*_SMALL_SIZES, (1280, 720), (1920, 1080))
_ON_A_LAPTOP = ("arm-in-the-way", "kitchen-ur5e", "paper")
"""Scenes of which no panel scrolls on a small laptop, at 1280x720."""
_EACH_KIND = (*_ON_A_LAPTOP, "find-a-base", "no-way", "pick-and-place", "sculpture")
"""Scenes with each kind of arm, of obstacles and of notes, one without a motion, one of tasks."""
_SCENE_WIDTH = "window.__viserMutable.canvas.getBoundingClientRect().width"
_SCHEME = "document.documentElement.dataset.mantineColorScheme"
_PAINTED = "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
_READABLE = 4.5
"""Contrast of text with its ground (WCAG 2.1, 1.4.3)."""

_SET_FONT = """font => {
  document.getElementById("font")?.remove();
  if (!font) return;
  const style = `<style id="font">* { font-family: ${font} !important }</style>`;
  document.head.insertAdjacentHTML("beforeend", style);
}"""

# What is wider than its panel, and bars that nothing needs; and how many panels were measured.
_MISFITS = """() => {
  const panels = [...document.querySelectorAll(".mantine-ScrollArea-viewport")]
    .filter(panel => panel.clientWidth > 0 && panel.clientHeight > 0);
  const root = document.documentElement, found = [];
  if (root.scrollWidth > innerWidth || root.scrollHeight > innerHeight) found.push("page scrolls");
  for (const panel of panels) {
    const bars = ":scope > .mantine-ScrollArea-scrollbar[data-state=visible]";
    const has = way => panel.parentElement.querySelector(`${bars}[data-orientation=${way}]`);
    const wide = panel.scrollWidth - panel.clientWidth;
    const high = panel.scrollHeight - panel.clientHeight;
    if (wide > 0 || has("horizontal")) found.push("panel scrolls sideways");
    if (has("vertical") && high <= 0) found.push("bar without need");
    const {left, right} = panel.getBoundingClientRect();
    for (const part of panel.querySelectorAll("*")) {
      const box = part.getBoundingClientRect();
      if (box.width > 0 && (box.left < left - 1 || box.right > right + 1)) {
        const text = part.textContent.slice(0, 30);
        found.push(`"${text}": ${box.left} to ${box.right} in ${left} to ${right}`);
      }
    }
  }
  return [panels.length, found];
}"""

# Scroll all panels to a height [px]; whether one was scrolled.
_SCROLL = """top => [...document.querySelectorAll(".mantine-ScrollArea-viewport")].map(panel => {
  const before = panel.scrollTop;
  panel.scrollTop = top;
  return panel.scrollTop !== before;
}).some(Boolean)"""

# Height of the content and of the frame of each panel that is open.
_HEIGHTS = """() => [...document.querySelectorAll(".mantine-ScrollArea-viewport")]
  .filter(part => part.clientWidth > 0).map(part => [part.scrollHeight, part.clientHeight])"""

# Where the left panel's controls and headings are, however far it is scrolled, [px].
_IN_SIGHT = "row => row.getBoundingClientRect().bottom <= innerHeight"
_CONTROLS = """() => {
  const panel = document.querySelector(".mantine-ScrollArea-viewport");
  return [...panel.querySelectorAll("input, button, .mantine-Paper-root")]
    .map(part => part.getBoundingClientRect()).filter(box => box.height > 0)
    .map(({left, top}) => [left, top + panel.scrollTop]);
}"""

# For each panel that scrolls: how far its content reaches, and where its bar begins, [px].
_BARS = """() => [...document.querySelectorAll(
  ".mantine-ScrollArea-scrollbar[data-orientation=vertical][data-state=visible]")]
  .filter(bar => bar.clientWidth > 0)
  .map(bar => [bar.parentElement.querySelector(".mantine-ScrollArea-content")
    .getBoundingClientRect().right, bar.getBoundingClientRect().left])"""

_STRIP = """() => Math.min(...[...document.querySelectorAll("#abi-overlay .abi-bottom > *")]
  .map(part => part.getBoundingClientRect()).filter(box => box.height > 0).map(box => box.top))"""

# For each slider that is seen: where its knob and dots end and the numbers below begin, [px].
_SLIDERS = """() => [...document.querySelectorAll(".mantine-Slider-root")].map(slider => {
  const sides = (part, side) => [...slider.querySelectorAll(`.mantine-Slider-${part}`)]
    .map(one => one.getBoundingClientRect()).filter(box => box.width > 0).map(box => box[side]);
  // digits are as high as the middle 0.7 of a line
  const digits = [...slider.querySelectorAll(".mantine-Slider-markLabel")].map(label => {
    const range = document.createRange();
    range.selectNodeContents(label);
    const {top, height} = range.getBoundingClientRect();
    return top + 0.15 * height;
  });
  return [Math.max(...sides("thumb", "bottom"), ...sides("mark", "bottom")), Math.min(...digits)];
}).filter(([knob, text]) => isFinite(knob) && isFinite(text))"""

# For each checkbox that is seen: heights of its middle and of its label's, [px].
_CHECKBOXES = """() => [...document.querySelectorAll("input[type=checkbox]")]
  .filter(box => box.getBoundingClientRect().width > 0)
  .map(box => [box, document.querySelector(`label[for="${box.id}"]`)].map(part => {
    const {top, bottom} = part.getBoundingClientRect();
    return (top + bottom) / 2;
  }))"""

# For each plot that is seen: where its axes' names end, a little above the end of the canvas, and
# where the legend's text begins, [px].
_LEGENDS = """() => [...document.querySelectorAll(".uplot")]
  .filter(plot => plot.getBoundingClientRect().width > 0)
  .map(plot => {
    const range = document.createRange();
    range.selectNodeContents(plot.querySelector(".u-legend .u-series:nth-child(2) .u-label"));
    return [plot.querySelector("canvas").getBoundingClientRect().bottom,
      range.getBoundingClientRect().top];
  })"""

# For each heading between paragraphs that is seen: the space above it and below, [px].
_HEADINGS = """() => [...document.querySelectorAll("p ~ :is(h3, h4).mantine-Title-root")]
  .filter(heading => heading.getBoundingClientRect().width > 0)
  .map(heading => {
    const {top, bottom} = heading.getBoundingClientRect();
    return [top - heading.previousElementSibling.getBoundingClientRect().bottom,
      heading.nextElementSibling.getBoundingClientRect().top - bottom];
  })"""

# Boxes of what is written over the scene, and of the scene: left, top, right, bottom, [px].
_OVERLAY = """() => {
  const box = part => {
    const {left, top, right, bottom} = part.getBoundingClientRect();
    return [left, top, right, bottom];
  };
  const parts = [...document.querySelectorAll("#abi-overlay [data-part] > *")];
  return [box(window.__viserMutable.canvas),
    parts.map(box).filter(([left, top, right, bottom]) => right > left && bottom > top)];
}"""


def _check(page: Page) -> None:
    """Check what is on screen now."""
    page.tab.evaluate(_PAINTED)
    panels, misfits = page.tab.evaluate(_MISFITS)
    assert panels > 0
    assert misfits == []
    found = texts(page)
    assert len(found) >= 10
    assert [text for text in found if text.cut] == []
    assert overlapping(found) == []
    pale = {(text.text, text.contrast) for text in found if not text.disabled}
    assert {text for text in pale if text[1] < _READABLE} == set()
    _check_overlay(page)


def _check_overlay(page: Page) -> None:
    """Check that what is written over the scene is within it, each part beside the others."""
    scene, boxes = page.tab.evaluate(_OVERLAY)
    assert len(boxes) >= 3  # above a phone's open sheet there are no numbers
    for number, (left, top, right, bottom) in enumerate(boxes):
        assert scene[0] <= left < right <= scene[2] + 1
        assert scene[1] <= top < bottom <= scene[3] + 1
        for a, b, c, d in boxes[:number]:
            assert right <= a or c <= left or bottom <= b or d <= top, "two parts overlap"


def _put_back(page: Page) -> None:
    page.tab.set_viewport_size({"width": 1280, "height": 720})
    page.click("Result")


def _toggle_stages(page: Page) -> None:
    """Unfold the stages that begin folded, or fold them."""
    for stage in ("2 · Graph", "6 · Arm"):
        page.tab.get_by_role("button", name=stage).click()


def _darken(page: Page, dark: bool) -> None:
    page.click("Layers")
    page.tick("dark page", dark)
    name = "dark" if dark else "light"
    page.until(lambda: page.tab.evaluate(_SCHEME) == name, f"the {name} page")


@pytest.mark.slow
@pytest.mark.parametrize("size", _SMALL_SIZES, ids="{0[0]}x{0[1]}".format)
def test_everything_can_be_read(page: Page, size: tuple[int, int]) -> None:
    page.tab.set_viewport_size({"width": size[0], "height": size[1]})
    try:
        if size[0] < 600:  # there the panels are one sheet, folded, and the right one's is a line
            title = page.tab.get_by_text(TITLE, exact=True)
            page.until(lambda: title.bounding_box()["y"] > 780, "the sheet to fold")  # type: ignore[index]
            title.click()
            page.tab.get_by_text("Result · Learn ·").or_(page.tab.get_by_role("tab")).first.click()
        elif size[0] < 1000:
            page.until(lambda: page.tab.evaluate(_SCENE_WIDTH) > 0.85 * size[0], "them to fold")
            page.tab.get_by_text(TITLE, exact=True).click()
        _toggle_stages(page)
        # no text is wider for its colour: each font in one, on a phone the wide one in light
        for font in of_each_kind(_FONTS, "wide" if size[0] < 600 else "narrow"):
            _darken(page, font == "narrow")
            page.tab.evaluate(_SET_FONT, _FONTS[font])
            page.settle()
            for tab in _TABS:
                page.click(tab)
                _check(page)
                if page.tab.evaluate(_SCROLL, 1e6):
                    _check(page)
                    page.tab.evaluate(_SCROLL, 0)
    finally:
        page.tab.evaluate(_SET_FONT, "")
        _toggle_stages(page)
        _darken(page, False)
        _put_back(page)


@pytest.mark.slow
def test_shipped_scenes_can_be_read(page: Page, session: Session) -> None:
    moved = 0
    try:
        for name in of_each_kind(scene_names(), *_EACH_KIND):
            page.click("Scene")
            page.choose("scene", name)
            page.until(lambda: session.resting and session.panels.files.name == name, name)  # noqa: B023
            if name in _ON_A_LAPTOP:
                page.until(lambda: _fits(page), f"the Scene tab of {name} not to scroll")
            page.click("Result")
            page.settle()
            page.until(lambda: overlapping_labels(page) == [], f"labels apart in {name}")
            assert {"/start/label", "/goal/label"} <= set(labels(page))
            assert all(shift < FARTHEST for shift in shifts(page))
            moved += len(shifts(page))
            if session.frame.plan.motion is not None:
                page.until(lambda: is_whole(page, session.frame.duration), f"all of {name}")
            if name in _ON_A_LAPTOP:
                page.until(lambda: _fits(page), f"the panels of {name} not to scroll")
            # another test tries the other font; in this one most is cut off
            page.tab.evaluate(_SET_FONT, _FONTS["wide"])
            for tab in _TABS if name == "paper" else ("Result", "Plots"):
                page.click(tab)
                page.settle()
                _check(page)
                if session.frame.plan.motion is not None and tab in ("Result", "Plots"):
                    page.until(lambda: min(counts(page), default=0) >= 2, f"numbers in {name}")
            page.tab.evaluate(_SET_FONT, "")
        assert moved > 0, "labels that would have lain over each other"
    finally:
        page.tab.evaluate(_SET_FONT, "")
        _show_scene(page, session, "paper")


@pytest.mark.slow
def test_the_arms_foot_is_above_the_headline_numbers(page: Page, session: Session) -> None:
    try:
        for name in ("sculpture", "paper"):
            _show_scene(page, session, name)
            scene = load_scene(name)
            low, high = scene.workspace.min, scene.workspace.max
            seen = (scene.arm.base, low, (high[0], low[1], low[2]))
            for width, height in (1920, 1080), (960, 540), (1280, 720):
                page.tab.set_viewport_size({"width": width, "height": height})
                # its panels are folded
                page.until(
                    lambda: width > 1000 or page.tab.evaluate(_SCENE_WIDTH) > 0.85 * width,  # noqa: B023
                    "the page",
                )
                page.until(lambda: _are_above(page, seen), f"the arm of {name} at {width}")  # noqa: B023
            page.until(lambda: page.tab.evaluate(_SCENE_WIDTH) < 0.6 * 1280, "the panels")
    finally:
        _put_back(page)


def _are_above(page: Page, points: Sequence[Sequence[float]]) -> bool:
    """Check whether points, (n, 3), [unit], are above the headline numbers."""
    return all(page.pixel("/workspace", list(one))[1] < _strip(page) for one in points)


def _show_scene(page: Page, session: Session, name: str) -> None:
    page.click("Scene")
    page.choose("scene", name)
    page.until(lambda: session.resting and session.panels.files.name == name, name)
    page.click("Result")
    page.settle()


def _fits(page: Page) -> bool:
    return all(content <= frame for content, frame in page.tab.evaluate(_HEIGHTS))


def test_nothing_moves_in_the_panel_whose_value_is_changed(page: Page, session: Session) -> None:
    try:
        _show_scene(page, session, "arm-in-the-way")
        page.tab.get_by_text("6 · Arm").click()
        row = page.row("link clearance [cm]")
        page.until(row.is_visible, "the folder to open")
        page.until(lambda: row.evaluate(_IN_SIGHT), "the folder to be in sight")
        page.settle()
        before = page.tab.evaluate(_CONTROLS)
        notes = [_notes(session)]
        # with them the notes of stages 4 to 6 are of other lengths
        for clearance, fit in (
            (0.2, "several joined curves, none hitting"),
            (0.05, "paper's fit (may hit)"),
        ):
            page.set_number("link clearance [cm]", clearance)
            page.choose("curve", fit)
            page.until(lambda: session.frame.plan.scene.arm.clearance == clearance, "it")  # noqa: B023
            page.until(lambda: session.resting, "the plan")
            page.settle()
            notes.append(_notes(session))
            assert page.tab.evaluate(_CONTROLS) == before
        assert len(set(notes)) > 1
    finally:
        page.tab.get_by_text("6 · Arm").click()
        _show_scene(page, session, "paper")


def _notes(session: Session) -> str:
    return str(stage_notes(session.frame.plan))


def test_no_scroll_bar_lies_over_what_it_scrolls(page: Page) -> None:
    page.click("Learn")
    page.settle()
    page.until(lambda: not _fits(page), "the text to need a bar")
    bars = page.tab.evaluate(_BARS)
    assert bars
    assert all(content <= bar for content, bar in bars), bars
    page.click("Result")


def test_a_narrow_page_begins_with_folded_panels(chromium: Browser, server: Server) -> None:
    page = Page(chromium, server.url, 780, 700)
    try:
        page.until(lambda: page.tab.evaluate(_SCENE_WIDTH) > 0.85 * 780, "the panels to fold")
        page.click("Lecture")
        page.click("End lecture")
        page.settle()
        assert page.tab.evaluate(_SCENE_WIDTH) > 0.85 * 780
        page.tab.get_by_text("Learn", exact=True).click()
        page.until(lambda: page.tab.evaluate(_SCENE_WIDTH) < 0.6 * 780, "one panel to open")
        assert not page.errors
    finally:
        page.close()


def test_a_window_made_narrow_folds_its_panels_until_it_is_wide_again(page: Page) -> None:
    try:
        for width, least, most in ((900, 0.85, 1.0), (1280, 0.2, 0.6)):
            page.tab.set_viewport_size({"width": width, "height": 720})
            page.until(
                lambda: least < page.tab.evaluate(_SCENE_WIDTH) / width < most,  # noqa: B023
                f"the panels at {width} px",
            )
    finally:
        _put_back(page)


@pytest.mark.slow
@pytest.mark.parametrize("size", of_each_kind(_SIZES, (390, 844), (1280, 720)))
def test_a_lecture_shows_the_whole_arm_above_its_strip(
    size: tuple[int, int], page: Page, session: Session
) -> None:
    width, height = size
    page.click("Lecture")
    page.tab.set_viewport_size({"width": width, "height": height})
    try:
        assert session.plan is not None
        points = extent(session.plan)
        most = 0.26 if width > 600 else 0.4

        def is_right() -> bool:
            return _is_seen(page, points, height) and 1 - _strip(page) / height <= most

        # a phone's sheet takes its time to fold
        page.until(is_right, f"the arm above the strip of {most:.0%}", 120)
    finally:
        page.tab.set_viewport_size({"width": 1280, "height": 720})
        page.click("End lecture")
        _put_back(page)


@pytest.mark.slow
def test_a_lecture_in_a_hall_is_filled_by_the_workspace(page: Page, session: Session) -> None:
    assert session.plan is not None
    workspace = session.plan.scene.workspace
    corners = box_corners(workspace.min, workspace.max)
    page.click("Lecture")
    page.tab.set_viewport_size({"width": 1920, "height": 1080})
    try:

        def fills() -> bool:
            pixels = np.array([page.pixel("/workspace", list(corner)) for corner in corners])
            across, down = np.ptp(pixels, axis=0) / (1920, 1080)
            return bool(across >= 0.45 and down >= 0.55)

        for title in list(TITLES.values())[:5]:
            page.click(">")
            page.reads(title)
            page.until(fills, f"the workspace to fill the page in {title}")
    finally:
        page.tab.set_viewport_size({"width": 1280, "height": 720})
        page.click("End lecture")
        _put_back(page)


def _strip(page: Page) -> float:
    """Top of a lecture's strip, [px] from that of the page."""
    return float(page.tab.evaluate(_STRIP))


def _is_seen(page: Page, points: NDArray[np.float64], height: int) -> bool:
    """Check whether the scene has all points, and nothing of a lecture's strip over them."""
    left, _, right, _ = page.tab.evaluate(_OVERLAY)[0]
    chosen = np.vstack([points[:9], points[9 :: len(points) // 50]])
    pixels = np.array([page.pixel("/workspace", list(point)) for point in chosen])
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    inside = left <= low[0] and high[0] <= right and low[1] >= 0 and high[1] <= _strip(page)
    return bool(inside and np.ptp(pixels, axis=0).max() > 0.3 * min(right - left, height))


def test_the_numbers_under_a_slider_are_below_its_knob(page: Page) -> None:
    rows = page.tab.evaluate(_SLIDERS)
    assert len(rows) > 3
    assert all(knob <= text for knob, text in rows), rows


def test_no_line_of_the_sentence_ends_within_a_word_or_before_a_unit(page: Page) -> None:
    words = page.tab.locator("#abi-overlay [data-part=message] span")
    assert words.count() >= 2  # curve and length, and how long it took where that is known
    lines = [
        page.tab.evaluate("part => part.getClientRects().length", part)
        for part in words.element_handles()
    ]
    assert set(lines) == {1}


def test_a_checkbox_is_level_with_its_label(page: Page) -> None:
    page.click("Layers")
    page.settle()
    rows = page.tab.evaluate(_CHECKBOXES)
    assert len(rows) > 15
    assert all(abs(box - label) < 1.5 for box, label in rows), rows
    page.click("Result")


def test_a_plots_legend_is_below_the_name_of_its_axis(page: Page) -> None:
    rows = page.tab.evaluate(_LEGENDS)
    assert rows
    assert all(axis <= legend <= axis + 8 for axis, legend in rows), rows


def test_a_heading_is_nearer_to_its_own_text_than_to_the_text_before(page: Page) -> None:
    page.click("Learn")
    page.settle()
    rows = page.tab.evaluate(_HEADINGS)
    assert len(rows) > 4
    assert all(above > 2 * below + 4 for above, below in rows), rows
    page.click("Result")


def test_the_name_of_every_layer_is_on_one_line(page: Page) -> None:
    page.click("Layers")
    page.settle()
    row = ".mantine-Flex-root:has(input[type=checkbox])"
    names = page.tab.locator(f"{row} label").filter(visible=True)
    heights = {row["height"] for row in (name.bounding_box() for name in names.all()) if row}
    assert names.count() > 15
    assert max(heights) < 1.5 * min(heights), heights
    page.until(lambda: _fits(page), "the list not to scroll")
    page.click("Result")
