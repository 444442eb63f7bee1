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
    """Turns at the interpreter, ``count`` at once.

    One that takes longer than ``longest`` [s] goes on, and the next begins beside it.
    """

    def __init__(self, count: int = 1, longest: float = LONGEST) -> None:
        self._count, self._longest = count, longest
        self._lock = threading.Lock()
        self._waiting: list[Turn] = []
        self._running: dict[Turn, float] = {}

    @property
    def waiting(self) -> int:
        """Number of threads that wait for their turn."""
        return len(self._waiting)

    def begin(self, turn: Turn) -> None:
        """Wait until ``turn`` is next and one is free."""
        with self._lock:
            turn.due = time.monotonic() + (AT_ONCE if turn.hurried else turn.patience)
            self._waiting.append(turn)
        while True:
            with self._lock:
                delay = self._room() if self._next() is turn else None
                if delay is not None and delay <= 0:
                    self._waiting.remove(turn)
                    turn.hurried = False
                    self._running[turn] = time.monotonic()
                    self._call()
                    return
                turn.called.clear()
            turn.called.wait(delay)

    def end(self, turn: Turn) -> None:
        """End a turn, so that the next can begin."""
        with self._lock:
            del self._running[turn]
            self._call()

    def hasten(self, turn: Turn) -> None:
        """Give ``turn``, or its next use if it is not waiting, the priority of a drag."""
        if turn.hurried:
            return  # a hand asks at each of its moves, and many of these wait for one turn
        with self._lock:
            turn.hurried = True
            due, turn.due = turn.due, min(turn.due, time.monotonic() + AT_ONCE)
            if turn.due < due and turn in self._waiting:
                self._call()

    def _next(self) -> Turn:
        return min(self._waiting, key=lambda turn: turn.due)

    def _call(self) -> None:
        """Wake the waiting threads."""
        if self._waiting:
            self._next().called.set()

    def _room(self) -> float:
        """Seconds until another turn may begin; 0 or less means now."""
        ends = sorted(begin + self._longest for begin in self._running.values())
        if len(ends) < self._count:
            return 0.0
        return ends[-self._count] - time.monotonic()


class Turn:
    """Context manager that waits until its thread may compute; not reentrant.

    Attributes:
        patience: how long it can wait while others are in a hurry, [s].
        hurried: whether it is in a hurry itself, until it begins.
        due: moment at which its patience ends, [s] of the monotonic clock.
        called: set when it is to look whether it is the next.
    """

    def __init__(self, turns: Turns) -> None:
        self._turns = turns
        self.patience = AT_ONCE
        self.hurried = False
        self.due = math.inf
        self.called = threading.Event()

    def after(self, patience: float) -> Turn:
        """Set the maximum delay to ``patience`` [s] unless it is hastened; returns itself."""
        self.patience = patience
        return self

    def hasten(self) -> None:
        """Give this turn, or its next use, the priority of a drag; thread-safe."""
        self._turns.hasten(self)

    def __enter__(self) -> Turn:
        """Wait for the turn."""
        self._turns.begin(self)
        return self

    def __exit__(self, *_: object) -> None:
        """End the turn."""
        self._turns.end(self)


TURNS = Turns()
"""The turns of this process."""
