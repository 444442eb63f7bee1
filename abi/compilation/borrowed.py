"""Arrays that compiled code borrows, without counting references to them.

Numba counts the references to each array of a tuple at every call that it does not inline, and
counts atomically. Where tables of a dozen arrays go through millions of small functions that takes
most of the time. Whoever calls a kernel or a helper holds its arguments until it returns, so
meanwhile nothing needs to be counted. :mod:`abi.compilation.borrowing` tells numba so. What a
helper makes of its arguments and returns must not outlive them.
"""

from __future__ import annotations

from typing import TypeVar

from abi.compilation.jitable import jitable

_T = TypeVar("_T")


def borrowed(value: _T) -> _T:
    """Lend an array, or a tuple of arrays, to compiled code without counting references to it.

    It must not be returned to Python, and its owner must outlive it; see :func:`held`.
    """
    return value


@jitable
def held(_: object) -> None:
    """Keep a value alive up to here: numba frees a variable after the last line that names it."""
