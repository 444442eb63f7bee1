"""Labels in the scene can be read, from wherever one looks."""

from __future__ import annotations

import itertools
from typing import TypeAlias

import pytest

from abi.scene.scene import scene_names
from app.tab.session import Session
from tests.browser.page import Page

Box: TypeAlias = tuple[float, float, float, float]

_FARTHEST = 150
"""Pixels by which a label may stand beside its place."""

# Name and box (left, top, right, bottom), [px], of the text of each label that is seen, without the
# ground around it: viser draws them 12 px high at a scale of 1, in the first of these fonts.
_LABELS = """() => {
  const {camera, canvas, nodePoseData, nodeRefFromName} = window.__viserMutable;
  const parent = name => nodeRefFromName[name.slice(0, name.lastIndexOf("/"))];
  const context = document.createElement("canvas").getContext("2d");
  const view = canvas.getBoundingClientRect();
  const fonts = '-apple-system, BlinkMacSystemFont, "Segoe UI", "Roboto", "Helvetica Neue", Arial';
  const parts = {left: 0, top: 0, center: 0.5, right: 1, bottom: 1};
  camera.updateMatrixWorld();
  return Object.entries(window.__viserSceneTree.getState())
    .filter(([name, node]) => node?.message?.type === "LabelMessage" && parent(name))
    .filter(([, node]) => node.effectiveVisibility && node.message.props.text)
    .map(([name, {message: {props: {text, anchor, font_screen_scale}}}]) => {
      const height = 12 * font_screen_scale, [vertical, horizontal] = anchor.split("-");
      context.font = `${height}px ${fonts}, sans-serif`;
      const width = context.measureText(text).width, place = parent(name).position.clone();
      place.set(...(nodePoseData[name]?.position ?? [0, 0, 0]));
      const {x, y} = place.applyMatrix4(parent(name).matrixWorld).project(camera);
      const left = view.left + view.width * (1 + x) / 2 - parts[horizontal] * width;
      const top = view.top + view.height * (1 - y) / 2 - parts[vertical] * height;
      return [name, [left, top, left + width, top + height]];
    });
}"""


def _labels(page: Page) -> dict[str, Box]:
    return {name: tuple(box) for name, box in page.tab.evaluate(_LABELS)}


def _overlapping(page: Page) -> list[tuple[str, str]]:
    """Pairs of labels that lie over each other."""
    return [
        (first, second)
        for (first, a), (second, b) in itertools.combinations(_labels(page).items(), 2)
        if a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
    ]


def _shifts(page: Page) -> list[float]:
    """Distance of labels from their places, [px]."""
    script = "() => [...abiLabels.placed.values()].map(({shift}) => Math.hypot(...shift))"
    return list(page.tab.evaluate(script))


@pytest.mark.slow
def test_labels_of_the_shipped_scenes_keep_apart(page: Page, session: Session) -> None:
    moved = 0
    for name in scene_names()[::3]:
        page.click("Scene")
        page.choose("scene", name)
        page.until(lambda: session.resting and session.panels.files.name == name, f"scene {name}")  # noqa: B023
        page.settle()
        page.until(lambda: _overlapping(page) == [], f"labels apart in {name}")
        assert {"/start/label", "/goal/label"} <= set(_labels(page))
        shifts = _shifts(page)
        assert all(shift < _FARTHEST for shift in shifts)
        moved += len(shifts)
    assert moved > 0, "labels that would have lain over each other"
    page.choose("scene", "paper")


def test_labels_keep_apart_when_the_camera_turns(page: Page) -> None:
    for end in ((420.0, 520.0), (800.0, 150.0)):
        page.drag((600.0, 560.0), end)
        page.settle()
        page.until(lambda: _overlapping(page) == [], "labels apart")


# Turns the camera once round in so many jumps; for each jump, pairs that lie over each other in the
# third picture after it, and labels that stand beside their places. The clock, which places them as
# well, rests meanwhile.
_JUMPS = f"""async count => {{
  const boxes = {_LABELS}, {{cameraControl}} = window.__viserMutable, found = [];
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
_FOLLOWED = """() => [...abiLabels.placed].map(([name, {base, set}]) => {
  const pose = window.__viserMutable.nodePoseData[name], by = [0.1, -0.2, 0.3];
  pose.position = base.map((value, k) => value + by[k]);
  const off = Math.hypot(...pose.position.map((value, k) => value - set[k] - by[k]));
  pose.position = base;
  return off;
})"""


def test_a_label_that_is_moved_keeps_apart_at_once(page: Page) -> None:
    # from far away they crowd
    page.tab.evaluate("() => void window.__viserMutable.cameraControl.dolly(-30, false)")
    page.until(lambda: bool(_shifts(page)), "a label beside its place")
    offs = page.tab.evaluate(_FOLLOWED)
    assert offs
    assert max(offs) < 1e-9
    page.until(lambda: _overlapping(page) == [], "labels apart")


# Ground and letters of labels as they are drawn: their grey, from 0 to 1.
_TINTS = """() => abiLabels.materials().map(({fragmentShader}) =>
  Number(fragmentShader.match(/gl_FragColor = vec4\\(([\\d.]+)/)[1]))"""


def _luminance(grey: float) -> float:
    """Relative luminance of a grey (WCAG 2.1)."""
    return grey / 12.92 if grey <= 0.04045 else float(((grey + 0.055) / 1.055) ** 2.4)


def test_labels_are_dark_on_the_dark_page_and_can_be_read(page: Page) -> None:
    page.until(lambda: bool(page.tab.evaluate(_TINTS)), "labels")
    for dark in (True, False):
        page.click("Layers")
        page.tick("dark page", dark)
        page.until(lambda: (page.tab.evaluate(_TINTS)[0] < 0.5) == dark, "their ground")  # noqa: B023
        page.settle()
        *grounds, letters = page.tab.evaluate(_TINTS)
        for ground in grounds:
            # through a ground of 85 % shines, at the worst, what is as bright as the letters
            light, pale = sorted((_luminance(letters), _luminance(0.85 * ground + 0.15 * letters)))
            assert (pale + 0.05) / (light + 0.05) >= 4.5
    page.click("Result")
    assert not page.errors
