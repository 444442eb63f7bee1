"""Turns of the tabs at the interpreter: drags first, background work after them.

Only one thread runs Python at a time. Thirty of them would take it from each other every half
millisecond, and the thread that answers the network would have to wait as long each time. With
turns, each tab's work is done in one go, and the others wait no longer than they would anyway.

Each request says how long it can wait, and the one whose patience ends first is next. So nothing
waits for ever behind urgent requests, and equally patient ones are served in the order of asking.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Hashable, Iterator
from contextlib import contextmanager

LONGEST = 0.25
"""Seconds after which a turn no longer blocks the others, as it may be a long computation.

Far more than a picture takes: where other programs want the processor, too, turns that overlap for
that reason slow each other down, so that still more of them overlap, and tabs wait for seconds.
"""
AT_ONCE = 0.0
"""Maximum delay of what a user is waiting for, [s]."""
PATIENT = 1.0
"""Maximum delay of background updates, which follow another user or complete a picture, [s]."""


class Turns:
    """Turns at the interpreter, ``count`` at once, by whom they are asked for.

    One that takes longer than ``longest`` [s] goes on, and the next begins beside it.
    """

    def __init__(self, count: int = 1, longest: float = LONGEST) -> None:
        self._count, self._longest = count, longest
        self._lock = threading.Lock()
        # moments at which the patience of those who wait ends, [s]
        self._due: dict[Hashable, float] = {}
        # set for whoever is to look whether it is next
        self._called: dict[Hashable, threading.Event] = {}
        self._hurried: set[Hashable] = set()
        self._running: dict[Hashable, float] = {}

    @property
    def waiting(self) -> int:
        """Number of threads that wait for their turn."""
        return len(self._due)

    @contextmanager
    def turn(self, who: Hashable, patience: float = AT_ONCE) -> Iterator[None]:
        """Compute in the block, once one of the turns is free and nobody else is next.

        Args:
            who: who asks, which has no other turn meanwhile.
            patience: how long it can wait while others are in a hurry, [s]; unless it is hastened.
        """
        self._begin(who, patience)
        try:
            yield
        finally:
            with self._lock:
                del self._running[who]
                self._call()

    def hasten(self, who: Hashable) -> None:
        """Give a turn, or the next one if ``who`` does not wait, the priority of a drag."""
        if who in self._hurried:
            return  # a hand asks at each of its moves, and many of these wait for one turn
        with self._lock:
            self._hurried.add(who)
            now = time.monotonic() + AT_ONCE
            if self._due.get(who, -math.inf) > now:
                self._due[who] = now
                self._call()

    def _begin(self, who: Hashable, patience: float) -> None:
        """Wait until ``who`` is next and a turn is free."""
        called = threading.Event()
        with self._lock:
            delay = AT_ONCE if who in self._hurried else patience
            self._due[who], self._called[who] = time.monotonic() + delay, called
        while True:
            with self._lock:
                room = self._room() if self._next() == who else None
                if room is not None and room <= 0:
                    del self._due[who], self._called[who]
                    self._hurried.discard(who)
                    self._running[who] = time.monotonic()
                    self._call()
                    return
                called.clear()
            called.wait(room)

    def _next(self) -> Hashable:
        return min(self._due, key=self._due.__getitem__)

    def _call(self) -> None:
        """Wake the thread that is next."""
        if self._due:
            self._called[self._next()].set()

    def _room(self) -> float:
        """Seconds until another turn may begin; 0 or less means now."""
        ends = sorted(begin + self._longest for begin in self._running.values())
        if len(ends) < self._count:
            return 0.0
        return ends[-self._count] - time.monotonic()


TURNS = Turns()
"""The turns of this process."""
