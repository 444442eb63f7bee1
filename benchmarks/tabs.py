"""Many tabs at one server: what each sees of its own drag, and what they cost together.

python -m benchmarks.tabs --tabs 1 5 15 30 --seconds 10
python -m benchmarks.tabs --tabs 1 --play --scene kitchen-ur5e
python -m benchmarks.tabs --tabs 30 --at-once

Every tab plays the motion, drags an obstacle of its own around a circle, 20 messages a second as
viser's page sends them, and counts the curves that come back. The server is a process of its own;
the tabs share another, on the same machine, so that they take some of its time.
With ``--at-once`` the server has only just begun, and each tab drags as soon as it has its picture.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import os
import re
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from abi.arrays import FloatArray
from abi.planner.planner import Planner
from abi.scene.scene import load_scene
from app.drawing.lines import segments
from app.layers.plan_lines import SAMPLES
from benchmarks.interrupt import Interrupt
from benchmarks.spread import process_family, spread
from benchmarks.web_tab import WebTab, is_same_curve

SCENE = "two-boxes"
"""Its path changes with every move."""
COUNTS = (1, 5, 15, 30)
_REST = 3.0
"""Seconds after the drag in which the last curve has to come."""
SETTLE = 5.0
"""Seconds before the drag, in which all that a tab shows at first is sent."""
_WARM_UP, _FIRST_TABS = 6.0, 4
_SLICE = 1.0
"""Seconds after which an early end is noticed."""
_TICKS = os.sysconf("SC_CLK_TCK") if hasattr(os, "sysconf") else 100


class ServerProcess:
    """``abi serve`` as a process of its own.

    Attributes:
        url: of the page.
        number: of the process.
    """

    def __init__(self, *arguments: str, scene: str = SCENE) -> None:
        command = [sys.executable, "-P", "-m", "app", "serve", scene, "--port", "0", "--no-open"]
        options = ["--no-demo", "--log-level", "warning"]
        self._process = subprocess.Popen(
            [*command, *options, *arguments],
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,  # Ctrl+C is for the one who measures
        )
        link = re.search(r"http://\S+", self.line())
        assert link is not None, "the server did not start"
        self.url, self.number = link.group(), self._process.pid

    def line(self) -> str:
        """The next line that it prints."""
        assert self._process.stdout is not None
        return self._process.stdout.readline()

    def stop(self) -> int:
        """End it as a person would; its exit code."""
        assert self._process.stdout is not None
        with self._process.stdout:
            self._process.terminate()
            return self._process.wait(60)

    def spread(self) -> list[int]:
        """Number of tabs of each of its processes, on Linux."""
        return spread(self.number, self.url)

    def usage(self) -> tuple[float, float]:
        """Processor time [s] and resident memory [MB] of all its processes, on Linux."""
        seconds = pages = 0
        for number in process_family(self._process.pid):
            with contextlib.suppress(OSError):
                fields = Path(f"/proc/{number}/stat").read_text("ascii").rpartition(")")[2].split()
                seconds += int(fields[11]) + int(fields[12])
                pages += int(Path(f"/proc/{number}/statm").read_text("ascii").split()[1])
        return seconds / _TICKS, pages * 4096 / 1e6


@contextlib.contextmanager
def serving(*arguments: str, scene: str = SCENE) -> Iterator[ServerProcess]:
    """A server for as long as the block lasts."""
    server = ServerProcess(*arguments, scene=scene)
    try:
        yield server
    finally:
        server.stop()


async def drag(
    server: ServerProcess, tabs: int, seconds: float, settle: float = SETTLE
) -> dict[str, Any]:
    """Drag in all tabs at once.

    Returns:
        ``tabs``; ``opened_s``, until all have a picture; of the drag ``updates_per_s`` of the
        median tab and ``least`` of the slowest, ``gap_ms``, which 95 % of the gaps between two
        updates stay under, and ``longest_ms``; ``last_ms``, how long after the hand the last curve
        came, in the latest tab; ``cores`` and ``megabytes`` of the server, and these at its
        ``begin_megabytes``; ``spread``, tabs of each process;
        ``stale``, tabs whose last curve is not that of the last position;
        ``tabs_cores`` of the process that has the tabs.
    """
    await warm_up(server.url)
    begin = time.monotonic()
    _, first = server.usage()
    opened = await open_tabs(server.url, tabs)
    ready = time.monotonic()
    await asyncio.sleep(settle)
    shares = server.spread()
    before, begin_memory = server.usage()
    started, own = time.monotonic(), time.process_time()
    released = await asyncio.gather(*(tab.drag(seconds, phase) for phase, tab in enumerate(opened)))
    after, memory = server.usage()
    elapsed, own = time.monotonic() - started, time.process_time() - own
    await asyncio.sleep(_REST)
    expected = await asyncio.gather(*(asyncio.to_thread(expected_curve, tab) for tab in opened))
    runs = [
        observe(tab, started, last, curve)
        for tab, last, curve in zip(opened, released, expected, strict=True)
    ]
    await asyncio.gather(*(tab.close() for tab in opened))
    gaps = np.concatenate([run["gaps"] for run in runs])
    return {
        "tabs": tabs,
        "opened_s": ready - begin,
        "updates_per_s": float(np.median([run["rate"] for run in runs])),
        "least": min(run["rate"] for run in runs),
        "gap_ms": 1e3 * float(np.percentile(gaps, 95)),
        "worst_tab_ms": 1e3 * max(float(np.percentile(run["gaps"], 95)) for run in runs),
        "longest_ms": 1e3 * float(gaps.max()),
        "last_ms": 1e3 * max(run["late"] for run in runs),
        "cores": (after - before) / elapsed,
        "tabs_cores": own / elapsed,
        "ms_per_update": 1e3 * (after - before) / max(sum(run["count"] for run in runs), 1),
        "begin_megabytes": first,
        "open_megabytes": begin_memory,
        "megabytes": memory,
        "spread": shares,
        "stale": sum(not run["right"] for run in runs),
    }


async def drag_at_once(server: ServerProcess, tabs: int, seconds: float) -> dict[str, Any]:
    """Open all tabs at a server that has just begun; each drags as soon as it has its picture.

    Returns:
        ``tabs``; of the tabs' pictures the last at ``drawn_s`` after all were opened; of the first
        update after a tab's first move ``answered_ms``, how long the median tab and
        ``worst_answered_ms``, how long the last waits; ``updates_per_s`` of the median tab.
    """
    begin = time.monotonic()
    opened = await asyncio.gather(*(WebTab.open(server.url) for _ in range(tabs)))
    drags = (_drag_when_drawn(tab, seconds, phase) for phase, tab in enumerate(opened))
    moved = np.array(await asyncio.gather(*drags))
    await asyncio.sleep(_REST)
    updates = [
        np.array([moment for moment, _ in tab.curves if moment > first])
        for first, tab in zip(moved, opened, strict=True)
    ]
    answered = [
        float(found[0] - first) if len(found) else np.inf
        for found, first in zip(updates, moved, strict=True)
    ]
    await asyncio.gather(*(tab.close() for tab in opened))
    return {
        "tabs": tabs,
        "drawn_s": float(moved.max()) - begin,
        "answered_ms": 1e3 * float(np.median(answered)),
        "worst_answered_ms": 1e3 * max(answered),
        "updates_per_s": float(np.median([len(found) for found in updates])) / seconds,
    }


async def _drag_when_drawn(tab: WebTab, seconds: float, phase: float) -> float:
    """Drag once the tab has its picture; time of the first move, [s] of the monotonic clock."""
    await tab.until(_has_picture(tab))
    first = time.monotonic()
    await tab.drag(seconds, phase)
    return first


async def play(
    server: ServerProcess,
    tabs: int,
    seconds: float,
    settle: float = SETTLE,
    enough: Callable[[], bool] = lambda: False,
) -> dict[str, Any]:
    """Only watch: all tabs play, then all stand; ``cores`` of the server meanwhile.

    Each lasts for ``seconds``, or until there is ``enough()``. What does not count is the server's
    start, after which all tabs plan again with compiled code, and the first ``settle`` [s] of the
    tabs.
    """
    await warm_up(server.url)
    opened = await open_tabs(server.url, tabs)
    await asyncio.sleep(settle)
    result: dict[str, Any] = {"tabs": tabs}
    for name in ("playing", "standing"):
        before, received = server.usage()[0], sum(tab.received for tab in opened)
        begin, lasted = time.monotonic(), 0.0
        while lasted < seconds and not enough():
            await asyncio.sleep(min(_SLICE, seconds - lasted))
            lasted = time.monotonic() - begin
        if lasted > 0:
            result[f"{name}_s"] = lasted
            result[f"{name}_cores"] = (server.usage()[0] - before) / lasted
            bytes_sent = sum(tab.received for tab in opened) - received
            result[f"{name}_bytes_per_s"] = bytes_sent / lasted / tabs
        await asyncio.gather(*(tab.press("Play or pause") for tab in opened))
    await asyncio.gather(*(tab.close() for tab in opened))
    return result


async def warm_up(url: str) -> None:
    """Have a server that has just begun load its kernels, as it does with the first tabs.

    Twice, as other processes of the same address begin after the first.
    """
    for _ in range(2):
        opened = await open_tabs(url, _FIRST_TABS)
        await asyncio.sleep(_WARM_UP)
        await asyncio.gather(*(tab.close() for tab in opened))


async def open_tabs(url: str, tabs: int) -> list[WebTab]:
    """Open all tabs at once, and wait for their pictures."""
    opened = await asyncio.gather(*(WebTab.open(url) for _ in range(tabs)))
    await asyncio.gather(*(tab.until(_has_picture(tab)) for tab in opened))
    return list(opened)


def _has_picture(tab: WebTab) -> Any:
    return lambda: tab.drawn


def observe(tab: WebTab, begin: float, released: float, expected: FloatArray) -> dict[str, Any]:
    """One tab's drag: rate, gaps [s], how late the last curve came [s], and whether it is right."""
    during = [moment for moment, _ in tab.curves if begin <= moment <= released]
    gaps = np.diff([begin, *during, released])
    same = [is_same_curve(points, expected) for _, points in tab.curves]
    right = bool(same) and same[-1]
    # the first of the last run of curves that are right
    first = len(same) - (same[::-1].index(False) if False in same else len(same))
    late = tab.curves[first][0] - released if right else np.inf
    return {
        "count": len(during),
        "rate": len(during) / (released - begin),
        "gaps": gaps,
        "late": late,
        "right": right,
    }


