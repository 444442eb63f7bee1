"""Return of unused memory to the system."""

from __future__ import annotations

import ctypes
import gc
import sys
import threading

from app.process.turns import TURNS

DELAY = 30.0
"""Seconds in which more may become free, and until it is tried again while tabs wait: it holds all
up for a tenth of a second.
"""

_lock = threading.Lock()
_pending = False


def load_at_once() -> None:
    """Look for no garbage until :func:`loaded`: what is imported stays, and there is much of it."""
    gc.disable()


def loaded() -> None:
    """Look for garbage from now on, but never again among what is there already."""
    gc.freeze()
    gc.enable()


def give_back_soon() -> None:
    """Give back what is free in a while; the C library keeps it otherwise, for later."""
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
