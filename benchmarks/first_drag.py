"""Time from opening a page to the first picture that answers a drag of its obstacle.

    python -m benchmarks.first_drag
    python -m benchmarks.first_drag --cold
    python -m benchmarks.first_drag --look 4 --no-plain

A server of its own has begun before; with ``--cold`` it finds no compiled kernels, as on a new
machine. Options that are not told here are the server's. As soon as a Chromium without a graphics
card has the curve, a mouse takes the obstacle and moves it to and fro, as a visitor does who does
not wait; or after a ``--look`` of some seconds.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from playwright.sync_api import Browser

from benchmarks.browser import chromium

_OBSTACLE, _BODY = "/obstacle_1", "/obstacle_1/body"
_PATIENCE_MS = 120_000.0
_SWEEP = 3.0
"""Seconds of the drag after its first answer."""
_STEP_MS = 50.0

# The curve is there, and the panels have made room for the scene.
_DRAWN = """name => window.__viserMutable?.nodeRefFromName?.[name]
  && window.__viserSceneTree.getState()["/curve/bspline"]?.message.props.points?.length
  && window.__viserMutable.canvas.getBoundingClientRect().width < innerWidth"""

# Notes when the obstacle has first moved after the press, and each new curve after that.
_WATCH = """name => {
  const curve = () => window.__viserSceneTree.getState()["/curve/bspline"]?.message.props.points;
  const place = () => JSON.stringify(window.__viserMutable.nodePoseData[name]?.position ?? null);
  let pressed = false, moved = false, lastCurve, lastPlace;
  window.__answers = [];
  addEventListener("pointerdown", () => {
    [pressed, lastCurve, lastPlace] = [true, curve(), place()];
  }, {capture: true});
  const look = () => {
    if (pressed) moved ||= place() !== lastPlace;
    if (moved && curve() !== lastCurve) window.__answers.push(performance.now() / 1000);
    lastCurve = curve();
    requestAnimationFrame(look);
  };
  look();
}"""

_PIXEL = """name => {
  const {nodeRefFromName, camera, canvas} = window.__viserMutable, node = nodeRefFromName[name];
  const place = node.localToWorld(node.position.clone().set(0, 0, 0)).project(camera);
  const {left, top, width, height} = canvas.getBoundingClientRect();
  return [left + width * (1 + place.x) / 2, top + height * (1 - place.y) / 2];
}"""


def measure(browser: Browser, cold: bool, look: float, *arguments: str) -> dict[str, float]:
    """Open a page, and drag.

    Returns:
        Seconds from the navigation: ``drawn_s`` to the curve, ``pressed_s`` to the mouse on the
        obstacle, ``answered_s`` to the first curve of where a hand has put it, of
        which ``waited_s`` since the hand set out; and ``updates_per_s`` in the seconds after that.
    """
    with _serving(cold, *arguments) as address:
        context = browser.new_context(viewport={"width": 1280, "height": 720})
        tab = context.new_page()
        tab.set_default_timeout(_PATIENCE_MS)
        begin = time.monotonic()
        tab.goto(address)
        tab.wait_for_function(_DRAWN, arg=_BODY, timeout=_PATIENCE_MS)
        drawn = time.monotonic() - begin
        tab.wait_for_timeout(1000 * look)
        taken = time.monotonic() - begin
        tab.evaluate(_WATCH, _OBSTACLE)
        x, y = tab.evaluate(_PIXEL, _BODY)
        tab.mouse.move(x, y)
        tab.mouse.down()
        pressed = time.monotonic() - begin
        answers: list[float] = []
        step, end = 0, begin + _PATIENCE_MS / 1000
        while time.monotonic() < end:
            step += 1
            tab.mouse.move(x + 4 * (step % 20), y - 3 * (step % 20))
            tab.wait_for_timeout(_STEP_MS)
            before, answers = answers, tab.evaluate("() => window.__answers")
            if answers and not before:
                end = time.monotonic() + _SWEEP
        tab.mouse.up()
        context.close()
    assert answers, "the drag was never answered"
    rate = (len(answers) - 1) / _SWEEP
    return {
        "drawn_s": drawn,
        "pressed_s": pressed,
        "answered_s": answers[0],
        "waited_s": answers[0] - taken,
        "updates_per_s": rate,
    }


@contextmanager
def _serving(cold: bool, *arguments: str) -> Iterator[str]:
    """Address of a server that a visitor would get: with the demonstration."""
    command = [sys.executable, "-P", "-m", "app", "serve", "--no-open", "--port", "0"]
    with tempfile.TemporaryDirectory() as cache:
        changed = {"NUMBA_CACHE_DIR": cache} if cold else {}
        process = subprocess.Popen(
            [*command, "--log-level", "warning", *arguments],
            env=os.environ | changed,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert process.stdout is not None
        try:
            link = re.search(r"http://\S+", process.stdout.readline())
            assert link is not None, "the server did not start"
            yield link.group()
        finally:
            process.terminate()
            process.wait()
            process.stdout.close()


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cold", action="store_true", help="without compiled kernels")
    parser.add_argument("--look", type=float, default=0.0, help="seconds before the drag")
    parser.add_argument("--times", type=int, default=3)
    options, arguments = parser.parse_known_args()
    for _ in range(options.times):
        with chromium() as browser:  # anew: a browser keeps what it has compiled
            result: dict[str, Any] = measure(browser, options.cold, options.look, *arguments)
        result |= {"cold": options.cold, "load": os.getloadavg()[0]}
        print(json.dumps(result), flush=True)


if __name__ == "__main__":
    main()
