"""Caches of results that belong to a surface and are kept as long as it is."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar
from weakref import WeakKeyDictionary

from abi.obstacles.triangle_mesh.surface import Surface

_R = TypeVar("_R")

_LATEST = 16


class PerSurface(Generic[_R]):
    """Function of a surface that caches its results; equal surfaces share one.

    They are kept as long as their surfaces are in use, however many a scene has, and the latest
    few beyond that.
    """

    def __init__(self, function: Callable[[Surface], _R]) -> None:
        self.__doc__ = function.__doc__
        self._function = function
        self._results: WeakKeyDictionary[Surface, _R] = WeakKeyDictionary()
        self._latest: deque[Surface] = deque(maxlen=_LATEST)

    def __call__(self, surface: Surface) -> _R:
        """The function's result."""
        result = self._results.get(surface)
        if result is None:
            result = self._function(surface)
            self._results[surface] = result
            self._latest.append(surface)
        return result
