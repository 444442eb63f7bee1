"""Array types of the package, and read-only arrays."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]
BoolArray = NDArray[np.bool_]
ByteArray = NDArray[np.uint8]

_Array = TypeVar("_Array", bound=NDArray[Any])


def read_only(array: _Array) -> _Array:
    """Lock ``array`` against writing and return it."""
    array.setflags(write=False)
    return array


def flat(array: NDArray[np.float64]) -> FloatArray:
    """Return the numbers of ``array`` flat and read-only, as kernels take them."""
    return read_only(np.ascontiguousarray(array, dtype=np.float64).reshape(-1))
