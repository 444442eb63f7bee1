"""Array types of the package, read-only arrays, and the base of what holds them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]
BoolArray = NDArray[np.bool_]
ByteArray = NDArray[np.uint8]

_Array = TypeVar("_Array", bound=NDArray[Any])

_FEW, _LONG = 4, 60
"""Most entries and characters of a value that are shown."""


def read_only(array: _Array) -> _Array:
    """Lock ``array`` against writing and return it."""
    array.setflags(write=False)
    return array


def lock(values: Iterable[object]) -> None:
    """Lock arrays against writing, also those in tuples and mappings."""
    for value in values:
        if isinstance(value, np.ndarray):
            read_only(value)
        elif isinstance(value, tuple):
            lock(value)
        elif isinstance(value, Mapping):
            lock(value.values())


def flat(array: NDArray[np.float64]) -> FloatArray:
    """Return the numbers of ``array`` flat and read-only, as kernels take them."""
    return read_only(np.ascontiguousarray(array, dtype=np.float64).reshape(-1))


def clip(values: FloatArray, low: float, high: float) -> FloatArray:
    """Limit ``values`` to ``low``..``high``, ten times faster than ``np.clip``."""
    return np.asarray(np.minimum(np.maximum(values, low), high))


class ShortRepr:
    """Base of dataclasses with arrays: ``repr`` is one line, with the shapes of arrays.

    The arrays of copies are read-only, too, as kernels need them.
    """

    def __repr__(self) -> str:
        """Name of the class and all fields, long values by their size."""
        assert is_dataclass(self)
        shown = (
            f"{one.name}={_brief(getattr(self, one.name))}" for one in fields(self) if one.repr
        )
        return f"{type(self).__name__}({', '.join(shown)})"

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Fill a copy; ``pickle`` and ``copy.deepcopy`` make arrays that can be written."""
        lock(state.values())
        self.__dict__.update(state)


def _brief(value: object) -> str:
    if isinstance(value, np.ndarray):
        return f"array{value.shape}"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, tuple | list | dict) and len(value) > _FEW:
        return f"<{len(value)} entries>"
    if isinstance(value, tuple):
        return f"({', '.join(map(_brief, value))}{',' * (len(value) == 1)})"
    text = "" if isinstance(value, ShortRepr) else repr(value)
    if not text or (len(text) > _LONG and not isinstance(value, str)):
        return f"{type(value).__name__}(…)"
    return text if len(text) <= _LONG else f"{text[:_LONG]}…"
