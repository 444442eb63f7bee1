"""A file and a server that nobody may ask, and who did nevertheless. Linux only."""

from __future__ import annotations

import ctypes
import os
import socket
from pathlib import Path

_OPENED = 0x20  # IN_OPEN in sys/inotify.h


class Outside:
    """Something outside: a file in ``folder`` that is watched, and a server that counts its guests.

    Attributes:
        file: the file's path.
        address: host, port and path of the server.
    """

    def __init__(self, folder: Path) -> None:
        self.file = folder / "secret.stl"
        self.file.write_bytes(b"solid secret\nendsolid secret\n")
        library = ctypes.CDLL(None, use_errno=True)
        self._events = library.inotify_init1(os.O_NONBLOCK)
        if library.inotify_add_watch(self._events, os.fsencode(folder), _OPENED) < 0:
            raise OSError(ctypes.get_errno(), "the folder cannot be watched")
        self._server = socket.create_server(("127.0.0.1", 0))
        self._server.setblocking(False)
        self.address = f"127.0.0.1:{self._server.getsockname()[1]}/secret.stl"

    def asked(self) -> int:
        """Counts of openings of the file and calls of the server since the last time."""
        count = 0
        try:
            events = os.read(self._events, 1 << 20)
            # 16 bytes, and a name padded to another 16
            count += len(events) // 32
        except BlockingIOError:
            pass
        try:
            while True:
                self._server.accept()[0].close()
                count += 1
        except BlockingIOError:
            return count

    def close(self) -> None:
        """Watch no more."""
        os.close(self._events)
        self._server.close()
