"""What a long computation does, told to whoever watches the thread that it runs in, and its end.

Stages tell what they begin with, and every kernel that is called asks whether the result is still
wanted: see :func:`watched_by`. Nobody watches by default, which costs next to nothing.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Protocol

_PERIOD = 0.05
"""Seconds between two looks at whether a result is wanted, while its thread waits for another."""


class CancelledError(Exception):
    """Raised in a computation whose result is not wanted any more."""


class Watch(Protocol):
    """Who watches a thread."""

    def cancelled(self) -> bool:
        """Check whether the result is not wanted any more; called very often."""

    def told(self, doing: str) -> None:
        """Hear what is done now, as ``searching``."""


class _ThreadWatch(threading.local):
    watch: Watch | None = None


_of_thread = _ThreadWatch()


@dataclass(frozen=True)
class QuietWatch:
    """A watch that asks a function whether the result is not wanted any more, and tells nobody."""

    asks: Callable[[], bool]

    def cancelled(self) -> bool:
        """Ask."""
        return self.asks()

    def told(self, doing: str) -> None:
        """Hear it, and do nothing."""


@contextmanager
def watched_by(watch: Watch) -> Iterator[None]:
    """Have what this thread computes in the block watched.

    Raises:
        CancelledError: the result is not wanted any more. What remembers results between calls,
            as a planner, may then have half of one, and is to be told to forget all.
    """
    before = _of_thread.watch
    _of_thread.watch = watch
    try:
        yield
    finally:
        _of_thread.watch = before


def check() -> None:
    """End the computation if its result is not wanted any more.

    Raises:
        CancelledError: that is so.
    """
    watch = _of_thread.watch
    if watch is not None and watch.cancelled():
        raise CancelledError


def tell(doing: str) -> None:
    """Tell what is done from now on, if it is still wanted.

    Raises:
        CancelledError: it is not.
    """
    check()
    watch = _of_thread.watch
    if watch is not None:
        watch.told(doing)


def wait(event: threading.Event, timeout: float | None = None) -> None:
    """Wait for another thread, if what it does is still wanted.

    Args:
        event: that it sets.
        timeout: longest time to wait, [s]; None for any.

    Raises:
        CancelledError: it is not.
    """
    if _of_thread.watch is None:
        event.wait(timeout)
        return
    end = math.inf if timeout is None else time.monotonic() + timeout
    while not event.wait(min(_PERIOD, max(end - time.monotonic(), 0.0))):
        check()
        if time.monotonic() >= end:
            return
