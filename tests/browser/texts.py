"""Every text on the page as it is drawn: where, and how far it stands out from its ground."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

from tests.browser.page import Page

# One row for each line of text that is seen: text, box [px], contrast (WCAG 2.1, 1.4.3), whether
# its control is disabled, and whether it is cut off.
_TEXTS = r"""() => {
  const canvas = document.createElement("canvas");
  const paint = canvas.getContext("2d", {willReadFrequently: true});
  // nothing changes meanwhile: each is asked for once
  const once = find => {
    const known = new Map();
    return key => (known.has(key) || known.set(key, find(key)), known.get(key));
  };
  const style = once(part => getComputedStyle(part));
  const box = once(part => part.getBoundingClientRect());
  const rgba = once(colour => {
    paint.clearRect(0, 0, 1, 1);
    paint.fillStyle = colour;
    paint.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = paint.getImageData(0, 0, 1, 1).data;
    return [r, g, b, a / 255];
  });
  const over = ([r, g, b, a], below) => [r, g, b].map((c, i) => a * c + (1 - a) * below[i]);
  const ground = once(part => {
    const own = rgba(style(part ?? document.body).backgroundColor);
    return !part || own[3] > 0.99 ? own : over(own, ground(part.parentElement));
  });
  const light = colour => colour.slice(0, 3).map(c => c / 255)
    .map(c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)
    .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
  const contrast = once(part => {
    const behind = ground(part), ink = over(rgba(style(part).color), behind);
    const [a, b] = [light(ink), light(behind)];
    return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
  });
  // headings below which their panel scrolls
  const heads = [...document.querySelectorAll(".mantine-ScrollArea-content > div > div")]
    .filter(part => getComputedStyle(part).position === "sticky");
  // the part of a box that is seen: on the page, and in every frame around it
  const seen = (part, {left, top, right, bottom}) => {
    const page = [0, 0, innerWidth, innerHeight], frames = [];
    for (let frame = part; frame && frame !== document.body; frame = frame.parentElement) {
      const {visibility, opacity, overflowX, overflowY} = style(frame);
      if (visibility === "hidden" || Number(opacity) < 0.1) return null;
      if (overflowX === "visible" && overflowY === "visible") continue;
      const {left: a, top: b, right: c, bottom: d} = box(frame);
      const head = heads.find(one => frame.contains(one) && !one.contains(part));
      frames.push([a, (head && box(head).bottom) ?? b, c, d]);
    }
    const inner = k => k < 2 ? Math.max : Math.min;
    const inside = [left, top, right, bottom]
      .map((side, k) => inner(k)(side, page[k], ...frames.map(frame => frame[k])));
    return inside[2] - inside[0] > 1 && inside[3] - inside[1] > 1 ? inside : null;
  };
  // what is written over the scene may be below a phone's sheet
  const covered = (part, [left, top, right, bottom]) => {
    if (!part.closest("#abi-overlay")) return false;
    const above = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
    return above !== window.__viserMutable.canvas && !above?.closest("#abi-overlay");
  };
  const found = [], walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node; (node = walker.nextNode());) {
    const part = node.parentElement, text = node.data.trim();
    // a formula's signs touch as they should
    if (!text || part.closest("style, script, math")) continue;
    // what is folded away has a place on the page, and is not seen
    if (part.closest("details:not([open])") && !part.closest("summary")) continue;
    const range = document.createRange();
    range.selectNodeContents(node);
    const cut = style(part).overflowX !== "visible" && part.clientWidth > 0
      && part.scrollWidth > part.clientWidth + 1;
    for (const rect of range.getClientRects()) {
      const visible = seen(part, rect);
      const off = part.closest("[disabled], [data-disabled]") !== null;
      if (visible && !covered(part, visible)) found.push([text, visible, contrast(part), off, cut]);
    }
  }
  return found;
}"""


@dataclass(frozen=True)
class Text:
    """A line of text on the page.

    Attributes:
        text: what stands there.
        box: left, top, right and bottom of what is seen of it, [px].
        contrast: with what is behind it, 1 to 21.
        disabled: whether it belongs to a control that cannot be used now.
        cut: whether it is wider than its frame.
    """

    text: str
    box: tuple[float, float, float, float]
    contrast: float
    disabled: bool
    cut: bool


def texts(page: Page) -> list[Text]:
    """All text that is seen, of panels and over the scene; not the labels in the scene."""
    rows = page.tab.evaluate(_TEXTS)
    return [Text(text, tuple(box), *others) for text, box, *others in rows]


def overlapping(found: list[Text]) -> list[tuple[str, str]]:
    """Pairs of texts that lie over each other."""
    return [
        (one.text, other.text)
        for one, other in itertools.combinations(found, 2)
        if _shared(one, other, 0) > 1 and _shared(one, other, 1) > 3
    ]


def _shared(one: Text, other: Text, axis: int) -> float:
    """Width or height that two boxes share, [px]; rows of a text touch by a pixel or two."""
    return min(one.box[2 + axis], other.box[2 + axis]) - max(one.box[axis], other.box[axis])
