"""Results shared by all tabs: computed once, however many tabs ask at the same time.

A cache alone lets each of thirty tabs that open together compute the same, and each thirty times as
slowly.
"""

from __future__ import annotations

import functools
import threading
import weakref
from collections import OrderedDict
from collections.abc import Callable
from typing import Any, Concatenate, ParamSpec, TypeVar

from abi.planner.plan import Plan

_P = ParamSpec("_P")
_T = TypeVar("_T")


def computed_once(
    kept: int, by: Callable[..., Any] | None = None
) -> Callable[[Callable[_P, _T]], Callable[_P, _T]]:
    """Decorator that caches a function's latest ``kept`` results by its positional arguments.

    Results must be immutable. Who asks while a value is computed waits for it.

    Args:
        kept: number of results.
        by: what they depend on, as a function of the arguments; all of these without one.
    """

    def shared(function: Callable[_P, _T]) -> Callable[_P, _T]:
        lock, cached = threading.RLock(), OrderedDict[Any, _T]()

        @functools.wraps(function)
        def call(*args: _P.args, **named: _P.kwargs) -> _T:
            key = args if by is None else by(*args)
            with lock:
                if key not in cached:
                    cached[key] = function(*args, **named)
                cached.move_to_end(key)
                if len(cached) > kept:
                    cached.popitem(last=False)
                return cached[key]

        return call

    return shared


def once_a_plan(
    function: Callable[Concatenate[Plan, _P], _T],
) -> Callable[Concatenate[Plan, _P], _T]:
    """Decorator that caches a function's results by plan and further arguments.

    They last as long as the plan does, and none may be changed. Of threads that ask at once, as in
    a class that opens together, one computes and the others wait for it.
    """
    kept: weakref.WeakKeyDictionary[Plan, tuple[threading.RLock, dict[Any, _T]]]
    kept, all_plans = weakref.WeakKeyDictionary(), threading.Lock()

    @functools.wraps(function)
    def call(plan: Plan, /, *args: _P.args, **named: _P.kwargs) -> _T:
        key = (args, *named.items())
        with all_plans:
            lock, values = kept.setdefault(plan, (threading.RLock(), {}))
        if key not in values:
            with lock:
                if key not in values:
                    values[key] = function(plan, *args, **named)
        return values[key]

    return call
