"""Stamp of a kernel: what tells that its compiled form is still that of its source.

numba stamps what it keeps with the file that a kernel is in. But the functions that a kernel calls
are compiled into it, and many of them are in other files; and whatever else changes in its own file
has nothing to do with it. So a stamp is made from the function and all that it is compiled with.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from types import CodeType, FunctionType
from typing import Any

_CONSTANT = (bool, int, float, str, tuple, type(None))


def stamp(function: Callable[..., Any], options: str = "") -> str:
    """Hash of a function's code, of the functions and constants that it uses, and of theirs.

    Comments, docstrings and places of lines do not count.

    Args:
        function: a Python function.
        options: what else the outcome depends on.
    """
    whole = hashlib.sha256(options.encode())
    todo: list[Any] = [function]
    seen: set[str] = set()
    while todo:
        one = todo.pop()
        name = f"{one.__module__}.{one.__qualname__}"
        if name in seen:
            continue
        seen.add(name)
        whole.update(name.encode())
        for code in _codes(one.__code__):
            constants = [value for value in code.co_consts if not isinstance(value, CodeType)]
            if constants and constants[0] == one.__doc__:
                constants = constants[1:]
            whole.update(code.co_code)
            whole.update(repr((constants, code.co_names, code.co_varnames)).encode())
            for used in code.co_names:
                value = one.__globals__.get(used)
                if isinstance(value, FunctionType):
                    todo.append(value)
                elif hasattr(value, "_fields"):  # a named tuple that it makes
                    whole.update(repr((used, value._fields)).encode())
                elif isinstance(value, _CONSTANT):
                    whole.update(repr((used, value)).encode())
    return whole.hexdigest()


def fields_of(example: Any) -> str:
    """Names of the fields of named tuples among arguments: compiled, they are numbers."""
    if not isinstance(example, tuple):
        return ""
    return repr((getattr(example, "_fields", ""), *map(fields_of, example)))


def _codes(code: CodeType) -> Iterator[CodeType]:
    """A function's code and that of the comprehensions in it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)
