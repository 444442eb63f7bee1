"""Return of unused memory to the system."""

from __future__ import annotations

import ctypes
import gc
import sys
import threading

from app.process.turns import TURNS

DELAY = 30.0
"""Seconds to wait for more memory to become free, and between tries while tabs wait: each try
blocks all threads for a tenth of a second."""

_lock = threading.Lock()
_pending = False


def load_at_once() -> None:
    """Suspend garbage collection until :func:`loaded`, as imports create many objects that stay."""
    gc.disable()


def loaded() -> None:
    """Resume garbage collection, leaving out the objects that exist already."""
    gc.freeze()
    gc.enable()


def give_back_soon() -> None:
    """Return free memory to the system after a delay; the C library would keep it."""
    global _pending
    with _lock:
        if _pending:
            return
        _pending = True
    _begin()


def _begin() -> None:
    timer = threading.Timer(DELAY, _give_back)
    timer.daemon = True
    timer.start()


def _give_back() -> None:
    global _pending
    if TURNS.waiting:
        _begin()
        return
    with _lock:
        _pending = False
    gc.collect()
    if sys.platform == "linux":
        # glibc has it, other C libraries need it less
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
        if trim is not None:
            trim(0)
