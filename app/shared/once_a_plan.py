"""Texts and drawings of a plan, computed once for all tabs that show it."""

from __future__ import annotations

import functools
import weakref
from collections.abc import Callable
from typing import Any, Concatenate, Generic, ParamSpec, TypeVar

from abi.planner.plan import Plan

_P = ParamSpec("_P")
_T = TypeVar("_T")


class once_a_plan(Generic[_P, _T]):
    """Wrapper that caches a function's results by plan and further arguments.

    They last as long as the plan does, and none may be changed. Two threads that ask at once may
    both compute, to the same end.
    """

    def __init__(self, function: Callable[Concatenate[Plan, _P], _T]) -> None:
        self._function = function
        self._kept: weakref.WeakKeyDictionary[Plan, dict[Any, _T]] = weakref.WeakKeyDictionary()
        functools.update_wrapper(self, function)

    def __call__(self, plan: Plan, /, *args: _P.args, **named: _P.kwargs) -> _T:
        """The result for a plan."""
        values = self._kept.setdefault(plan, {})
        key = (args, *named.items())
        if key not in values:
            values[key] = self._function(plan, *args, **named)
        return values[key]
