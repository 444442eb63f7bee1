"""Texts and drawings of a plan, computed once for all tabs that show it."""

from __future__ import annotations

import functools
import weakref
from collections.abc import Callable
from typing import Any, Concatenate, ParamSpec, TypeVar

from abi.planner.plan import Plan

_P = ParamSpec("_P")
_T = TypeVar("_T")


def once_a_plan(
    function: Callable[Concatenate[Plan, _P], _T],
) -> Callable[Concatenate[Plan, _P], _T]:
    """The same function of a plan and of what can be hashed, which keeps its values.

    They last as long as the plan does, and none may be changed. Two threads that ask at once may
    both compute, to the same end.
    """
    kept: weakref.WeakKeyDictionary[Plan, dict[Any, _T]] = weakref.WeakKeyDictionary()

    @functools.wraps(function)
    def ask(plan: Plan, /, *args: _P.args, **named: _P.kwargs) -> _T:
        values = kept.setdefault(plan, {})
        key = (args, *named.items())
        if key not in values:
            values[key] = function(plan, *args, **named)
        return values[key]

    return ask
