"""A message to a page is not kept once sent, and the newest replaces what still waits."""

from __future__ import annotations

import asyncio
import functools
import re
import threading
from typing import get_args

import pytest
import viser
from viser import _messages

from abi import assets
from app.server.server import Server
from app.tab.session import Session
from app.ui import page
from tests.app.fake_tab import FakeTab, until


def _waiting(client: viser.ClientHandle) -> list[str]:
    messages = tuple(client._websock_connection.get_message_buffer().message_from_id.values())
    return [m.source for m in messages if isinstance(m, _messages.RunJavascriptMessage)]


def test_of_scripts_for_one_place_the_newest_waits(server: Server) -> None:
    fake = FakeTab(server.url)
    until(lambda: bool(server.viser.get_clients()))
    client = max(server.viser.get_clients().items())[1]
    with client.atomic():
        # nothing is sent before the block ends
        for number in range(100):
            page.call(client, "show", "tour", f"step {number}")
            page.call(client, "clock", float(number), 100.0, False)
            page.call(client, "next")
        waiting = _waiting(client)
        assert sum(source.startswith('abi.show("tour"') for source in waiting) == 1
        assert any("step 99" in source for source in waiting)
        assert sum(source.startswith("abi.clock") for source in waiting) == 1
        assert sum(source.startswith("abi.next") for source in waiting) == 100
    fake.close()


@pytest.mark.parametrize("function", get_args(page.Function))
def test_every_function_that_is_called_is_one_of_the_page(function: str) -> None:
    found = [
        line
        for name in ("page.js", "files.js")
        for line in assets.path("page", name).read_text("utf-8").splitlines()
        if re.match(rf"  (async )?{function}\(.*{{|window\.abi\.{function} = ", line)
    ]
    assert len(found) == 1


def test_nothing_is_kept_of_a_script_that_was_sent(tab: tuple[FakeTab, Session]) -> None:
    _, session = tab
    buffer = session.client._websock_connection.get_message_buffer()
    for number in range(50):
        page.call(session.client, "next")
        page.call(session.client, "show", "tour", str(number))
    until(functools.partial(_all_sent, session))
    until(lambda: not any("run" in str(key) for key in tuple(buffer.id_from_redundancy_key)))


def _all_sent(session: Session) -> bool:
    return not _waiting(session.client)


def test_no_tab_sleeps_through_an_event_set_while_it_begins_to_wait() -> None:
    class Hurried(asyncio.Event):
        """Set by another thread after the waiter has looked, as the worker of a busy tab does."""

        def _get_loop(self) -> asyncio.AbstractEventLoop:
            loop = asyncio.get_running_loop()

            def push() -> None:
                self.set()
                loop.call_soon_threadsafe(self.set)

            other = threading.Thread(target=push)
            other.start()
            other.join()
            return loop

    async def wait() -> bool:
        event = Hurried()
        page.set_on_loop_only(event)
        return await asyncio.wait_for(event.wait(), timeout=5)

    # a loop of its own, in a thread of its own: the browser's tests have one in this
    result: list[bool] = []
    waiter = threading.Thread(target=lambda: result.append(asyncio.run(wait())))
    waiter.start()
    waiter.join()
    assert result == [True]
