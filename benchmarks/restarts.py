"""Nothing is lost: a real tab is edited while its server is killed, frozen or reloaded under it.

    python -m benchmarks.restarts --kills 200 --reloads 50 --freezes 3

The server is a process of its own, forked from one that has loaded everything, so that a restart
takes tenths of a second. Each time a number of the scene is changed in Chromium, and soon after,
often before the page was told to remember it, the server is killed with SIGKILL and started again,
or the page reloaded, or the server stopped for ten seconds as by a network that is cut. Then the
page must show what it last remembered, every link of the arm where that is planned, and every plot
a curve. After every tenth fault it prints the figures so far, and Ctrl+C ends it with those, as
the last line.
"""

from __future__ import annotations

import argparse
import functools
import json
import multiprocessing
import os
import random
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from typing import Any

from playwright.sync_api import Browser

import abi
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.planner.plan import Plan
from abi.scene.scene import Scene
from app.state.appearance import PLAIN
from app.state.tab_state import TabState
from benchmarks.browser import chromium
from benchmarks.interrupt import Interrupt
from benchmarks.poses import differing, planned
from tests.browser.page import Page
from tests.ports import free_port

FREEZE = 10.0
"""Seconds for which a network is cut."""
_LONGEST_PAUSE = 0.8
"""Seconds between an edit and the fault, at most: twice the period at which states are kept."""
_AGAIN = 3.0
"""Seconds in which a server may be killed again, at most: the page is just coming back."""
_PATIENCE = 60.0
_TOLD = 10
"""Faults between two accounts of the figures so far."""
_BOX, _VALUES = "degree", (2, 3, 5)
"""A number of the scene, and what it is set to: never what a new tab begins with."""
_TIME = 0.5
"""Where the arm stands in its motion, [s]."""
_CHARTS = """() => {
  const charts = Object.values(window.__viserTestpoints.uplots ?? {}).map(({chart}) => chart);
  return charts.length > 0 && charts.every(({scales, data}) =>
    scales.x.max > scales.x.min && data[0].length > 1
    && data.slice(1).some(line => line.some(Number.isFinite)));
}"""


class Killable:
    """A server that can be killed and started again at its address.

    Attributes:
        url: of its page.
    """

    def __init__(self, scene: str) -> None:
        port = free_port()
        self.url = f"http://127.0.0.1:{port}/"
        context = multiprocessing.get_context("spawn")
        self._pipe, other = context.Pipe()
        self._origin = context.Process(
            target=_fork_on_request, args=(other, port, scene), daemon=True
        )
        self._origin.start()
        self.start()

    def start(self) -> None:
        """Start it and wait until it listens."""
        self._pipe.send("start")
        self.pid = int(self._pipe.recv())

    def kill(self) -> None:
        """End it without a word."""
        os.kill(self.pid, signal.SIGKILL)

    def close(self) -> None:
        """End it for good."""
        self.kill()
        self._pipe.send("end")
        self._origin.join()


def _fork_on_request(pipe: Connection, port: int, scene: str) -> None:
    """Fork a server whenever the pipe asks for one, and tell its process id."""
    from abi import compiling
    from app.tab import session  # noqa: F401  loaded once for all

    compiling.compile()
    # Ctrl+C ends the run, which ends the servers
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    child = 0
    while pipe.recv() == "start":
        if child:
            os.waitpid(child, 0)
        ready, told = os.pipe()
        child = os.fork()
        if child == 0:
            _serve(port, scene, told)
        os.read(ready, 1)
        os.close(ready)
        os.close(told)
        pipe.send(child)


def _serve(port: int, scene: str, told: int) -> None:
    """The forked process: serve until killed."""
    from app.server.server import start

    start(port=port, scene=scene, look=PLAIN)
    os.write(told, b"1")
    while True:
        signal.pause()


