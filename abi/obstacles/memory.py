"""A memory of what was made of a few immutable things, found again without comparing them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

_T = TypeVar("_T")
_R = TypeVar("_R")

_MOST = 16


class ByIdentity(Generic[_T, _R]):
    """A function of one immutable thing, with a memory of the last results.

    To compare tuples of obstacles costs more than most of what is computed with them. The things
    are kept with their results, so that no other can take a forgotten one's place. Threads may
    share it: at worst two of them compute the same.
    """

    def __init__(self, function: Callable[[_T], _R]) -> None:
        self._function = function
        self.__doc__ = function.__doc__
        self._known: tuple[tuple[_T, _R], ...] = ()

    def __call__(self, thing: _T) -> _R:
        """What the function makes of ``thing``, or made of this very object before."""
        for known, result in self._known:
            if known is thing:
                return result
        made = self._function(thing)
        self._known = ((thing, made), *self._known[: _MOST - 1])
        return made
