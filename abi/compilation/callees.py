"""What is compiled together with a function: the function itself and all that it calls."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from inspect import unwrap
from types import CodeType, FunctionType
from typing import Any


def compiled_with(function: Callable[..., Any]) -> Iterator[FunctionType]:
    """Yield a Python function, the functions that it calls, and those that they call."""
    pending: list[Any] = [function]
    seen: set[str] = set()
    while pending:
        current = pending.pop()
        name = f"{current.__module__}.{current.__qualname__}"
        if name in seen:
            continue
        seen.add(name)
        yield current
        for code in codes(current.__code__):
            used = (current.__globals__.get(name) for name in code.co_names)
            pending += (unwrap(value) for value in used if isinstance(value, FunctionType))


def code_size(function: Callable[..., Any]) -> int:
    """Bytes of Python code that are compiled for a function; compilation takes about as long."""
    return sum(len(code.co_code) for one in compiled_with(function) for code in codes(one.__code__))


def codes(code: CodeType) -> Iterator[CodeType]:
    """Yield a function's code and that of the comprehensions in it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from codes(constant)
