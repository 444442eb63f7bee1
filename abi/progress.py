"""What a long computation does, told to whoever watches the thread that it runs in, and its end.

Stages tell what they begin with, and every kernel that is called asks whether the result is still
wanted: see :func:`watched_by`. Nobody watches by default, which costs next to nothing.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator
from concurrent import futures
from contextlib import contextmanager
from contextvars import ContextVar

_PERIOD = 0.05
"""Seconds between two looks at whether a result is wanted, while its thread waits for another."""


CancelledError = futures.CancelledError
"""Raised in a computation whose result is not wanted any more."""


_cancelled: ContextVar[Callable[[], bool] | None] = ContextVar("cancelled", default=None)
_told: ContextVar[Callable[[str], None] | None] = ContextVar("told", default=None)
"""Who watches this thread: a new one begins without."""


@contextmanager
def watched_by(
    cancelled: Callable[[], bool], told: Callable[[str], None] | None = None
) -> Iterator[None]:
    """Have what this thread computes in the block watched.

    Args:
        cancelled: whether the result is not wanted any more; called very often.
        told: takes what is done now, as ``searching``; None to tell nobody.

    Raises:
        CancelledError: the result is not wanted any more. What remembers results between calls,
            as a planner, may then have half of one, and is to be told to forget all.
    """
    before = _cancelled.set(cancelled), _told.set(told)
    try:
        yield
    finally:
        _cancelled.reset(before[0])
        _told.reset(before[1])


def check() -> None:
    """End the computation if its result is not wanted any more.

    Raises:
        CancelledError: that is so.
    """
    cancelled = _cancelled.get()
    if cancelled is not None and cancelled():
        raise CancelledError


def tell(doing: str) -> None:
    """Tell what is done from now on, if it is still wanted.

    Raises:
        CancelledError: it is not.
    """
    check()
    told = _told.get()
    if told is not None:
        told(doing)


def wait(event: threading.Event, timeout: float | None = None) -> None:
    """Wait for another thread, if what it does is still wanted.

    Args:
        event: that it sets.
        timeout: longest time to wait, [s]; None for any.

    Raises:
        CancelledError: it is not.
    """
    if _cancelled.get() is None:
        event.wait(timeout)
        return
    end = math.inf if timeout is None else time.monotonic() + timeout
    while not event.wait(min(_PERIOD, max(end - time.monotonic(), 0.0))):
        check()
        if time.monotonic() >= end:
            return