class Tally:
    """Outcome of the faults so far.

    Attributes:
        lost: faults after which the page did not show what it remembered.
        misplaced: those after which the arm or an end stood elsewhere than planned.
        empty_plots: those after which a plot was empty.
        not_yet_kept: edits that came so shortly before one that the page had not been told to
            remember them.
        times: until the page was back, [s], with an edit that came while frozen done.
    """

    def __init__(self) -> None:
        self.lost = self.misplaced = self.empty_plots = self.not_yet_kept = 0
        self.times: list[float] = []
        self._faults: list[str] = []

    def add(self, fault: str, seconds: float, back: bool, placed: bool, plotted: bool) -> None:
        """Count a fault."""
        self._faults.append(fault)
        self.times.append(seconds)
        self.lost += not back
        self.misplaced += not placed
        self.empty_plots += not plotted
        print(f"{len(self.times)} {fault} {seconds:.1f} s {back}", file=sys.stderr, flush=True)
        if len(self.times) % _TOLD == 0:
            print(json.dumps({"so_far": True, **self.figures()}), flush=True)

    def figures(self) -> dict[str, Any]:
        """``kills``, ``reloads`` and ``freezes`` done, the counts, ``median_s`` and ``worst_s``."""
        done = {f"{fault}s": self._faults.count(fault) for fault in ("kill", "reload", "freeze")}
        counts = {
            "lost": self.lost,
            "misplaced": self.misplaced,
            "empty_plots": self.empty_plots,
            "not_yet_kept": self.not_yet_kept,
        }
        times = sorted(self.times)
        if not times:
            return {**done, **counts}
        return {**done, **counts, "median_s": times[len(times) // 2], "worst_s": times[-1]}


def measure(
    browser: Browser,
    kills: int,
    reloads: int,
    freezes: int,
    seed: int = 0,
    interrupt: Interrupt | None = None,
    scene: str = "paper",
) -> dict[str, Any]:
    """Go through the faults one by one with one tab, or until the interrupt: see :class:`Tally`."""
    chance, tally = random.Random(seed), Tally()
    faults = ["kill"] * kills + ["reload"] * reloads + ["freeze"] * freezes
    chance.shuffle(faults)
    interrupt = interrupt or Interrupt()
    try:
        with _tab(browser, scene) as (page, server):
            for number, fault in enumerate(faults):
                if interrupt.asked:
                    break
                _go_through(page, server, fault, _VALUES[number % len(_VALUES)], chance, tally)
    except Exception:
        # a browser of the same terminal ends with Ctrl+C, too
        if not interrupt.asked:
            print(json.dumps({"broken_off": True, **tally.figures()}), flush=True)
            raise
    return tally.figures()


def _go_through(
    page: Page, server: Killable, fault: str, value: int, chance: random.Random, tally: Tally
) -> None:
    """Edit, have the fault, and see what the page shows then."""
    if fault == "freeze":
        begin, kept = _freeze(page, server, value)
    else:
        _edit(page, value)
        page.tab.wait_for_timeout(1e3 * chance.uniform(0, _LONGEST_PAUSE))
        begin, kept = _interrupt(page, server, fault, chance)
        tally.not_yet_kept += kept != value
    back = _within(page, lambda: _shown(page) == kept == _remembered(page))
    seconds = time.monotonic() - begin
    plotted = _within(page, lambda: bool(page.tab.evaluate(_CHARTS)))
    tally.add(fault, seconds, back, _within(page, lambda: _placed(page)), plotted)


@contextmanager
def _tab(browser: Browser, scene: str) -> Iterator[tuple[Page, Killable]]:
    """A tab whose plan is drawn and whose arm stands still under way, and its server."""
    server = Killable(scene)
    page = Page(browser, server.url)
    try:
        page.node("/curve/bspline")
        page.set_time(_TIME)
        page.until(lambda: page.tab.evaluate("sessionStorage.getItem('abi-tab')"), "a memory")
        page.until(lambda: _kept(page).time == _TIME, "the time to be kept")
        yield page, server
    finally:
        page.close()
        server.close()


def _interrupt(
    page: Page, server: Killable, fault: str, chance: random.Random
) -> tuple[float, int]:
    """Kill the server or reload the page: when, and what the page then remembers.

    Every third server is killed again before the page may be whole.
    """
    if fault == "reload":
        begin = time.monotonic()  # returns when the page has connected
        page.reload()
        return begin, _remembered(page)
    before = page.connections
    server.kill()
    page.tab.wait_for_timeout(100)
    kept, begin = _remembered(page), time.monotonic()
    server.start()
    if chance.random() < 1 / 3:
        page.tab.wait_for_timeout(1e3 * chance.uniform(0, _AGAIN))
        server.kill()
        before = page.connections
        server.start()
    page.until(lambda: page.connections > before, "the page to connect", _PATIENCE)
    return begin, kept


def _freeze(page: Page, server: Killable, value: int) -> tuple[float, int]:
    """Edit while the server does not answer: when it does again, and what was typed."""
    os.kill(server.pid, signal.SIGSTOP)
    try:
        _edit(page, value)
        page.tab.wait_for_timeout(1e3 * FREEZE)
    finally:
        os.kill(server.pid, signal.SIGCONT)
    return time.monotonic(), value


def _edit(page: Page, value: int) -> None:
    box = page.row(_BOX).locator("input:visible").first
    box.fill(str(value))
    box.press("Tab")


def _shown(page: Page) -> int:
    """The number that the page's box shows; -1 while there is none."""
    boxes = page.row(_BOX).locator("input:visible")
    return int(boxes.first.input_value() or -1) if boxes.count() else -1


def _remembered(page: Page) -> int:
    """The same in the state that the page keeps."""
    return _kept(page).scene.spline.degree


def _kept(page: Page) -> TabState:
    """The state that the page keeps."""
    return TabState.decode(page.tab.evaluate("sessionStorage.getItem('abi-tab')"), MeshSource())


def _placed(page: Page) -> bool:
    """Check whether the arm, which stands still, and both ends are where what is kept puts them."""
    state = _kept(page)
    page.frames(2)
    wanted = planned(_plan(state.scene), state.time)
    return not differing(page, wanted, max(state.scene.workspace.size))


@functools.lru_cache(1)
def _plan(scene: Scene) -> Plan:
    """Plan of a scene, made once while the page is asked again and again."""
    return abi.plan(scene)


def _within(page: Page, condition: Callable[[], bool]) -> bool:
    """Check whether it comes true in time."""
    try:
        page.until(condition, "", _PATIENCE)
    except AssertionError:
        return False
    return True


def main() -> None:
    """Go through all faults and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--reloads", type=int, default=50)
    parser.add_argument("--freezes", type=int, default=3)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--scene", default="paper", help="a shipped scene without meshes")
    options = parser.parse_args()
    asked = options.kills, options.reloads, options.freezes
    with Interrupt() as interrupt, chromium() as browser:
        found = measure(browser, *asked, options.seed, interrupt, options.scene)
    print(json.dumps(found), flush=True)


if __name__ == "__main__":
    main()
