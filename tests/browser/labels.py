"""Labels of the scene, where they stand on the page."""

from __future__ import annotations

import itertools
from typing import TypeAlias

from tests.browser.page import Page

Box: TypeAlias = tuple[float, float, float, float]

FARTHEST = 150
"""Pixels by which a label may stand beside its place."""

# Name and box (left, top, right, bottom), [px], of the text of each label that is seen, without the
# ground around it: viser draws them 12 px high at a scale of 1, in the first of these fonts.
LABELS = """() => {
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

# Of labels that are gone the page keeps the last shift.
_SHIFTS = """() => {
  const {nodePoseData} = window.__viserMutable;
  return [...abiLabels.placed].filter(([name]) => nodePoseData[name])
    .map(([, {shift}]) => Math.hypot(...shift));
}"""


def labels(page: Page) -> dict[str, Box]:
    """Name and box of each label that is seen."""
    return {name: tuple(box) for name, box in page.tab.evaluate(LABELS)}


def overlapping(page: Page) -> list[tuple[str, str]]:
    """Pairs of labels that lie over each other."""
    return [
        (first, second)
        for (first, a), (second, b) in itertools.combinations(labels(page).items(), 2)
        if a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
    ]


def shifts(page: Page) -> list[float]:
    """Distance of labels from their places, [px]."""
    return list(page.tab.evaluate(_SHIFTS))
