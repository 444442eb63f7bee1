"""Worker thread of a tab: waits for input or a timeout, then takes a step in its turn."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from app.process.turns import TURNS

_PATIENCE = 5.0
"""Seconds that closing a tab waits for a step that has begun."""


class TabWorker:
    """Thread that takes a step after input; several inputs before a step are taken together.

    Attributes:
        closed: whether it is to end.
    """

    def __init__(self, name: str, run: Callable[[], None]) -> None:
        """Create the worker; its thread is not started yet.

        Args:
            name: of the thread.
            run: what it does: steps, each after :meth:`wait` and in a :meth:`turn`, until it is
                ``closed``.
        """
        self._changed = threading.Event()
        self.closed = False
        self._thread = threading.Thread(target=run, name=name, daemon=True)

    def start(self) -> None:
        """Start the thread, which takes a first step."""
        self._changed.set()
        self._thread.start()

    def wake(self) -> None:
        """Request a step."""
        self._changed.set()

    def hurry(self) -> None:
        """Request a step with priority, as a user waits for it."""
        self._changed.set()
        TURNS.hasten(self._thread)

    def is_woken(self) -> bool:
        """Check whether a step is requested."""
        return self._changed.is_set()

    def wait(self, seconds: float) -> None:
        """Wait until a step is requested, at most that long."""
        self._changed.wait(seconds)

    @contextmanager
    def turn(self, patience: float) -> Iterator[bool]:
        """Take a step in the block, in this tab's turn; whether it was requested.

        Args:
            patience: time for which it can wait behind the hands in other tabs, [s].
        """
        with TURNS.turn(self._thread, patience):
            # not what a wait returned: the input may have come while it gave up
            if woken := self._changed.is_set():
                self._changed.clear()
            yield woken

    def close(self) -> None:
        """End the thread and wait for it, unless called from it."""
        self.closed = True
        self._changed.set()
        if threading.current_thread() is not self._thread:
            self._thread.join(_PATIENCE)
