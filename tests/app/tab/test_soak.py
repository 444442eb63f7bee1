"""Tabs that drag together end with the right curve, whatever a slow and a frozen one do."""

from __future__ import annotations

import asyncio
import itertools
import os
import signal
from collections.abc import Coroutine, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

import pytest

from app.guard import connection
from app.server.server import Server, start
from app.state.appearance import PLAIN
from app.ui import page
from benchmarks.interrupt import Interrupt
from benchmarks.soak import catches_up, shut, soak, summary
from benchmarks.tabs import SCENE, open_tabs
from benchmarks.web_tab import WebTab
from tests.app.fake_tab import until

Result = TypeVar("Result")

FEW = 250
"""Messages that a page can be behind with: one for each thing that a drag changes."""
ENOUGH = 0.5
"""Seconds between two looks at a run that would last longer, until there were enough drags."""
LOOKS = 5
"""Looks at what a tab has not read yet, at each of which there is less."""
PLANS = 15
"""Plans whose messages, about 35 each, would be far more than that."""


def run_apart(work: Coroutine[Any, Any, Result]) -> Result:
    """Run in a thread of its own: browser tests leave a loop running in the main one."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(asyncio.run, work).result()


@pytest.fixture
def crowd() -> Iterator[Server]:
    running = start(port=0, scene=SCENE, look=PLAIN)
    yield running
    running.stop()


@pytest.mark.slow
def test_all_tabs_end_with_the_right_curve_beside_a_slow_and_a_frozen_one(
    crowd: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("benchmarks.soak.PERIOD", ENOUGH)
    told, figures = list[str](), dict[str, Any]()

    def watch(moment: str, found: dict[str, Any]) -> None:
        told.append(moment)
        figures.update(found)

    result = run_apart(
        soak(
            *(crowd.url, 3, 600.0, (1.0, 2.5), 0.5),
            watch=watch,
            enough=lambda: figures.get("drags", 0) >= 3,
        )
    )
    assert told[0] == "open"
    assert "running" in told
    assert told[-1] == "end"
    assert result["drags"] >= 3
    assert result["broken"] == 0
    assert result["stale"] == result["stale_slow_or_frozen"] == 0
    until(lambda: not crowd.sessions)


@pytest.mark.slow
def test_what_a_frozen_tab_has_not_read_does_not_grow(crowd: Server) -> None:
    async def freeze(tab: WebTab) -> None:
        # the first picture may come before the server has noted whose it is
        await tab.until(lambda: len(crowd.sessions) == 1)
        (session,) = crowd.sessions.values()
        number = session.client.client_id
        connection = crowd.viser._websock_server._live_connections[number]
        queue = session.client._websock_connection.get_message_buffer().message_from_id
        # as the system does once its own buffers are full
        page.run_on_loop(crowd.viser, connection.pause_writing)
        enough = session.plans + PLANS
        while session.plans < enough:
            await tab.drag(0.5, 0.0)
        assert 0 < len(queue) <= FEW
        page.run_on_loop(crowd.viser, connection.resume_writing)
        assert await catches_up(tab)
        await tab.until(lambda: not queue)

    async def run() -> None:
        (tab,) = await open_tabs(crowd.url, 1)
        await freeze(tab)
        await tab.close()

    run_apart(run())


@pytest.mark.slow
def test_a_tab_that_reads_nothing_for_long_is_given_up_and_comes_back_with_its_scene(
    crowd: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection, "UNREAD", 0.1)
    sizes = itertools.chain(range(LOOKS, 0, -1), itertools.repeat(1))

    async def run() -> None:
        (tab,) = await open_tabs(crowd.url, 1)
        await tab.until(lambda: len(crowd.sessions) == 1)
        await shut(tab, 1.0)
        ((_, server_side),) = crowd.viser._websock_server._live_connections.items()
        # as long as some of it is read, it may go on
        monkeypatch.setattr(server_side.transport, "get_write_buffer_size", sizes.__next__)
        page.run_on_loop(crowd.viser, server_side.pause_writing)
        await tab.until(lambda: not crowd.sessions)
        assert next(sizes) == 1
        tab.freeze(False)
        assert not await tab.answers()
        await tab.connect()
        assert not tab.curves
        assert await catches_up(tab)
        await tab.close()

    run_apart(run())
    until(lambda: not crowd.sessions)


def test_a_summary_tells_the_slowest_tab_and_every_stale_drag() -> None:
    fast = {"rate": 10.0, "gaps": [0.1, 0.1], "late": 0.1, "right": True}
    slow = {"rate": 2.0, "gaps": [0.5, 0.9], "late": 0.4, "right": False}
    result = summary([[fast], [fast], [slow]])
    assert (result["updates_per_s"], result["slowest"], result["stale"]) == (10.0, 2.0, 1)
    assert result["fairness"] == pytest.approx(0.2)
    assert result["updates"] == 3
    assert result["waits"] == pytest.approx(8.8)
    assert result["gap_ms"][2] == pytest.approx(900)
    assert result["last_ms"][1] == pytest.approx(400)


def test_a_summary_of_no_drag_yet_is_empty() -> None:
    assert summary([[], []]) == {"drags": 0, "stale": 0}


def test_an_interrupt_asks_once_and_then_insists() -> None:
    before = signal.getsignal(signal.SIGINT)
    with Interrupt() as interrupt:
        os.kill(os.getpid(), signal.SIGINT)
        assert interrupt.asked
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is before
