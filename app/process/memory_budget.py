"""Memory of a server, divided among those who take of it: tabs, and files that are uploaded."""

from __future__ import annotations

import gc
import math
import threading
import time

SMALL = 8_000_000
"""Bytes that every tab may use regardless of the others: a mesh of 30,000 nodes."""
_SERVER = 400_000_000
"""Bytes that a process uses without a tab."""
_PERIOD = 5.0
"""Seconds between two checks for closed tabs."""
_UNKNOWN = 4_000_000_000
"""Assumed bytes of a machine whose memory is unknown."""
_UPLOADS = 500_000_000
"""Most bytes of all uploads together."""
_UPLOADS_SHARE = 8
"""Part of the memory that these may take, as the temporary disk is often memory too."""


def memory_for_tabs(memory: int | None, processes: int = 1) -> int:
    """Bytes that the tabs of a process may use together.

    Half of all is for the processes that read files from outside.

    Args:
        memory: bytes of the machine or container; None where nobody tells.
        processes: those that share it.
    """
    half = (_UNKNOWN if memory is None else memory) // 2
    return max(half // processes - _SERVER, half // (4 * processes))


def memory_for_uploads(memory: int | None) -> int:
    """Bytes for all uploads of a machine or container with that much memory; None if unknown."""
    return _UPLOADS if memory is None else min(_UPLOADS, memory // _UPLOADS_SHARE)


class MemoryBudget:
    """Bytes that several owners share; thread-safe.

    An owner is a number, such as that of a tab.
    """

    def __init__(self, size: int, least: int = 0) -> None:
        """Share ``size`` bytes, of which each owner may take ``least`` whatever others have."""
        self._size, self._least = size, least
        self._lock = threading.Lock()
        self._taken: dict[int, int] = {}
        self._looked = -math.inf

    def taken(self, owner: int) -> int:
        """Bytes that an owner has."""
        return self._taken.get(owner, 0)

    def left(self, owner: int) -> int:
        """Bytes that an owner may have, including those that it has already."""
        free = self._size - sum(list(self._taken.values())) + self.taken(owner)
        return max(free, self._least)

    def take(self, owner: int, size: int) -> bool:
        """Reserve bytes for an owner in place of those that it has, if they are left."""
        with self._lock:
            if size > self.left(owner):
                return False
            self._taken[owner] = size
            return True

    def leave(self, owner: int) -> None:
        """Release what an owner has."""
        with self._lock:
            self._taken.pop(owner, None)

    def collect(self) -> None:
        """Have owners leave that are garbage, as closed tabs are, but not at every call."""
        if time.monotonic() - self._looked > _PERIOD:
            self._looked = time.monotonic()
            gc.collect()
