"""Caches of results that belong to a shape, for crowds of which few move at a time."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

_S = TypeVar("_S")
_R = TypeVar("_R")

CROWD = 64
"""Number of shapes from which results are cached."""


class PerShape(threading.local, Generic[_S, _R]):
    """Function of a shape with its results for each thread's latest crowd.

    Shapes are found by identity: to compare them by value, or to hash them, takes longer than all
    else of a drag.
    """

    def __init__(self, function: Callable[[_S], _R]) -> None:
        self._function = function
        self._known: dict[int, tuple[_S, _R]] = {}

    def of_all(self, shapes: Sequence[_S]) -> list[_R]:
        """The function's result for each of the shapes."""
        known, function = self._known, self._function
        found = []
        for shape in shapes:
            entry = known.get(id(shape))
            found.append(entry or (shape, function(shape)))
        if len(shapes) >= CROWD:
            self._known = {id(entry[0]): entry for entry in found}
        return [result for _, result in found]
