"""Labels in the scene can be read, from wherever one looks."""

from __future__ import annotations

from tests.browser.labels import LABELS, overlapping, shifts
from tests.browser.page import Page


def test_labels_keep_apart_when_the_camera_turns(page: Page) -> None:
    for end in ((420.0, 520.0), (800.0, 150.0)):
        page.drag((600.0, 560.0), end)
        page.settle()
        page.until(lambda: overlapping(page) == [], "labels apart")


# Turns the camera once round in so many jumps; for each jump, pairs that lie over each other in the
# third picture after it, and labels that stand beside their places. The clock, which places them as
# well, rests meanwhile.
_JUMPS = f"""async count => {{
  const boxes = {LABELS}, {{cameraControl}} = window.__viserMutable, found = [];
  const info = window.__viserTestpoints.rendererInfo.render;
  clearInterval(abiPlacing);
  for (let jump = 0; jump < count; jump++) {{
    cameraControl.rotate(2 * Math.PI / count, 0, false);
    for (const last = info.frame + 3; info.frame < last;) {{
      window.__viserMutable.requestRender();
      await new Promise(requestAnimationFrame);
    }}
    const labels = boxes().map(([, box]) => box);
    const over = labels.flatMap((a, k) => labels.slice(0, k)
      .filter(b => a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]));
    found.push([over.length, abiLabels.placed.size]);
  }}
  window.abiPlacing = setInterval(() => abiLabels.place(), 120);
  return found;
}}"""


def test_labels_are_apart_in_the_next_pictures_after_the_camera_jumps(page: Page) -> None:
    rows = page.tab.evaluate(_JUMPS, 24)
    assert sum(beside for _, beside in rows) > 12, "labels that would lie over each other"
    assert [over for over, _ in rows] == [0] * 24


# How far each label beside its place is, once the server has moved it, from where it should be.
_FOLLOWED = """() => [...abiLabels.placed].flatMap(([name, {base, set}]) => {
  const pose = window.__viserMutable.nodePoseData[name], by = [0.1, -0.2, 0.3];
  if (!pose) return [];
  pose.position = base.map((value, k) => value + by[k]);
  const off = Math.hypot(...pose.position.map((value, k) => value - set[k] - by[k]));
  pose.position = base;
  return off;
})"""


def test_a_label_that_is_moved_keeps_apart_at_once(page: Page) -> None:
    # from far away they crowd
    page.tab.evaluate("() => void window.__viserMutable.cameraControl.dolly(-30, false)")
    page.until(lambda: bool(shifts(page)), "a label beside its place")
    offs = page.tab.evaluate(_FOLLOWED)
    assert offs
    assert max(offs) < 1e-9
    page.until(lambda: overlapping(page) == [], "labels apart")


# Greys, 0 to 1, of the grounds (which shine through) and of the letters of labels, as drawn.
_TINTS = """() => {
  const tints = [[], []];
  for (const {fragmentShader} of abiLabels.materials()) {
    const [, grey, rest] = fragmentShader.match(/gl_FragColor = vec4\\(([\\d.]+)(.*)/);
    tints[rest.includes("vAlpha") ? 0 : 1].push(Number(grey));
  }
  return tints;
}"""


def _luminance(grey: float) -> float:
    """Relative luminance of a grey (WCAG 2.1)."""
    return grey / 12.92 if grey <= 0.04045 else float(((grey + 0.055) / 1.055) ** 2.4)


def _contrast(grounds: list[float], letters: list[float]) -> float:
    """Least contrast of the letters on any of the grounds."""
    # through a ground of 85 % shines, at the worst, what is as bright as the letters
    pairs = [(grey, 0.85 * ground + 0.15 * grey) for ground in grounds for grey in letters]
    both = [sorted(map(_luminance, pair)) for pair in pairs]
    return min((pale + 0.05) / (dark + 0.05) for dark, pale in both)


def test_labels_are_dark_on_the_dark_page_and_can_be_read(page: Page) -> None:
    page.until(lambda: all(page.tab.evaluate(_TINTS)), "labels")
    for dark in (True, False):
        page.click("Layers")
        page.tick("dark page", dark)
        page.until(lambda: (max(page.tab.evaluate(_TINTS)[0]) < 0.5) == dark, "their ground")  # noqa: B023
        page.until(lambda: _contrast(*page.tab.evaluate(_TINTS)) >= 4.5, "letters to be read")
    page.click("Result")
    assert not page.errors
