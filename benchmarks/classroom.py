"""A class that follows its teacher: how long after the teacher's hand every student sees it.

    python -m benchmarks.classroom --tabs 30 --moves 20

The teacher's tab leads and moves the obstacle once in a while; the others follow. Each has to show
the curve of the new place. Then the teacher asks, every student answers, and the teacher's tab has
to show the right counts. The server is a process of its own; the tabs share another, on the same
machine, so that they take some of its time: ``tabs_cores``, beside the server's ``cores``. Ends
with exit code 1 where a tab shows another curve or an answer is counted wrong.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import re
import sys
import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.tabs import SETTLE, ServerProcess, expected_curve, open_tabs, serving, warm_up
from benchmarks.web_tab import WebTab

PAUSE = 1.5
"""Seconds between two moves: the teacher speaks, and every tab is at rest."""
_STEPS = 4
"""Messages of a move; the last one counts."""
_PATIENCE = 60.0
_CHOICES = ("left", "right")


async def follow(
    url: str, secret: str, tabs: int, moves: int, settle: float = SETTLE, pause: float = PAUSE
) -> dict[str, Any]:
    """Have a class of so many tabs, the teacher's among them, follow so many moves.

    Args:
        url: of the server.
        secret: what makes a tab the teacher's.
        tabs: number of tabs.
        moves: number of moves.
        settle: seconds before the first one.
        pause: seconds between two.

    Returns:
        ``teacher_ms`` and ``student_ms``, median, 95 % and longest time from the teacher's hand to
        the right curve; ``within_1_s``, share of the students' pictures; ``wrong`` curves; whether
        the ``answers`` are counted right.
    """
    teacher, *students = await open_tabs(url, tabs)
    report = {"state": "", "query": {"teach": secret}, "dark": False}
    await teacher.type("report", json.dumps(report))
    await asyncio.sleep(settle)
    await teacher.type("all follow me", True)
    delays = []
    for move in range(moves):
        await asyncio.sleep(pause)
        delays.append(await _move(teacher, students, move))
    counted = await _ask(teacher, students)
    await asyncio.gather(*(tab.close() for tab in (teacher, *students)))
    own, theirs = (np.array(part) for part in zip(*delays, strict=True))
    return {
        "teacher_ms": _spread(own),
        "student_ms": _spread(theirs),
        "within_1_s": float(np.mean(theirs <= 1.0)),
        "wrong": int(np.sum(~np.isfinite(theirs))),
        "answers": counted,
    }


async def _move(
    teacher: WebTab, students: Sequence[WebTab], move: int
) -> tuple[float, list[float]]:
    """Move the obstacle; after how many seconds the teacher and each student see the curve."""
    place = (3.0 + 0.6 * np.cos(2.4 * move), 3.0 + 0.6 * np.sin(2.4 * move), 3.0)
    tabs = (teacher, *students)
    for tab in tabs:
        tab.curves.clear()
    before = np.array(teacher.position or (3.0, 3.0, 3.0))
    for step in range(1, _STEPS + 1):
        x, y, z = before + (np.array(place) - before) * step / _STEPS
        await teacher.move((float(x), float(y), float(z)))
        released = time.monotonic()
        await asyncio.sleep(0.05)
    expected = await asyncio.to_thread(expected_curve, teacher)
    own, *theirs = await asyncio.gather(*(tab.shows(expected, _PATIENCE) for tab in tabs))
    return own - released, [moment - released for moment in theirs]


async def _ask(teacher: WebTab, students: Sequence[WebTab]) -> bool:
    """Ask; whether the teacher's tab tells how many gave each answer."""
    await teacher.type("question", "Which way?")
    for number, choice in enumerate(_CHOICES, 1):
        await teacher.type(f"answer {number}", choice)
    await teacher.press("Ask all")
    for tab in students:
        await tab.until(lambda tab=tab: _CHOICES[1] in tab.labels, _PATIENCE)  # type: ignore[misc]
    for number, tab in enumerate(students):
        await tab.press(_CHOICES[number % 3 == 0])
    try:
        everybody = f"{len(students)} of {len(students)} have answered"
        await teacher.until(lambda: any(everybody in text for text in teacher.texts))
    except TimeoutError:
        return False
    await teacher.press("Reveal the answers")
    right = sum(number % 3 == 0 for number in range(len(students)))
    told = f"{_CHOICES[0]}: <b>{len(students) - right}</b>", f"{_CHOICES[1]}: <b>{right}</b>"
    try:
        await teacher.until(lambda: any(all(t in text for t in told) for text in teacher.texts))
    except TimeoutError:
        return False
    return True


def _spread(seconds: Any) -> list[float]:
    return [1e3 * float(np.percentile(seconds, share)) for share in (50, 95, 100)]


async def _measure(server: ServerProcess, tabs: int, moves: int) -> dict[str, Any]:
    link = re.search(r"teach=([\w-]+)", server.line())
    assert link is not None, "the server has no class"
    await warm_up(server.url)
    used, begin, own = server.usage()[0], time.monotonic(), time.process_time()
    result = await follow(server.url, link.group(1), tabs, moves)
    elapsed = time.monotonic() - begin
    cores, tabs_cores = (server.usage()[0] - used) / elapsed, (time.process_time() - own) / elapsed
    return {"tabs": tabs, **result, "cores": cores, "tabs_cores": tabs_cores}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tabs", type=int, default=30)
    parser.add_argument("--moves", type=int, default=20)
    options = parser.parse_args()
    with serving("--classroom") as server:
        result = asyncio.run(_measure(server, options.tabs, options.moves))
    print(json.dumps(result), flush=True)
    if result["wrong"] or not result["answers"]:
        sys.exit(1)


if __name__ == "__main__":
    main()
