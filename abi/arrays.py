"""The array types of the package, and how arrays are handed on."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]
BoolArray = NDArray[np.bool_]

_Array = TypeVar("_Array", bound=NDArray[Any])


def read_only(array: _Array) -> _Array:
    """Lock ``array`` against writing and return it, so that a result cannot change later."""
    array.setflags(write=False)
    return array


def flat(array: NDArray[np.float64]) -> FloatArray:
    """The numbers of ``array`` in a row, read-only: the form in which kernels are given them."""
    return read_only(np.ascontiguousarray(array).reshape(-1))
