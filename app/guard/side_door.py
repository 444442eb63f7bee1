"""Side door of a worker process, whose connections are accepted by the listening process.

The other side is :mod:`app.guard.porter`.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
from collections.abc import Callable
from typing import Any

from websockets.asyncio.server import ServerConnection

from app.guard.porter import LONGEST_HEAD, lost_tabs

_INPUT = 0
"""File descriptor of standard input, which is the worker's channel."""


class SideDoor:
    """asyncio server whose connections another process has accepted.

    Attributes:
        sockets: none to listen at.
        processes: number of those behind the address.
        elsewhere: tabs of all other processes, of which only the one that listens needs to know.
    """

    sockets = ()
    elsewhere = 0

    def __init__(self, channel: socket.socket, ended: Callable[[], object], processes: int) -> None:
        """Receive connections from a channel; ``ended`` is called once the other end is closed."""
        self.processes = processes
        self._channel = channel
        self._ended = ended
        self._lost = 0
        self._is_open = False
        self._loop: asyncio.AbstractEventLoop | None = None
        self._factory: Callable[[], asyncio.Protocol] | None = None
        self._entering = set[asyncio.Task[None]]()

    @classmethod
    def of_input(cls, ended: Callable[[], object], processes: int) -> SideDoor:
        """The side door whose channel is this process's standard input."""
        channel = socket.socket(fileno=os.dup(_INPUT))
        # a child would keep the channel open past this process's end
        empty = os.open(os.devnull, os.O_RDONLY)
        os.dup2(empty, _INPUT)
        os.close(empty)
        return cls(channel, ended, processes)

    async def open(
        self, factory: Callable[[], asyncio.Protocol], *address: Any, **options: Any
    ) -> SideDoor:
        """Start receiving; replaces a loop's ``create_server``, without an address."""
        self._loop, self._factory = asyncio.get_running_loop(), factory
        self._is_open = True
        self._channel.setblocking(False)
        self._loop.add_reader(self._channel, self._take)
        self._tell()
        return self

    def hands_on(self, connection: ServerConnection, head: bytes) -> bool:
        """Keep every connection in this process."""
        return False

    def leave(self, connection: ServerConnection) -> None:
        """Report a lost connection to the listening process."""
        self._lost += 1
        self._tell()

    def close(self) -> None:
        """Stop receiving connections."""
        if self._is_open:
            self._is_open = False
            self.get_loop().remove_reader(self._channel)
            self._channel.close()

    def get_loop(self) -> asyncio.AbstractEventLoop:
        """The event loop of the connections."""
        assert self._loop is not None
        return self._loop

    def is_serving(self) -> bool:
        """Check whether connections are received."""
        return self._is_open

    async def wait_closed(self) -> None:
        """Return at once, as there is no listening socket."""

    def _tell(self) -> None:
        # one that does not go out now is part of the next
        with contextlib.suppress(OSError):
            self._channel.send(lost_tabs(self._lost))

    def _take(self) -> None:
        """Receive a connection with the bytes that it has sent so far."""
        try:
            head, files, _, _ = socket.recv_fds(self._channel, LONGEST_HEAD, 1)
        except BlockingIOError:
            return
        except OSError:
            head, files = b"", []
        if not head:
            self.close()
            self._ended()
            return
        for file in files:
            task = self.get_loop().create_task(self._enter(socket.socket(fileno=file), head))
            self._entering.add(task)
            task.add_done_callback(self._entering.discard)

    async def _enter(self, wire: socket.socket, head: bytes) -> None:
        wire.setblocking(False)
        assert self._factory is not None
        _, connection = await self.get_loop().connect_accepted_socket(self._factory, wire)
        # before anything that the socket still has, which is not looked at in this turn of the loop
        connection.data_received(head)
