"""Cost of one tab: memory in the server, bytes for each plan of a drag.

python -m benchmarks.tab --nodes 200 20000 200000
"""

from __future__ import annotations

import argparse
import gc
import json
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

import abi
from app.server.server import Server, start
from app.state.appearance import PLAIN
from benchmarks.browser import scene_with
from tests.app.fake_tab import FakeTab

TABS = 4
STEPS = 40
_PATIENCE = 60.0
_ARRIVAL = 1.0  # seconds in which all arrives that was sent
_PLAYBACK = 3.0  # seconds of playback whose bytes are counted
_PAUSE = threading.Event()


def measure(nodes: int) -> dict[str, Any]:
    """Open a few tabs on a mesh of about ``nodes`` nodes, and drag the cube in one.

    Returns:
        ``nodes``; ``megabytes_per_tab``; ``bytes_to_begin``, until it rests; ``bytes_per_second``
        of playback; ``bytes_per_plan`` and the ``largest_plan`` [bytes] of the drag.
    """
    scene = scene_with(nodes)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scene.json"
        scene.save(file)
        server = start(port=0, scene=str(file), look=PLAIN)
    tabs: list[FakeTab] = []
    try:
        _open_tab(server, tabs)
        before = _megabytes()
        for _ in range(TABS):
            _open_tab(server, tabs)
        each = (_megabytes() - before) / TABS
        session = server.sessions[max(server.sessions)]
        session.playback.playing = False
        _PAUSE.wait(_ARRIVAL)
        first_bytes = tabs[-1].received
        session.playback.playing = True
        session.wake(SimpleNamespace(client=session.client))
        _PAUSE.wait(_PLAYBACK)
        playing = (tabs[-1].received - first_bytes) / _PLAYBACK
        session.playback.playing = False
        _until(lambda: _is_quiet(tabs[-1]))
        plan_bytes = [_drag(tabs[-1], session, step) for step in range(STEPS)]
    finally:
        for tab in tabs:
            tab.close()
        server.stop()
    return {
        "nodes": scene.mesh.node_count(scene.workspace),
        "megabytes_per_tab": each,
        "bytes_to_begin": first_bytes,
        "bytes_per_second": playing,
        "bytes_per_plan": float(np.median(plan_bytes)),
        "largest_plan": max(plan_bytes),
    }


def _drag(tab: FakeTab, session: Any, step: int) -> int:
    """Drag the cube one step; the bytes that this sends."""
    received, plans = tab.received, session.plans
    tab.drag(session.panels.obstacles.gizmos[0], [3.0, 3.0, 3.0 - 0.02 * (step + 1)])
    _until(lambda: session.plans > plans)
    _until(lambda: _is_quiet(tab))
    return tab.received - received


def _is_quiet(tab: FakeTab) -> bool:
    """Check if nothing arrived for a moment; less than a rest, after which it is planned anew."""
    before = tab.received
    _PAUSE.wait(0.05)
    return tab.received == before


def _megabytes() -> float:
    """Resident memory of the process, on Linux."""
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * 4096 / 1e6


def _open_tab(server: Server, tabs: list[FakeTab]) -> None:
    """Open one more tab, and wait until all rest."""
    tabs.append(FakeTab(server.url))
    _until(lambda: len(server.sessions) == len(tabs))
    _until(lambda: all(session.resting for session in server.sessions.values()))


def _until(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + _PATIENCE
    while not condition():
        assert time.monotonic() < end, "did not happen in time"
        _PAUSE.wait(0.005)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--nodes", type=int, nargs="+", default=[200, 20_000, 200_000])
    abi.compile()  # what it takes is no tab's
    for nodes in parser.parse_args().nodes:
        print(json.dumps(measure(nodes)), flush=True)


if __name__ == "__main__":
    main()
