"""Results shared by all tabs: computed once, however many tabs ask at the same time.

A cache alone lets each of thirty tabs that open together compute the same, and each thirty times as
slowly.
"""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable
from typing import Generic, ParamSpec, TypeVar

_P = ParamSpec("_P")
_T = TypeVar("_T")


class ComputedOnce(Generic[_P, _T]):
    """Wrapper that caches a function's latest results by its arguments; they must be immutable.

    Who asks while a value is computed waits for it.
    """

    def __init__(self, kept: int, function: Callable[_P, _T]) -> None:
        self._lock = threading.RLock()
        self._kept = functools.lru_cache(kept)(function)
        functools.update_wrapper(self, function)

    def __call__(self, *args: _P.args, **_: _P.kwargs) -> _T:
        """The result for positional arguments."""
        with self._lock:
            return self._kept(*args)


def computed_once(kept: int) -> Callable[[Callable[_P, _T]], ComputedOnce[_P, _T]]:
    """Decorator that shares the latest ``kept`` results of a function."""
    return functools.partial(ComputedOnce, kept)
