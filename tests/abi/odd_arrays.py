"""Arrays that are not what a function asks for, or are it in another form."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


def strided(array: Array) -> Array:
    """The values with a gap after each."""
    return np.repeat(array, 2, axis=-1)[..., ::2]


def read_only(array: Array) -> Array:
    """A copy that cannot be written."""
    copy = array.copy()
    copy.setflags(write=False)
    return copy


SAME: dict[str, Callable[[Array], Any]] = {
    "strided": strided,
    "reversed twice": lambda array: array[::-1].copy()[::-1],
    "fortran": np.asfortranarray,
    "big-endian": lambda array: array.astype(array.dtype.newbyteorder(">")),
    "read-only": read_only,
    "list": lambda array: array.tolist(),
}
"""Other forms of the same values."""

EXACT: dict[str, Callable[[Array], Any]] = {
    "float32": lambda array: array.astype(np.float32),
    "integers": lambda array: array.astype(np.int64),
    "short integers": lambda array: array.astype(np.int16),
}
"""Other types of numbers that are whole."""

WRONG: dict[str, Callable[[Array], Any]] = {
    "a dimension less": lambda array: array[0],
    "a dimension more": lambda array: array[None],
    "complex": lambda array: array.astype(complex),
    "text": lambda array: array.astype(str),
    "objects": lambda array: np.full(array.shape, None),
    "None": lambda array: None,
    "ragged": lambda array: [[0.0], [0.0, 1.0]],
}
"""Whatever the function, none of these is what it asks for."""


def widened(array: Array) -> Array:
    """One more column."""
    return np.concatenate([array, array[..., :1]], axis=-1)


def narrowed(array: Array) -> Array:
    """One column less."""
    return array[..., :-1]


def spoilt(array: Array, place: int, value: float) -> Array:
    """The array with one other value."""
    copy = array.copy()
    copy.flat[place % copy.size] = value
    return copy
