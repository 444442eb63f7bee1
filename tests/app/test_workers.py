"""Several processes behind one address: all serve, count together, and end together."""

from __future__ import annotations

import os
import signal
import sys
import time
import urllib.error
import urllib.request

import click
import pytest
from websockets.exceptions import InvalidStatus

from app.commands.serve import serve
from benchmarks.tabs import ServerProcess, process_family
from tests.app.fake_tab import FakeTab, until

needs_linux = pytest.mark.skipif(sys.platform != "linux", reason="connections are not shared out")


def _figure(url: str, name: str) -> float:
    with urllib.request.urlopen(f"{url}/metrics", timeout=30) as answer:
        lines = answer.read().decode().splitlines()
    return sum(float(line.split()[-1]) for line in lines if line.startswith(f"{name} "))


def _serving(server: ServerProcess) -> list[int]:
    """The processes that listen, without those that compile or read files."""
    found = []
    for number in process_family(server.number):
        with open(f"/proc/{number}/cmdline", "rb") as file:
            if b"\0serve\0" in file.read():
                found.append(number)
    return found


@needs_linux
@pytest.mark.slow
def test_tabs_of_all_processes_count_together_and_end_together() -> None:
    server = ServerProcess("--workers", "2")
    try:
        until(lambda: len(_serving(server)) == 2)
        (worker,) = set(_serving(server)) - {server.number}
        tabs = [FakeTab(server.url) for _ in range(6)]
        until(lambda: _figure(server.url, "abi_tabs") == 6)

        os.kill(worker, signal.SIGKILL)
        until(lambda: len(_serving(server)) == 2 and worker not in _serving(server))
        for tab in tabs:
            tab.close()
        until(lambda: _figure(server.url, "abi_tabs") == 0)
    finally:
        processes = _serving(server)
        assert server.stop() == 0
    assert not any(os.path.exists(f"/proc/{number}") for number in processes)
    with pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(server.url, timeout=5)


@needs_linux
@pytest.mark.slow
def test_tabs_that_come_with_the_link_find_all_places_wherever_they_land() -> None:
    server = ServerProcess("--workers", "2", "--max-tabs", "4")
    try:
        tabs = [FakeTab(server.url) for _ in range(4)]
        until(lambda: _figure(server.url, "abi_tabs") == 4)
        with pytest.raises(InvalidStatus) as refusal:
            FakeTab(server.url)
        assert refusal.value.response.status_code == 503
        tabs.pop().close()
        until(lambda: _figure(server.url, "abi_tabs") == 3)
        tabs.append(FakeTab(server.url))
        for tab in tabs:
            tab.close()
    finally:
        assert server.stop() == 0


@needs_linux
@pytest.mark.slow
def test_a_worker_ends_with_the_process_that_started_it() -> None:
    server = ServerProcess("--workers", "2")
    until(lambda: len(_serving(server)) == 2)
    (worker,) = set(_serving(server)) - {server.number}
    os.kill(server.number, signal.SIGKILL)
    server.stop()
    end = time.monotonic() + 30
    while os.path.exists(f"/proc/{worker}") and time.monotonic() < end:
        time.sleep(0.05)
    assert not os.path.exists(f"/proc/{worker}")


def test_a_class_is_kept_in_one_process() -> None:
    arguments = ["--workers", "2", "--classroom", "--no-open"]
    with pytest.raises(click.UsageError, match="one process"):
        serve.main(arguments, standalone_mode=False)
