"""Caches of results that belong to a shape, for crowds of which few move at a time."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import TypeVar

_S = TypeVar("_S")
_R = TypeVar("_R")

CROWD = 64
"""Number of shapes from which results are cached."""


def per_shape(function: Callable[[_S], _R]) -> Callable[[Sequence[_S]], list[_R]]:
    """Decorator that makes a function of a shape one of many, which caches each one's result.

    The results are those for each thread's latest crowd. Shapes are found by identity: to compare
    them by value, or to hash them, takes longer than all else of a drag.
    """
    of_thread = threading.local()

    def of_all(shapes: Sequence[_S]) -> list[_R]:
        known: dict[int, tuple[_S, _R]] = getattr(of_thread, "known", {})
        found = []
        for shape in shapes:
            entry = known.get(id(shape))
            found.append(entry or (shape, function(shape)))
        if len(shapes) >= CROWD:
            of_thread.known = {id(entry[0]): entry for entry in found}
        return [result for _, result in found]

    return of_all
