"""Texts and drawings of a plan, computed once for all tabs that show it."""

from __future__ import annotations

import functools
import threading
import weakref
from collections.abc import Callable
from typing import Any, Concatenate, Generic, ParamSpec, TypeVar

from abi.planner.plan import Plan

_P = ParamSpec("_P")
_T = TypeVar("_T")


class once_a_plan(Generic[_P, _T]):
    """Wrapper that caches a function's results by plan and further arguments.

    They last as long as the plan does, and none may be changed. Of threads that ask at once, as in
    a class that opens together, one computes and the others wait for it.
    """

    def __init__(self, function: Callable[Concatenate[Plan, _P], _T]) -> None:
        self._function = function
        self._kept: weakref.WeakKeyDictionary[Plan, tuple[threading.RLock, dict[Any, _T]]]
        self._kept = weakref.WeakKeyDictionary()
        self._lock = threading.Lock()
        functools.update_wrapper(self, function)

    def __call__(self, plan: Plan, /, *args: _P.args, **named: _P.kwargs) -> _T:
        """The result for a plan."""
        key = (args, *named.items())
        with self._lock:
            lock, values = self._kept.setdefault(plan, (threading.RLock(), {}))
        if key not in values:
            with lock:
                if key not in values:
                    values[key] = self._function(plan, *args, **named)
        return values[key]