_planning = threading.Lock()


def expected_curve(tab: WebTab) -> FloatArray:
    """The curve that a tab is to end with, as the page gets it."""
    scene = load_scene(SCENE)
    moved = scene.obstacles[0].model_dump(mode="json")
    moved |= {"position": list(tab.position or ()), "wxyz": [1.0, 0.0, 0.0, 0.0]}
    with _planning:
        plan = Planner()(scene.replace(obstacles=[moved, *scene.obstacles[1:]]))
    assert plan.bspline is not None
    curve = plan.bspline.curve
    return segments(curve(np.linspace(*curve.interval, SAMPLES))).ravel().astype(float)


def measure(counts: Sequence[int], seconds: float = 10.0, *arguments: str) -> list[dict[str, Any]]:
    """Drag with each number of tabs, each time in a new server."""
    rows = []
    for count in counts:
        with serving(*arguments) as server:
            rows.append(asyncio.run(drag(server, count, seconds)))
    return rows


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tabs", type=int, nargs="+", default=list(COUNTS))
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--settle", type=float, default=SETTLE)
    parser.add_argument("--play", action="store_true", help="only play and stand")
    parser.add_argument("--at-once", action="store_true", help="drag in a server just begun")
    parser.add_argument("--scene", default=SCENE, help="what they play, with --play")
    options, arguments = parser.parse_known_args()
    if options.scene != SCENE and not options.play:
        parser.error("--scene is for --play: the drag is that of an obstacle of two-boxes")
    for count in options.tabs:
        with serving(*arguments, scene=options.scene) as server:
            if options.play:
                with Interrupt() as interrupt:
                    result = asyncio.run(
                        play(
                            *(server, count, options.seconds, options.settle),
                            enough=lambda interrupt=interrupt: interrupt.asked,  # type: ignore[misc]
                        )
                    )
            elif options.at_once:
                result = asyncio.run(drag_at_once(server, count, options.seconds))
            else:
                result = asyncio.run(drag(server, count, options.seconds, options.settle))
        print(json.dumps(result), flush=True)


if __name__ == "__main__":
    main()
