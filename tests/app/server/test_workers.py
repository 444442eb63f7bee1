"""Several processes behind one address: all serve, count together, and end together."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
import urllib.error
import urllib.request
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import click
import pytest
from websockets.exceptions import InvalidStatus

from app.cli.serve import serve
from app.server.workers import Workers
from benchmarks.spread import serving_processes
from benchmarks.tabs import ServerProcess
from tests.app.fake_tab import FakeTab, until

needs_linux = pytest.mark.skipif(sys.platform != "linux", reason="connections are not shared out")


def _figure(url: str, name: str) -> float:
    with urllib.request.urlopen(f"{url}/metrics", timeout=30) as answer:
        lines = answer.read().decode().splitlines()
    return sum(float(line.split()[-1]) for line in lines if line.startswith(f"{name} "))


def _serving(server: ServerProcess) -> list[int]:
    return serving_processes(server.number)


@needs_linux
@pytest.mark.slow
def test_tabs_are_shared_out_have_all_places_outlive_a_worker_and_end_together() -> None:
    """One server for all of it: each takes as long to start as the rest lasts."""
    server = ServerProcess("--workers", "2", "--max-tabs", "5")
    processes: list[int] = []
    try:
        until(lambda: len(_serving(server)) == 2)
        tabs = _each_comes_to_the_process_that_has_the_fewest(server)
        _find_all_places_wherever_they_land(server, tabs)
        (worker,) = set(_serving(server)) - {server.number}
        os.kill(worker, signal.SIGKILL)
        until(lambda: len(set(_serving(server)) - {worker}) == 2)
        for tab in tabs:
            tab.close()
        until(lambda: _figure(server.url, "abi_tabs") == 0)
    finally:
        processes = _serving(server)
        assert server.stop() == 0
    assert len(processes) == 2
    assert not any(os.path.exists(f"/proc/{number}") for number in processes)
    with pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(server.url, timeout=5)


def _each_comes_to_the_process_that_has_the_fewest(server: ServerProcess) -> list[FakeTab]:
    """Open five tabs at once, close three, open two: four."""
    with ThreadPoolExecutor(5) as pool:
        tabs = list(pool.map(FakeTab, [server.url] * 5))
    until(lambda: _figure(server.url, "abi_tabs") == 5)
    until(lambda: sorted(server.spread()) == [2, 3])
    for tab in tabs[:3]:
        tab.close()
    until(lambda: _figure(server.url, "abi_tabs") == 2)
    until(lambda: sum(server.spread()) == 2)
    others = [FakeTab(server.url) for _ in range(2)]
    until(lambda: server.spread() == [2, 2])
    return [*tabs[3:], *others]


def _find_all_places_wherever_they_land(server: ServerProcess, tabs: list[FakeTab]) -> None:
    """Fill the fifth place, find none for another, and again one where a tab has left."""
    tabs.append(FakeTab(server.url))
    until(lambda: _figure(server.url, "abi_tabs") == 5)
    with pytest.raises(InvalidStatus) as refusal:
        FakeTab(server.url)
    assert refusal.value.response.status_code == 503
    tabs.pop().close()
    until(lambda: _figure(server.url, "abi_tabs") == 4)
    tabs.append(FakeTab(server.url))


@needs_linux
def test_a_worker_that_cannot_start_is_left_alone_for_longer_and_longer(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    begun: list[float] = []
    start = subprocess.Popen

    def fail(command: list[str], **options: Any) -> subprocess.Popen[bytes]:
        begun.append(time.monotonic())
        return start([sys.executable, "-c", "raise SystemExit(3)"], **options)

    monkeypatch.setattr("app.server.workers.subprocess.Popen", fail)
    workers = Workers(1)
    try:
        workers.start([], None, lambda channel: channel.close())
        until(lambda: len(begun) == 3)
    finally:
        workers.stop()
    # what is started afterwards is not sent to a folder that is gone
    assert "PROMETHEUS_MULTIPROC_DIR" not in os.environ
    first, second, third = begun
    assert second - first >= 1
    assert third - second >= 3


@needs_linux
@pytest.mark.slow
def test_memory_is_counted_and_a_worker_ends_with_the_process_that_started_it() -> None:
    server = ServerProcess("--workers", "2")
    until(lambda: len(_serving(server)) == 2)
    until(lambda: _counts_the_memory_of_all(server))
    (worker,) = set(_serving(server)) - {server.number}
    os.kill(server.number, signal.SIGKILL)
    server.stop()
    end = time.monotonic() + 30
    while os.path.exists(f"/proc/{worker}") and time.monotonic() < end:
        time.sleep(0.05)
    assert not os.path.exists(f"/proc/{worker}")


def _counts_the_memory_of_all(server: ServerProcess) -> bool:
    pages = [int(Path(f"/proc/{n}/statm").read_text().split()[1]) for n in _serving(server)]
    memory = sum(pages) * os.sysconf("SC_PAGE_SIZE")
    return abs(_figure(server.url, "abi_memory_bytes") / memory - 1) < 0.1


def test_a_class_is_kept_in_one_process() -> None:
    arguments = ["--workers", "2", "--classroom", "--no-open"]
    with pytest.raises(click.UsageError, match="one process"):
        serve.main(arguments, standalone_mode=False)
