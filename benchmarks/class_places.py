"""Answers in the scene: how long after a student's click the teacher sees its ball.

    python -m benchmarks.class_places --tabs 30 --rounds 5

A teacher asks for a place and reveals the answers; then every student clicks a node, in each round
another one, all within ``--within`` seconds, 0 for all at once. Counted is the time from the click
until the message with the ball of that node is at the teacher's page. At the end the server is
killed, started again, and asked for the answers. The server is a process of its own; the tabs are
websocket clients in another, which send and read what pages do but draw nothing. Ends with exit
code 1 where an answer is not seen, or lost.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import os
import random
import secrets
import signal
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from abi.arrays import FloatArray
from abi.planner.planner import Planner
from abi.scene.scene import load_scene
from app.theatre.theatre import node_at
from benchmarks.tabs import SCENE, SETTLE, ServerProcess, warm_up
from benchmarks.web_tab import WebTab
from tests.ports import free_port

WANTED = 0.5
"""Seconds within which 95 % of the answers have to be seen."""
_PATIENCE = 30.0
_DIRECTION = np.array([0.2, 0.3, -0.93]) / np.linalg.norm([0.2, 0.3, -0.93])
_AWAY = 30.0
"""Distance from which is clicked, [unit]."""
_QUESTION = "Where will the path pass?"


async def answer_places(
    url: str, secret: str, students: int, rounds: int, within: float, settle: float = SETTLE
) -> FloatArray:
    """Have so many students answer so often.

    Args:
        url: of the server.
        secret: what makes a tab the teacher's.
        students: number of tabs beside the teacher's.
        rounds: of answers, each another node.
        within: seconds in which the clicks of a round happen.
        settle: seconds before the first one.

    Returns:
        Seconds from each click to its ball at the teacher's, infinite for one that did not come.
    """
    teacher, *tabs = await _enter(url, secret, students)
    await asyncio.sleep(settle)
    await teacher.type("question", _QUESTION)
    await teacher.press("Ask for a place")
    for tab in tabs:
        await tab.until(lambda tab=tab: any(_QUESTION in t for t in tab.texts), _PATIENCE)  # type: ignore[misc]
    await teacher.press("Reveal the answers")
    nodes = np.random.default_rng(0).permutation(await asyncio.to_thread(_nodes))
    delays: list[float] = []
    for number in range(rounds):
        places = np.roll(nodes, -number * students, axis=0)[:students]
        delays += await asyncio.gather(
            *(_answer(teacher, *pair, within) for pair in zip(tabs, places, strict=True))
        )
    await asyncio.gather(*(tab.close() for tab in (teacher, *tabs)))
    return np.array(delays)


async def _enter(url: str, secret: str, students: int) -> list[WebTab]:
    """The tabs of a class in which each has its picture, the teacher's first."""
    tabs = [WebTab(url) for _ in range(students + 1)]
    tabs[0].query = {"teach": secret}
    for number, tab in enumerate(tabs):
        tab.student = f"browser-{number}"
    await asyncio.gather(*(tab.connect() for tab in tabs))
    for tab in tabs:
        await tab.until(lambda tab=tab: tab.drawn)  # type: ignore[misc]
    return tabs


async def _answer(teacher: WebTab, tab: WebTab, place: FloatArray, within: float) -> float:
    """Click a node after a while; seconds until the teacher has its ball."""
    await asyncio.sleep(random.uniform(0.0, within))
    clicked = time.monotonic()
    await tab.click(place - _AWAY * _DIRECTION, _DIRECTION)
    try:
        await teacher.until(lambda: _came(teacher, place) >= clicked, _PATIENCE)
    except TimeoutError:
        return np.inf
    return _came(teacher, place) - clicked


def _came(teacher: WebTab, place: FloatArray) -> float:
    """When the ball of a node came last; before all others where it did not."""
    near = [when for at, when in teacher.balls.items() if np.allclose(at, place, atol=1e-6)]
    return max(near, default=-np.inf)


def _nodes() -> FloatArray:
    """Places (n, 3) of the nodes that a click from above means, [unit], world."""
    graph = Planner()(load_scene(SCENE)).graph
    assert graph is not None
    nodes = np.flatnonzero(np.diff(graph.indptr)).astype(np.int32)
    rays = graph.points - _AWAY * _DIRECTION
    meant = [n for n in nodes if node_at(graph.points, nodes, rays[n], _DIRECTION) == n]
    return graph.points[meant]


async def _kept(url: str, secret: str, wanted: int) -> int:
    """Number of balls that a teacher sees who comes back, once it is the one that is wanted."""
    (teacher,) = await _enter(url, secret, 0)
    with contextlib.suppress(TimeoutError):
        await teacher.until(lambda: len(teacher.balls) >= wanted, _PATIENCE)
    await teacher.close()
    return len(teacher.balls)


def measure(students: int, rounds: int, within: Sequence[float]) -> list[dict[str, Any]]:
    """Measure each of the lengths of a round; the server is killed after each.

    Returns:
        For each: ``answers``; ``ms``, median, 95 % and longest time; ``within_wanted``, the share
        that was seen in half a second; ``lost``, answers that were not seen; ``kept``, of the
        students' last answers those that a teacher sees after the server was killed.
    """
    rows = []
    for length in within:
        secret, port = secrets.token_hex(), str(free_port())
        with tempfile.TemporaryDirectory() as folder:
            options = ["--classroom", "--teach", secret, "--port", port]
            options += ["--results", str(Path(folder) / "results.csv")]
            server = ServerProcess(*options)
            asyncio.run(warm_up(server.url))
            delays = asyncio.run(answer_places(server.url, secret, students, rounds, length))
            os.kill(server.number, signal.SIGKILL)
            server.stop()
            again = ServerProcess(*options)
            kept = asyncio.run(_kept(again.url, secret, students))
            again.stop()
        rows.append(
            {
                "tabs": students,
                "within_s": length,
                "answers": len(delays),
                "ms": [round(1e3 * float(np.percentile(delays, share))) for share in (50, 95, 100)],
                "within_wanted": round(float(np.mean(delays <= WANTED)), 3),
                "lost": int(np.sum(~np.isfinite(delays))),
                "kept": kept,
            }
        )
    return rows


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tabs", type=int, default=30)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--within", type=float, nargs="+", default=[10.0, 0.0])
    options = parser.parse_args()
    rows = measure(options.tabs, options.rounds, options.within)
    print("\n".join(map(json.dumps, rows)), flush=True)
    if any(row["lost"] or row["kept"] != options.tabs for row in rows):
        sys.exit(1)


if __name__ == "__main__":
    main()
