"""A stage of the planner: a function with a memory of its last call."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Generic, ParamSpec, TypeVar

import numpy as np

from abi.compiled import interpreted_calls
from abi.errors import StageError

_P = ParamSpec("_P")
_R = TypeVar("_R")


class RememberedCall(Generic[_P, _R]):
    """A function that remembers its last call: equal arguments return the same object.

    Attributes:
        ms: time of the last call that had to be computed, [ms].
        interpreted: whether inner loops ran as Python in it, which says nothing of the method.
    """

    def __init__(
        self, function: Callable[_P, _R], clock: Callable[[], float] = time.perf_counter
    ) -> None:
        """Remember no call yet; ``clock`` tells the time, [s]."""
        self.ms, self.interpreted = 0.0, False
        self._clock = clock
        self._function = function
        self._arguments: tuple[object, ...] | None = None
        self._result: _R | None = None
        self._error: StageError | None = None

    def __call__(self, *args: _P.args, **kwargs: _P.kwargs) -> _R:
        """Call the function, or repeat its last result or error for equal arguments."""
        given = (*args, *kwargs, *kwargs.values())
        if self._arguments is None or not _same(self._arguments, given):
            self._arguments, self._result, self._error = None, None, None
            begin, before = self._clock(), interpreted_calls()
            try:
                self._result = self._function(*args, **kwargs)
            except StageError as error:
                self._error = error
            self._arguments = given
            self.ms = 1e3 * (self._clock() - begin)
            self.interpreted = interpreted_calls() > before
        if self._error is not None:
            # without the frames of earlier calls, which would pile up
            raise self._error.with_traceback(None)
        return self._result  # type: ignore[return-value]


def _same(before: tuple[object, ...], now: tuple[object, ...]) -> bool:
    """Check whether settings are equal by value, and results and their arrays by identity."""
    return len(before) == len(now) and all(
        a is b or (not isinstance(a, np.ndarray) and a == b)
        for a, b in zip(before, now, strict=True)
    )
