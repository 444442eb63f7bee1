"""Tabs are handed to the process that has the fewest, whole and with what they have said."""

from __future__ import annotations

import asyncio
import random
import socket
import sys
from collections.abc import Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace
from typing import Any

import pytest

from app.guard.guard import Guard
from app.guard.policy import policy_for
from app.guard.porter import LONGEST_HEAD, Porter, lost_tabs
from app.guard.side_door import SideDoor

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="connections are not handed on")

TAB = b"GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: WebSocket\r\n\r\n"
PAGE = b"GET /?upgrade:%20websocket HTTP/1.1\r\nHost: localhost\r\n\r\n"


def _tabs(porter: Porter) -> tuple[int, ...]:
    """Number of tabs here, and of each process that takes some."""
    return len(porter._own), *(porter._count(channel) for channel in porter._lost)


class Connection:
    """The part of a connection that the porter asks for."""

    def __init__(self, wire: socket.socket) -> None:
        self.transport = SimpleNamespace(get_extra_info={"socket": wire}.__getitem__)


def a_connection(wire: socket.socket) -> Any:
    """A connection, as the types have it."""
    return Connection(wire)


async def turns(condition: Callable[[], bool]) -> None:
    """Let the loop go on until ``condition()``."""
    async with asyncio.timeout(10):
        while not condition():
            await asyncio.sleep(0)


def pair() -> tuple[socket.socket, socket.socket]:
    """A channel: the porter's end, and the other."""
    return socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)


class Other:
    """A process that takes tabs and counts them."""

    def __init__(self, porter: Porter) -> None:
        channel, self.channel = pair()
        self.tabs = self.lost = 0
        porter.meet(channel)

    def take(self) -> bytes:
        """Take a tab; its request."""
        head, (file,), _, _ = socket.recv_fds(self.channel, LONGEST_HEAD, 1)
        socket.close(file)
        self.tabs += 1
        return head

    def lose(self) -> None:
        """Lose one."""
        self.tabs -= 1
        self.lost += 1
        self.channel.send(lost_tabs(self.lost))


async def _come_and_go(seed: int) -> None:
    choose = random.Random(seed)
    porter, (wire, far) = Porter(3), socket.socketpair()
    guard = Guard(policy_for("127.0.0.1", max_tabs=4), porter)
    others = [Other(porter) for _ in range(2)]
    # who has not said a word yet gets none
    first = a_connection(wire)
    assert not porter.hands_on(first, TAB)
    others[0].channel.send(lost_tabs(0))
    await turns(lambda: len(_tabs(porter)) == 2)
    assert not porter.are_all_there
    others[1].channel.send(lost_tabs(0))
    await turns(lambda: porter.are_all_there)
    here = [first]
    for _ in range(100):
        if choose.random() < 0.6:
            tab = a_connection(wire)
            if porter.hands_on(tab, TAB):
                fewest = min(others, key=lambda other: other.tabs)
                assert fewest.tabs <= len(here)
                assert fewest.take() == TAB
            else:
                here.append(tab)
                assert all(other.tabs >= len(here) for other in others)
        elif here and choose.random() < 0.4:
            porter.leave(here.pop())
        elif full := [other for other in others if other.tabs]:
            choose.choice(full).lose()
        await turns(lambda: _tabs(porter) == (len(here), *(one.tabs for one in others)))
        assert guard.is_full == (sum(one.tabs for one in others) >= 4)
    assert not porter.hands_on(a_connection(wire), PAGE)
    assert _tabs(porter)[0] == len(here)
    # what the other end could not take as one message stays
    for _ in range(5):
        here.append(a_connection(wire))
        assert not porter.hands_on(here[-1], TAB + bytes(LONGEST_HEAD))
    # whoever has ended gets none
    for other in others:
        other.channel.close()
    assert not porter.hands_on(a_connection(wire), TAB)
    await turns(lambda: len(_tabs(porter)) == 1)
    assert not guard.is_full
    wire.close()
    far.close()


def run(coroutine: Coroutine[Any, Any, None]) -> None:
    """Run it in a thread of its own, for in this one the browser's loop may run."""
    with ThreadPoolExecutor(1) as threads:
        threads.submit(asyncio.run, coroutine).result()


@pytest.mark.parametrize("seed", range(3))
def test_each_tab_goes_to_who_has_the_fewest(seed: int) -> None:
    run(_come_and_go(seed))


class Echo(asyncio.Protocol):
    """Says what it hears."""

    def __init__(self) -> None:
        self.transport: Any = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = transport

    def data_received(self, data: bytes) -> None:
        self.transport.write(data)


async def _through_the_side_door() -> None:
    ended = asyncio.Event()
    porter, (channel, other) = Porter(2), pair()
    door = SideDoor(other, ended.set, 2)
    await door.open(Echo)
    porter.meet(channel)
    await turns(lambda: _tabs(porter) == (0, 0))
    near, far = socket.socketpair()
    with far:
        assert porter.hands_on(a_connection(near), TAB)
        near.close()
        far.setblocking(False)
        far.send(b"more")
        said = b""
        async with asyncio.timeout(10):
            while len(said) < len(TAB) + 4:
                said += await asyncio.get_running_loop().sock_recv(far, 65536)
        assert said == TAB + b"more"
    assert _tabs(porter) == (0, 1)
    door.leave(a_connection(far))
    await turns(lambda: _tabs(porter) == (0, 0))
    assert door.is_serving()
    channel.shutdown(socket.SHUT_RDWR)
    async with asyncio.timeout(10):
        await ended.wait()
    assert not door.is_serving()
    assert door.get_loop() is asyncio.get_running_loop()  # as who closes it asks


def test_a_connection_is_taken_with_what_it_has_said_before_what_it_says_next() -> None:
    run(_through_the_side_door())
