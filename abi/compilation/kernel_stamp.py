"""Stamp of a kernel: a hash of its source that tells whether its cached compiled form is current.

numba's own stamp is that of the kernel's file. But the functions that a kernel calls are compiled
into it, and many of them are in other files; and most changes to its own file do not affect it.
So this stamp is made from the function and everything that is compiled with it, and from the
compiler: its version, and what this package adds to it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache
from importlib.metadata import version
from pathlib import Path
from types import CodeType
from typing import Any

from abi.compilation.callees import codes, compiled_with
from abi.compilation.jitable import options_of

_CONSTANTS = (bool, int, float, str, tuple, type(None))


def stamp(function: Callable[..., Any], options: str = "") -> str:
    """Hash of a function's code, of the functions and constants that it uses, and of theirs.

    Comments, docstrings and line numbers do not count.

    Args:
        function: a Python function.
        options: text of further options on which the compiled form depends.
    """
    digest = hashlib.sha256(options.encode() + compiler_stamp())
    for current in compiled_with(function):
        digest.update(f"{current.__module__}.{current.__qualname__}".encode())
        digest.update(repr(sorted(options_of(current).items())).encode())
        for code in codes(current.__code__):
            constants = [value for value in code.co_consts if not isinstance(value, CodeType)]
            if constants and constants[0] == current.__doc__:
                constants = constants[1:]
            digest.update(code.co_code)
            digest.update(repr((constants, code.co_names, code.co_varnames)).encode())
            for used in code.co_names:
                value = current.__globals__.get(used)
                if isinstance(value, _CONSTANTS):
                    digest.update(repr((used, value)).encode())
                elif hasattr(value, "_fields"):  # a kind of named tuple that it makes
                    digest.update(repr((used, value._fields)).encode())
    return digest.hexdigest()


@cache
def compiler_stamp() -> bytes:
    """Hash of the compiler's version, and of the code of this package."""
    digest = hashlib.sha256()
    for name in ("numba", "llvmlite"):
        digest.update(version(name).encode())
    for file in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(file.read_bytes())
    return digest.digest()


def fields_of(example: Any) -> str:
    """Kinds and fields of named tuples among arguments; compiled code has fields by number."""
    if not isinstance(example, tuple):
        return ""
    kind = f"{type(example).__module__}.{type(example).__qualname__}"
    return repr((kind, getattr(example, "_fields", ""), *map(fields_of, example)))
