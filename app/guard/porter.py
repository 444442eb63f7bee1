"""Porter: gives each new tab to the process that has the fewest.

One process listens for all. If several listened on one port, or accepted from one socket, chance
would decide which of them gets a connection; and most connections are for the page's files, so
taking turns at connections would not share out the tabs. So the process that listens reads what a
connection asks for. If it is for a tab, it hands the socket, with what it has read, to another
process, over a pair of sockets that can pass open files.
"""

from __future__ import annotations

import asyncio
import re
import socket

from websockets.asyncio.server import ServerConnection

LONGEST_HEAD = 65_536
"""Most bytes of a request that is handed to another process."""
_NUMBER = 8
"""Bytes of a message from the other process."""
_WEBSOCKET = re.compile(rb"\nupgrade:[ \t]*websocket", re.IGNORECASE)


class Porter:
    """Entry of the process that listens; used only in the thread of its connections.

    A tab counts from its request on, so that those that come at once are shared out, too.

    Attributes:
        processes: number of those behind the address, this one included.
    """

    def __init__(self, processes: int) -> None:
        self.processes = processes
        self._own = set[ServerConnection]()
        self._given = dict[socket.socket, int]()
        self._lost = dict[socket.socket, int]()

    def meet(self, channel: socket.socket) -> None:
        """Serve the process at the other end of a channel with tabs until it ends."""
        channel.setblocking(False)
        self._given[channel] = 0
        asyncio.get_running_loop().add_reader(channel, self._hear, channel)

    def hands_on(self, connection: ServerConnection, head: bytes) -> bool:
        """Hand a tab's connection to the process with the fewest; False if that is this one.

        Args:
            connection: of a tab or a request for a file.
            head: its whole request.
        """
        if _WEBSOCKET.search(head) is None:
            return False
        channel = min(self._lost, key=self._count, default=None)
        small = len(head) <= LONGEST_HEAD
        if channel is not None and small and self._count(channel) <= len(self._own):
            try:
                wire = connection.transport.get_extra_info("socket")
                socket.send_fds(channel, [head], [wire.fileno()])
            except OSError:
                pass  # it has ended, or is very busy
            else:
                self._given[channel] += 1
                return True
        self._own.add(connection)
        return False

    def leave(self, connection: ServerConnection) -> None:
        """Stop counting a connection."""
        self._own.discard(connection)

    @property
    def elsewhere(self) -> int:
        """Number of tabs of all other processes."""
        return sum(map(self._count, self._lost))

    @property
    def are_all_there(self) -> bool:
        """Whether every process takes tabs; asked from any thread."""
        return len(self._lost) == self.processes - 1

    def _count(self, channel: socket.socket) -> int:
        return self._given[channel] - self._lost[channel]

    def _hear(self, channel: socket.socket) -> None:
        """Receive how many tabs another process has had and lost; 0 is its greeting."""
        try:
            word = channel.recv(_NUMBER)
        except BlockingIOError:
            return
        except OSError:
            word = b""
        if word:
            self._lost[channel] = int.from_bytes(word)
            return
        asyncio.get_running_loop().remove_reader(channel)
        del self._given[channel]
        self._lost.pop(channel, None)
        channel.close()


def lost_tabs(number: int) -> bytes:
    """Numbers of lost tabs that another process reports to the porter."""
    return number.to_bytes(_NUMBER)
