"""Arrays as lists, which kernels read faster than arrays while they run as Python."""

from __future__ import annotations

import weakref
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from abi.arrays import FloatArray, IntArray
from abi.compilation.jitable import called_as, jitable

_T = TypeVar("_T")


def as_lists(value: Any) -> Any:
    """The value with arrays as lists, in tuples too.

    A kind of named tuple can have a method ``plain`` that returns itself like this, for less.
    """
    if isinstance(value, np.ndarray):
        return value.tolist()
    if not isinstance(value, tuple):
        return value
    return value.plain() if hasattr(value, "plain") else fields_as_lists(value)


def fields_as_lists(value: Any) -> Any:
    """A tuple with arrays among its fields as lists."""
    inner = map(as_lists, value)
    return type(value)(*inner) if hasattr(value, "_fields") else tuple(inner)


def _list_of_numbers(count: int) -> Any:
    return [0.0] * count


@jitable
@called_as(_list_of_numbers)
def numbers(count: int) -> FloatArray:
    """Room for so many numbers that a kernel works with, and does not return; as Python a list."""
    return np.empty(count)


def _list_of_zeros(count: int) -> Any:
    return [0] * count


@jitable
@called_as(_list_of_zeros)
def zeros(count: int) -> IntArray:
    """So many whole numbers, 0 at first, as for :func:`numbers`."""
    return np.zeros(count, np.int32)


_KEPT: dict[int, dict[int, Any]] = {}


def kept_lists(owner: NDArray[Any], part: int, value: _T) -> _T:
    """A tuple of large arrays that never change, as lists that are made once.

    Args:
        owner: an array as long as which the lists are kept.
        part: number of the tuple among those of that array.
        value: the tuple.
    """
    of_owner = _KEPT.get(id(owner))
    if of_owner is None:
        of_owner = _KEPT[id(owner)] = {}
        weakref.finalize(owner, _KEPT.pop, id(owner), None).atexit = False
    if part not in of_owner:
        of_owner[part] = fields_as_lists(value)
    lists: _T = of_owner[part]
    return lists
