"""Functions that only kernels call, which numba compiles together with its callers.

They are noted here and declared to numba before the first kernel is compiled, so that a program's
first plan does not wait for numba to be imported.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import partial, update_wrapper
from typing import Any, TypeVar, cast, overload

_F = TypeVar("_F", bound=Callable[..., Any])

UNDECLARED: deque[Callable[..., Any]] = deque()
"""Functions that numba does not know of yet, in the order of import."""

_OPTIONS: dict[Callable[..., Any], dict[str, Any]] = {}


@overload
def jitable(function: _F) -> _F: ...


@overload
def jitable(**options: Any) -> Callable[[_F], _F]: ...


def jitable(function: _F | None = None, **options: Any) -> _F | Callable[[_F], _F]:
    """Let kernels call a function, which stays as it is.

    Args:
        function: a function that numba can compile.
        options: those of :func:`numba.extending.register_jitable`.
    """

    def note(function: _F) -> _F:
        _OPTIONS[function] = options
        UNDECLARED.append(function)
        return function

    return note if function is None else note(function)


def called_as(form: _F) -> Callable[[_F], _F]:
    """Have Python call another form of a function than the one that kernels are compiled with."""
    return cast(Callable[[_F], _F], partial(update_wrapper, form))


def options_of(function: Callable[..., Any]) -> dict[str, Any]:
    """Return the options that a function was decorated with."""
    return _OPTIONS.get(function, {})
