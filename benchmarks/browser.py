"""Latency from the pointer to the drawn path, in a real browser.

    python -m benchmarks.browser --nodes 200 20000 200000

A real Chromium, without a graphics card, shows the paper's scene on a mesh of that many nodes. The
cube's gizmo is dragged a step at a time, each timed from the pointer's event to the first frame
with a new curve. Then it is dragged without waiting, and the last picture compared with the plan.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import Browser, sync_playwright

from abi.scene.scene import Scene, load_scene
from app.server.server import start
from app.state.appearance import PLAIN
from app.tab.session import Session
from tests.browser.page import FLAGS, Page

STEPS = 40
SWEEPS = 2.0
"""Seconds of the drag without waiting."""

_CURVE = "/curve/bspline"
_TIMEOUT_MS = 10_000

# Resolves to the time [ms] from the next pointer event to the first frame after a new curve came.
_WATCH = """([name, most]) => {
  const curve = () => window.__viserSceneTree.getState()[name].message.props.points;
  const before = curve();
  window.__drawn = new Promise(done => {
    window.addEventListener('pointermove', () => {
      const begin = performance.now(), passed = () => performance.now() - begin;
      const look = () => {
        if (curve() !== before) requestAnimationFrame(() => done(passed()));
        else if (passed() > most) done(null);
        else requestAnimationFrame(look);
      };
      look();
    }, {once: true, capture: true});
  });
}"""


def measure(nodes: int, browser: Browser) -> dict[str, Any]:
    """Drag the paper's cube in a mesh of about ``nodes`` nodes.

    Returns:
        ``nodes``; ``p50_ms`` and ``p95_ms`` of a step, and ``frame_ms``, what drawing the scene
        takes by itself, which is most of it without a graphics card; the ``plans_per_s`` of the
        drag without waiting; and ``right``, whether the last curve in the page is that of the last
        position.
    """
    scene = scene_with(nodes)
    with _tab(scene, browser) as (page, session):
        gizmo = session.panels.obstacles.gizmos[0].name
        grip = [0.0, 0.0, 0.85 * page.props(gizmo)["scale"]]
        times = [_step(page, gizmo, grip, up=number % 20 < 10) for number in range(STEPS)]
        page.until(lambda: session.resting, "the plan at rest")
        frame = _frame_ms(page)
        before, begin = session.plans, time.monotonic()
        _sweep(page, gizmo, grip)
        plans, seconds = session.plans - before, time.monotonic() - begin
        page.until(lambda: session.resting, "the plan at rest")
        page.settle()
        assert session.plan is not None
        assert session.plan.bspline is not None
        drawn = page.points(_CURVE)
        last = session.plan.bspline.curve(np.linspace(0, 1, len(drawn) + 1))
        right = np.allclose(drawn[:, 0], last[:-1], atol=1e-4) and np.allclose(
            page.position(gizmo), session.plan.scene.obstacles[0].position, atol=1e-5
        )
    return {
        "nodes": scene.mesh.node_count(scene.workspace),
        "p50_ms": float(np.percentile(times, 50)),
        "p95_ms": float(np.percentile(times, 95)),
        "frame_ms": frame,
        "plans_per_s": plans / seconds,
        "right": bool(right),
    }


def scene_with(nodes: int) -> Scene:
    """The paper's scene on a mesh of about ``nodes`` nodes, pulled taut."""
    scene = load_scene("paper").replace(search={"taut": True}, mesh={"max_nodes": 2_000_000})
    pitches = np.geomspace(0.05, 2, 400).tolist()
    counts = [
        scene.mesh.model_copy(update={"pitch": pitch}).node_count(scene.workspace)
        for pitch in pitches
    ]
    nearest = int(np.abs(np.log(np.array(counts) / nodes)).argmin())
    return scene.replace(mesh={"pitch": pitches[nearest]})


@contextmanager
def chromium() -> Iterator[Browser]:
    """A headless Chromium: the one that ``CHROMIUM`` names, or the system's."""
    path = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(FLAGS))
        yield browser
        browser.close()


@contextmanager
def _tab(scene: Scene, browser: Browser) -> Iterator[tuple[Page, Session]]:
    """The scene in a tab of its own server, drawn and at rest."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scene.json"
        scene.save(file)
        server = start(port=0, scene=str(file), look=PLAIN)
    page = Page(browser, server.url, draws=True)
    try:
        page.until(lambda: len(server.sessions) == 1, "a session")
        (session,) = server.sessions.values()
        page.until(lambda: session.resting, "the first plan")
        page.settle()
        page.click("Pause")
        yield page, session
    finally:
        page.close()
        server.stop()


def _frame_ms(page: Page, count: int = 8) -> float:
    """Time of one frame when nothing changes, [ms]."""
    begin = time.monotonic()
    page.frames(count)
    return 1e3 * (time.monotonic() - begin) / count


def _step(page: Page, gizmo: str, grip: list[float], up: bool) -> float:
    """Drag the arrow a little; the time until the new curve is drawn, [ms]."""
    x, y = page.pixel(gizmo, grip)
    page.tab.mouse.move(x, y)
    page.frames(2)
    page.tab.mouse.down()
    page.frames(1)
    page.tab.evaluate(_WATCH, [_CURVE, _TIMEOUT_MS])
    page.tab.mouse.move(x, y + (-4 if up else 4))
    ms = page.tab.evaluate("() => window.__drawn")
    page.tab.mouse.up()
    assert ms is not None, "nothing was drawn"
    return float(ms)


def _sweep(page: Page, gizmo: str, grip: list[float]) -> None:
    """Drag the arrow to and fro for a while, as fast as the mouse reports."""
    x, y = page.pixel(gizmo, grip)
    page.tab.mouse.move(x, y)
    page.frames(2)
    page.tab.mouse.down()
    end, number = time.monotonic() + SWEEPS, 0
    while time.monotonic() < end:
        number += 1
        page.tab.mouse.move(x, y + 40 * np.sin(number / 15))
    page.tab.mouse.up()


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--nodes", type=int, nargs="+", default=[200, 20_000, 200_000])
    options = parser.parse_args()
    with chromium() as browser:
        for nodes in options.nodes:
            print(json.dumps(measure(nodes, browser)), flush=True)


if __name__ == "__main__":
    main()
