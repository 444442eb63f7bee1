"""Nothing is cut off, at any size of the page and in a wide font."""

from __future__ import annotations

import pytest

from tests.browser.page import Page

_WIDE_FONT = '* { font-family: "DejaVu Sans", Verdana, sans-serif !important }'
_SIZES = ((960, 540), (1280, 720), (1440, 900), (1920, 1080), (390, 844))

# Width of the content and of the frame of each panel that is open, and of each table in it.
_WIDTHS = """() => [...document.querySelectorAll(".mantine-ScrollArea-viewport, .abi-table")]
  .filter(part => part.clientWidth > 0)
  .map(part => part.matches("table")
    ? [part.offsetWidth, part.parentElement.clientWidth] : [part.scrollWidth, part.clientWidth])"""

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

# Contrast of each ✓ and ✗ in the tables with the panel behind it (WCAG 2.1, 1.4.3).
_CONTRASTS = """() => {
  const numbers = colour => colour.match(/[\\d.]+/g).map(Number);
  const light = ([r, g, b]) => [r, g, b].map(c => c / 255)
    .map(c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)
    .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
  const ground = part => {
    const found = getComputedStyle(part).backgroundColor;
    return (numbers(found)[3] ?? 1) === 1 ? found : ground(part.parentElement);
  };
  return [...document.querySelectorAll(".abi-table td > span")]
    .filter(part => part.textContent.match(/[✓✗]/))
    .map(part => [getComputedStyle(part).color, ground(part)].map(numbers).map(light))
    .map(([a, b]) => (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05));
}"""


@pytest.mark.parametrize("size", _SIZES)
def test_no_panel_is_wider_than_its_frame(page: Page, size: tuple[int, int]) -> None:
    page.tab.add_style_tag(content=_WIDE_FONT)
    page.tab.set_viewport_size({"width": size[0], "height": size[1]})
    try:
        page.settle()
        widths = page.tab.evaluate(_WIDTHS)
        assert widths
        assert all(content <= frame for content, frame in widths), widths
        scene, boxes = page.tab.evaluate(_OVERLAY)
        assert len(boxes) >= 4
        for number, (left, top, right, bottom) in enumerate(boxes):
            assert scene[0] <= left < right <= scene[2] + 1
            assert scene[1] <= top < bottom <= scene[3] + 1
            for a, b, c, d in boxes[:number]:
                assert right <= a or c <= left or bottom <= b or d <= top, "two texts overlap"
    finally:
        page.tab.set_viewport_size({"width": 1280, "height": 720})


@pytest.mark.parametrize("dark", [False, True])
def test_signs_can_be_read(page: Page, dark: bool) -> None:
    page.click("Layers")
    page.tick("dark page", dark)
    page.click("Result")
    page.settle()
    try:
        page.until(
            lambda: min(page.tab.evaluate(_CONTRASTS), default=0.0) >= 4.5, "signs that stand out"
        )
    finally:
        page.click("Layers")
        page.tick("dark page", False)
        page.click("Result")
