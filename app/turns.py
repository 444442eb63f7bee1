"""Turns of the tabs at the interpreter, in the order in which they came.

Only one thread runs Python at a time. Thirty that all want to take it from each other every half
millisecond, and it takes one that answers the network as long to get it back each time. In turns
each tab's work is done in one go, and the others wait for it as long as they would anyhow.
"""

from __future__ import annotations

import threading
import time
from collections import deque

LONGEST = 0.05
"""Seconds after which a turn no longer keeps the others waiting: it may be a long computation."""


class Turns:
    """Turns, ``count`` at once; a context manager for threads that do not nest it.

    One that takes longer than ``longest`` [s] goes on, and the next begins beside it.
    """

    def __init__(self, count: int = 1, longest: float = LONGEST) -> None:
        self._count, self._longest = count, longest
        self._lock = threading.Lock()
        self._waiting: deque[threading.Event] = deque()
        self._running: dict[int, float] = {}

    @property
    def waiting(self) -> int:
        """Number of threads that wait for their turn."""
        return len(self._waiting)

    def __enter__(self) -> Turns:
        """Wait for a turn."""
        called = threading.Event()
        with self._lock:
            if not self._waiting and self._room() <= 0:
                self._begin()
                return self
            self._waiting.append(called)
        while True:
            with self._lock:
                first = self._waiting[0] is called
                delay = self._room() if first else None
                if delay is not None and delay <= 0:
                    self._waiting.popleft()
                    self._begin()
                    self._call()
                    return self
                called.clear()
            called.wait(delay)

    def __exit__(self, *_: object) -> None:
        """End the turn."""
        with self._lock:
            del self._running[threading.get_ident()]
            self._call()

    def _begin(self) -> None:
        self._running[threading.get_ident()] = time.monotonic()

    def _call(self) -> None:
        """Have the first that waits look again."""
        if self._waiting:
            self._waiting[0].set()

    def _room(self) -> float:
        """Seconds until another turn may begin; 0 or less: now."""
        ends = sorted(begin + self._longest for begin in self._running.values())
        if len(ends) < self._count:
            return 0.0
        return ends[-self._count] - time.monotonic()


TURNS = Turns()
"""Of this process."""
