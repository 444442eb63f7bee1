"""Many tabs for minutes: all drag and play, one reads slowly, one hardly ever, one not at all.

    python -m benchmarks.soak --tabs 30 --minutes 10 --workers 2

Each tab drags for a while, lets go, presses "Play or pause", and has to show the curve of the last
position. The slow tab and one that is frozen for half a minute at a time drag, too; what they have
not read must neither grow in the server nor keep the others waiting, and once they read again they
must show the last position. Another is shut like a laptop, without a hand, until the end; the
server gives such a one up after two minutes or so. It then connects again by itself, as the page
does, and must show what it showed.
Every half minute it prints a line with the figures so far, and Ctrl+C ends it with those, as the
last line. Ends with exit code 1 where a tab shows another curve in the end or lost its connection,
or the server had a fault.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import sys
import time
import urllib.request
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from app.state.tab_state import TabState
from benchmarks.interrupt import Interrupt
from benchmarks.tabs import (
    SETTLE,
    ServerProcess,
    expected_curve,
    observe,
    open_tabs,
    serving,
    warm_up,
)
from benchmarks.web_tab import WebTab

DRAG = 20.0
"""Seconds of one drag."""
REST = 3.0
"""Seconds after it in which the last curve has to come."""
SLOW_PAUSE, _SLOW_READ = 1.0, 0.1
"""Seconds between two looks of the slow tab at what it was sent, and of such a look."""
FROZEN, _THAWED = 30.0, 2.0
"""The same of the frozen one: a page that a hand still moves is not frozen for much longer."""
_LAST_DRAG = 1.0
"""Seconds of the drag of the tab that is shut then."""
PERIOD = 30.0
"""Seconds between two accounts of the figures so far."""
_LOOK = 0.5
"""Seconds after which an early end is noticed."""
OTHERS = 3
"""Tabs besides those that are tested."""
_PATIENCE = 60.0
"""Seconds in which a tab that reads again catches up."""


Watch = Callable[[str, dict[str, Any]], object]
"""Told a moment, ``open``, ``running`` or ``end``, and the figures so far."""


class Worker:
    """A tab that drags and plays, with what it saw.

    Attributes:
        tab: the tab.
        drags: of each drag, what :func:`benchmarks.tabs.observe` tells.
    """

    def __init__(self, tab: WebTab, phase: float) -> None:
        self.tab = tab
        self.drags: list[dict[str, Any]] = []
        self._phase = phase

    async def work(self, end: float, drag: float = DRAG, rest: float = REST) -> None:
        """Drag for ``drag`` [s], let go for ``rest`` [s], and so on until ``end`` [s]."""
        while time.monotonic() < end:
            self.tab.curves.clear()
            begin = time.monotonic()
            released = await self.tab.drag(min(drag, max(end - begin, 1.0)), self._phase)
            await asyncio.sleep(rest)
            expected = await asyncio.to_thread(expected_curve, self.tab)
            self.drags.append(observe(self.tab, begin, released, expected))
            await self.tab.press("Play or pause")


async def soak(
    url: str,
    tabs: int,
    seconds: float,
    hand: tuple[float, float] = (DRAG, REST),
    settle: float = SETTLE,
    watch: Watch = lambda moment, figures: None,
    enough: Callable[[], bool] = lambda: False,
) -> dict[str, Any]:
    """Drag and play in ``tabs`` tabs for so long, besides a slow, a frozen and a shut one.

    Args:
        url: of the server.
        tabs: number of tabs that are tested.
        seconds: in which they drag.
        hand: seconds of one drag, and those after it.
        settle: seconds before the first one.
        watch: told the figures as they come.
        enough: whether to end early.

    Returns:
        What :func:`summary` tells; ``stale_slow_or_frozen``, how many of the slow, the frozen and
        the shut tab show another curve once they read again; ``given_up``, whether the server had
        cut the shut one off; ``broken``, other tabs that were.
    """
    opened = await open_tabs(url, tabs + OTHERS)
    await asyncio.sleep(settle)
    *tested, slow, frozen, sleeper = opened
    await shut(sleeper, tabs + 2)
    end = time.monotonic() + seconds
    workers = [Worker(tab, phase) for phase, tab in enumerate(tested)]
    pauses = (slow, SLOW_PAUSE, _SLOW_READ), (frozen, FROZEN, _THAWED)
    dozing = [asyncio.create_task(_doze(*pause)) for pause in pauses]
    watch("open", {})
    tasks = [
        asyncio.create_task(work)
        for work in (
            *(worker.work(end, *hand) for worker in workers),
            slow.drag(seconds, tabs),
            frozen.drag(seconds, tabs + 1),
        )
    ]
    told = time.monotonic()
    while (await asyncio.wait(tasks, timeout=_LOOK))[1] and not enough():
        if time.monotonic() - told >= PERIOD:
            told = time.monotonic()
            watch("running", summary([worker.drags for worker in workers]))
    broken = await _ended(tasks)
    await _ended(dozing)
    sleeper.freeze(False)
    if given_up := not await sleeper.answers():
        await sleeper.connect()
    late = sum([not await catches_up(tab) for tab in (slow, frozen, sleeper)])
    result = summary([worker.drags for worker in workers])
    result |= {"stale_slow_or_frozen": late, "given_up": given_up, "broken": broken}
    watch("end", result)
    await asyncio.gather(*(tab.close() for tab in opened))
    return result


async def _ended(tasks: Sequence[asyncio.Task[Any]]) -> int:
    """End all that is not done; how many had failed."""
    for task in tasks:
        task.cancel()
    results = await asyncio.gather(*tasks, return_exceptions=True)
    return sum(isinstance(result, Exception) for result in results)


async def _doze(tab: WebTab, frozen: float, thawed: float) -> None:
    """Have the tab read now and then only; both in [s]."""
    while True:
        tab.freeze(True)
        await asyncio.sleep(frozen)
        tab.freeze(False)
        await asyncio.sleep(thawed)


async def shut(tab: WebTab, phase: float) -> None:
    """Drag in a tab until it shows and remembers another scene, and have it read no more."""
    await tab.drag(_LAST_DRAG, phase)
    await catches_up(tab)
    await tab.until(lambda: _remembers(tab), _PATIENCE)
    tab.freeze(True)


def _remembers(tab: WebTab) -> bool:
    """Check whether what the tab remembers has the obstacle where it was dragged to last."""
    if not tab.remembered:
        return False
    scene = TabState.decode(tab.remembered, MeshSource()).scene
    return scene.obstacles[0].position == tab.position


async def catches_up(tab: WebTab) -> bool:
    """Check whether a tab that reads again comes to show the last position."""
    tab.freeze(False)
    expected = await asyncio.to_thread(expected_curve, tab)
    return bool(np.isfinite(await tab.shows(expected, _PATIENCE)))


def summary(tabs: Sequence[Sequence[dict[str, Any]]]) -> dict[str, Any]:
    """Figures of the drags of all tabs.

    Returns:
        ``updates_per_s`` of the median tab, ``slowest`` of the slowest, and ``fairness``, their
        ratio; ``gap_ms`` between two updates, 50 % and 95 % of which stay under, and the longest;
        ``waits``, how many times as long as in the median tab that is, for 95 %, in the worst;
        ``last_ms``, how long after the hand the last curve came, 95 % and the longest; ``updates``
        of all; ``drags``, and ``stale``, those that ended with another curve. Without a drag only
        the last two.
    """
    tabs = [drags for drags in tabs if drags]
    drags = [drag for drags in tabs for drag in drags]
    if not drags:
        return {"drags": 0, "stale": 0}
    rates = [float(np.mean([drag["rate"] for drag in drags])) for drags in tabs]
    waits = [np.percentile(np.concatenate([drag["gaps"] for drag in drags]), 95) for drags in tabs]
    gaps = 1e3 * np.concatenate([drag["gaps"] for drag in drags])
    lags = 1e3 * np.array([drag["late"] for drag in drags])
    return {
        "updates_per_s": float(np.median(rates)),
        "slowest": min(rates),
        "fairness": min(rates) / float(np.median(rates)),
        "gap_ms": [float(np.percentile(gaps, share)) for share in (50, 95, 100)],
        "waits": float(max(waits) / np.median(waits)),
        "last_ms": [float(np.percentile(lags, 95, method="nearest")), float(lags.max())],
        "updates": sum(len(drag["gaps"]) - 1 for drag in drags),
        "drags": len(drags),
        "stale": sum(not drag["right"] for drag in drags),
    }


def faults(url: str) -> int:
    """Number of faults that the server has counted."""
    with urllib.request.urlopen(f"{url}/metrics", timeout=30) as answer:
        lines = answer.read().decode().splitlines()
    return int(
        sum(float(line.split()[-1]) for line in lines if line.startswith("abi_faults_total "))
    )


class _Account:
    """Use of the server, printed with the figures so far.

    Attributes:
        figures: processor cores of the server, and of the process that has the tabs, from the first
            account to the last; milliseconds of the server's processor for an update, at the end;
            megabytes before the tabs, with all open, at the end, and once they are closed; faults.
    """

    def __init__(self, server: ServerProcess) -> None:
        self._server = server
        self._begin, self._used = time.monotonic(), server.usage()[0]
        self._own = time.process_time()
        self.figures: dict[str, Any] = {"cores": 0.0, "megabytes": {"before": server.usage()[1]}}

    def tell(self, moment: str, figures: dict[str, Any]) -> None:
        """Note a moment, and print the figures unless the last line is still to come."""
        used, memory = self._server.usage()
        self.figures["megabytes"][moment] = memory
        if moment == "open":
            self._begin, self._used = time.monotonic(), used
            self._own = time.process_time()
            self.figures["spread"] = self._server.spread()
        elif moment != "closed":
            seconds = time.monotonic() - self._begin
            self.figures |= {"cores": (used - self._used) / seconds, "seconds": seconds}
            self.figures["tabs_cores"] = (time.process_time() - self._own) / seconds
            self.figures["faults"] = faults(self._server.url)
        if moment == "end" and figures.get("updates"):
            self.figures["ms_per_update"] = 1e3 * (used - self._used) / figures["updates"]
        if moment == "running":
            print(json.dumps({"so_far": True, **figures, **self.figures}), flush=True)


async def _measure(
    server: ServerProcess, tabs: int, seconds: float, interrupt: Interrupt
) -> dict[str, Any]:
    await warm_up(server.url)
    account = _Account(server)
    result = await soak(
        server.url, tabs, seconds, watch=account.tell, enough=lambda: interrupt.asked
    )
    # those that are closed give their memory back
    account.tell("closed", {})
    return {"tabs": tabs, "asked_seconds": seconds, **result, **account.figures}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tabs", type=int, default=30)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--workers", type=int, default=1)
    options, arguments = parser.parse_known_args()
    room = str(options.tabs + OTHERS)
    settings = ("--workers", str(options.workers), "--max-tabs", room, *arguments)
    with Interrupt() as interrupt, serving(*settings) as server:
        result = asyncio.run(_measure(server, options.tabs, 60 * options.minutes, interrupt))
    print(json.dumps({"workers": options.workers, **result}), flush=True)
    bad = ("stale", "stale_slow_or_frozen", "broken", "faults")
    if any(result[name] for name in bad):
        sys.exit(1)


if __name__ == "__main__":
    main()
