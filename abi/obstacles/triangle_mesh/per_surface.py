"""Caches of results that belong to a surface and are kept as long as it is."""

from __future__ import annotations

import functools
from collections import deque
from collections.abc import Callable
from typing import TypeVar
from weakref import WeakKeyDictionary

from abi.obstacles.triangle_mesh.surface import Surface

_R = TypeVar("_R")

_LATEST = 16


def per_surface(function: Callable[[Surface], _R]) -> Callable[[Surface], _R]:
    """Decorator that caches a function's results by surface; equal surfaces share one.

    They are kept as long as their surfaces are in use, however many a scene has, and the latest
    few beyond that.
    """
    results: WeakKeyDictionary[Surface, _R] = WeakKeyDictionary()
    latest: deque[Surface] = deque(maxlen=_LATEST)

    @functools.wraps(function)
    def call(surface: Surface) -> _R:
        result = results.get(surface)
        if result is None:
            result = results[surface] = function(surface)
            latest.append(surface)
        return result

    return call
