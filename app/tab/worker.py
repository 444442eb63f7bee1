"""Worker thread of a tab: waits for input or a timeout, then takes a step in its turn."""

from __future__ import annotations

import threading
from collections.abc import Callable

from app.process.turns import TURNS, Turn

_PATIENCE = 5.0
"""Seconds that closing a tab waits for a step that has begun."""


class TabWorker:
    """Thread that takes a step after input; several inputs before a step are taken together."""

    def __init__(
        self,
        name: str,
        prepare: Callable[[], None],
        timeout: Callable[[], float],
        ready: Callable[[], object],
        patience: Callable[[], float],
        step: Callable[[bool], None],
    ) -> None:
        """Create the worker; its thread is not started yet.

        Args:
            name: of the thread.
            prepare: called first, outside of any turn.
            timeout: time to wait for input, [s].
            ready: called before each step, outside of its turn, to wait for what it needs.
            patience: time for which a step can wait behind the hands in other tabs, [s].
            step: called with whether there was input.
        """
        self._prepare, self._timeout, self._ready = prepare, timeout, ready
        self._patience, self._step = patience, step
        self._changed = threading.Event()
        self._closing = False
        self._turn = Turn(TURNS)
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

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
        self._turn.hasten()

    def is_woken(self) -> bool:
        """Check whether a step is requested."""
        return self._changed.is_set()

    def close(self) -> None:
        """End the thread and wait for it, unless called from it."""
        self._closing = True
        self._changed.set()
        if threading.current_thread() is not self._thread:
            self._thread.join(_PATIENCE)

    def _run(self) -> None:
        self._prepare()
        while True:
            self._changed.wait(self._timeout())
            self._ready()
            if self._closing:
                return
            with self._turn.after(self._patience()):
                # not what wait() returned: the input may have come while it gave up
                if woken := self._changed.is_set():
                    self._changed.clear()
                self._step(woken)
