"""The moving picture of the README: an obstacle is dragged, the path follows, the arm moves.

Every frame is the real page in a real Chromium. They are taken one at a time, each when the plan
for it has been drawn, and shown at an even pace: a machine without a graphics card draws slower
than that.
"""

from __future__ import annotations

import math
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser

from abi.scene.scene import Scene, load_scene
from app.state.appearance import OPENING
from tools.visit import Visit, visit

DRAGGED, MOVED = 28, 34
"""Frames of the drag, there and back, and of the arm's motion."""
RISE = 1.5  # how far the obstacle is dragged along z, [unit]
SIZE = (960, 540)
FRAME_MS = 90
STANDING = 0.45  # of the motion: where the arm is during the drag
QUALITY = 62

# A mouse pointer, since a picture of a page has none.
_POINTER = """() => {
  const arrow = document.createElement('div');
  arrow.innerHTML = '<svg width="26" height="26" viewBox="0 0 24 24">' +
    '<path d="M4 2l15 13-7 1 4 6-3 2-4-7-5 4z" fill="#fff" stroke="#111" ' +
    'stroke-width="1.5"/></svg>';
  arrow.style.cssText = 'position:fixed;z-index:99999;pointer-events:none;left:-50px;top:0';
  document.body.append(arrow);
  window.addEventListener('pointermove', event => {
    arrow.style.left = event.clientX - 4 + 'px';
    arrow.style.top = event.clientY - 2 + 'px';
  }, {capture: true});
}"""


def shoot(browser: Browser) -> list[Image.Image]:
    """Take the frames."""
    with visit(browser, scene()) as visited:
        visited.time(STANDING)
        visited.page.tab.evaluate(_POINTER)
        return [*_drag(visited), *_move(visited)]


def scene() -> Scene:
    """The scene that the page opens on."""
    return load_scene(OPENING)


def write(frames: list[Image.Image], file: Path) -> None:
    """Write the frames as a WebP that repeats for ever."""
    small = [frame.resize(SIZE, Image.Resampling.LANCZOS) for frame in frames]
    pauses = [FRAME_MS] * len(small)
    pauses[-1] = 12 * FRAME_MS
    small[0].save(
        file,
        save_all=True,
        append_images=small[1:],
        duration=pauses,
        loop=0,
        quality=QUALITY,
        method=6,
    )


def _drag(visited: Visit) -> list[Image.Image]:
    """Pull the obstacle up and down again."""
    page, mouse = visited.page, visited.page.tab.mouse
    gizmo = visited.session.panels.obstacles.gizmos[0].name
    start, end = page.pixel(gizmo), page.pixel(gizmo, (0, 0, RISE))
    frames = []
    mouse.move(*start)
    page.frames(3)
    mouse.down()
    page.frames(2)
    for k in range(DRAGGED + 1):
        part = math.sin(2 * math.pi * k / DRAGGED) * (1.0 if 2 * k <= DRAGGED else 0.8)
        mouse.move(start[0] + part * (end[0] - start[0]), start[1] + part * (end[1] - start[1]))
        page.frames(2)
        visited.rest()
        frames.append(visited.picture())
    mouse.up()
    visited.rest()
    return frames


def _move(visited: Visit) -> list[Image.Image]:
    """Let the arm follow the curve."""
    visited.page.tab.mouse.move(640, 690)
    frames = []
    for k in range(MOVED + 1):
        visited.time(k / MOVED)
        frames.append(visited.picture())
    return frames
