"""Arguments of public functions, checked before kernels read them.

A kernel takes flat arrays and trusts their lengths and the ids in them. So whatever a caller hands
over passes here once: its shape, type, range and finiteness. What has other strides, byte order or
precision comes back as the kernels take it; what cannot be read as asked raises ArgumentError.
"""

from __future__ import annotations

import math
import operator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from abi.arrays import BoolArray, FloatArray, IntArray, lock
from abi.errors import ArgumentError, Described

_LETTERS = "nmk"
_FLOAT64 = np.dtype(np.float64)
_ONE_THREAD = 8192
"""Most numbers whose squares the linear algebra library sums in the calling thread."""
_EYE = np.eye(3)
_LARGEST = 1.1
"""Bound of a rotation's entries, so that no product of larger ones overflows."""
_RIGID = 1e-6
"""Largest error of a rotation's products, and of a direction's length."""
LARGEST_ID = 2**31 - 1
"""Largest number of an array's entry, and of an order or a degree."""


def numbers(
    name: str, values: ArrayLike, shape: tuple[int, ...], infinite: bool = False
) -> FloatArray:
    """Return an argument as float64 in C order.

    Args:
        name: of the argument.
        values: numbers, an array or nested lists.
        shape: that they must have; -1 for any length.
        infinite: whether infinity is allowed; NaN never is.

    Raises:
        ArgumentError: another shape, no real numbers, or not finite.
    """
    if (
        type(values) is np.ndarray
        and values.dtype is _FLOAT64
        and values.flags.c_contiguous
        and (values.shape == shape or _fits(values.shape, shape))
    ):
        array = values
    else:
        array = _of_shape(name, values, shape, "fiu", "finite numbers")
        array = np.ascontiguousarray(array, dtype=np.float64).reshape(array.shape)
    # the sum of squares is finite only if all numbers are, and is found in a fifth of the time; of
    # many it wakes the threads of the algebra library, which takes milliseconds
    known = array.size <= _ONE_THREAD and math.isfinite(np.vdot(array, array))
    if not known and not _are_finite(array, infinite):
        k = int(np.flatnonzero(~np.isfinite(array.ravel()))[0])
        where = "".join(f"[{i}]" for i in np.unravel_index(k, array.shape))
        raise ArgumentError(f"{name}{where}", float(array.ravel()[k]), "a finite number")
    return array


def increasing(name: str, values: ArrayLike, count: int = -1) -> FloatArray:
    """Return two or more numbers (n,), each above the one before; see :func:`numbers`."""
    array = numbers(name, values, (count,))
    if len(array) < 2 or not np.greater(array[1:], array[:-1]).all():
        raise ArgumentError(name, array.tolist(), "two or more numbers that increase")
    return array


def points(name: str, values: ArrayLike) -> FloatArray:
    """Return points of shape (n, 3) as float64 in C order; see :func:`numbers`."""
    return numbers(name, values, (-1, 3))


def within(
    name: str,
    values: ArrayLike,
    shape: tuple[int, ...],
    low: float,
    high: float,
    infinite: bool = False,
) -> FloatArray:
    """Return numbers from ``low`` to ``high``; see :func:`numbers`."""
    array = numbers(name, values, shape, infinite)
    if array.size and not low <= array.min() <= array.max() <= high:
        wrong = array.min() if array.min() < low else array.max()
        raise ArgumentError(f"one of {name}", float(wrong), f"a number{_range(low, high)}")
    return array


def number_or_numbers(name: str, values: ArrayLike) -> FloatArray:
    """Return an array of any shape, () for one number; see :func:`numbers`."""
    return numbers(name, values, (-1,) * _dimensions(values))


def one_or_each(name: str, values: ArrayLike, count: int, infinite: bool = False) -> FloatArray:
    """Return an array (count,) of one number for all or of one for each; see :func:`numbers`."""
    shape = () if _dimensions(values) == 0 else (count,)
    return np.broadcast_to(numbers(name, values, shape, infinite), (count,))


def polyline(name: str, values: ArrayLike) -> FloatArray:
    """Return vertices (k, 3), k >= 2, of a polyline; a single point is a segment of length 0."""
    vertices = points(name, values)
    if not len(vertices):
        raise ArgumentError(name, [], "one point or more")
    return vertices if len(vertices) > 1 else np.repeat(vertices, 2, axis=0)


def ids(name: str, values: ArrayLike, shape: tuple[int, ...], count: int) -> IntArray:
    """Return whole numbers from 0 up to, not including, ``count`` as int32 in C order.

    Raises:
        ArgumentError: another shape, no integers, or one that is out of range.
    """
    return bits(name, values, shape, 0, count - 1)


def bits(
    name: str,
    values: ArrayLike,
    shape: tuple[int, ...],
    low: int = -LARGEST_ID - 1,
    high: int = LARGEST_ID,
) -> IntArray:
    """Return whole numbers from ``low`` to ``high`` as int32 in C order; see :func:`ids`."""
    array = _of_shape(name, values, shape, "iu", "integers")
    whole_range = (low, high) == (-LARGEST_ID - 1, LARGEST_ID)
    if array.size and not (whole_range and array.dtype == np.int32):
        least, largest = int(array.min()), int(array.max())
        if least < low or largest > high:
            wrong = least if least < low else largest
            raise ArgumentError(f"one of {name}", wrong, f"an integer from {low} to {high}")
    return np.ascontiguousarray(array, dtype=np.int32).reshape(array.shape)


def flags(name: str, values: ArrayLike, shape: tuple[int, ...]) -> BoolArray:
    """Return flags in C order.

    Raises:
        ArgumentError: another shape, or no flags.
    """
    array = _of_shape(name, values, shape, "b", "True and False")
    return np.ascontiguousarray(array, dtype=np.bool_).reshape(array.shape)


def number(
    name: str, value: Any, low: float = -math.inf, high: float = math.inf, infinite: bool = False
) -> float:
    """Return an argument as a number from ``low`` to ``high``.

    Raises:
        ArgumentError: no real number, out of range, or not finite unless that is allowed.
    """
    if type(value) is float and low <= value <= high and abs(value) < math.inf:
        return value
    wanted = ("a number" if infinite else "a finite number") + _range(low, high)
    if isinstance(value, bool | np.bool_ | str | bytes | np.ndarray):
        raise ArgumentError(name, value, wanted)
    try:
        found = float(value)
    except (TypeError, ValueError, OverflowError):
        raise ArgumentError(name, value, wanted) from None
    if not low <= found <= high or (math.isinf(found) and not infinite):
        raise ArgumentError(name, value, wanted)
    return found


def integer(name: str, value: Any, low: int, high: int) -> int:
    """Return an argument as an integer from ``low`` to ``high``.

    Raises:
        ArgumentError: no integer, or out of range.
    """
    if type(value) is int and low <= value <= high:
        return value
    wanted = f"an integer from {low} to {high}"
    if isinstance(value, bool | np.bool_):
        raise ArgumentError(name, value, wanted)
    try:
        found = operator.index(value)
    except TypeError:
        raise ArgumentError(name, value, wanted) from None
    if not low <= found <= high:
        raise ArgumentError(name, value, wanted)
    return found


def rotation(name: str, values: ArrayLike) -> FloatArray:
    """Return a matrix (3, 3) that turns and neither scales nor mirrors; see :func:`numbers`."""
    matrix = numbers(name, values, (3, 3))
    turns = np.abs(matrix).max() < _LARGEST and np.linalg.det(matrix) > 0
    if not (turns and np.abs(matrix @ matrix.T - _EYE).max() < _RIGID):
        raise ArgumentError(name, matrix.round(6).tolist(), "a rotation")
    return matrix


def pose(name: str, values: ArrayLike) -> FloatArray:
    """Return a pose (4, 4): a rotation, a place, and 0, 0, 0, 1 below; see :func:`numbers`."""
    matrix = numbers(name, values, (4, 4))
    rotation(name, matrix[:3, :3])
    if matrix[3].tolist() != [0, 0, 0, 1]:
        raise ArgumentError(f"last row of {name}", matrix[3].tolist(), "0, 0, 0, 1")
    return matrix


def direction(name: str, values: ArrayLike) -> FloatArray:
    """Return a vector (3,) of length 1; see :func:`numbers`."""
    vector = numbers(name, values, (3,))
    if not abs(math.hypot(*vector.tolist()) - 1) < _RIGID:
        raise ArgumentError(name, vector.tolist(), "a vector of length 1")
    return vector


def ranges(name: str, values: ArrayLike, count: int) -> FloatArray:
    """Return lowest and highest of each, (count, 2), in that order; see :func:`numbers`."""
    array = numbers(name, values, (count, 2))
    wrong = np.flatnonzero(array[:, 0] > array[:, 1])
    if len(wrong):
        k = int(wrong[0])
        raise ArgumentError(f"{name}[{k}]", array[k].tolist(), "the lowest and then the highest")
    return array


def keep(owner: object, **fields: object) -> None:
    """Replace fields of a frozen dataclass by what was checked, their arrays read-only.

    Arrays that can be written are copied: they belong to the caller.
    """
    vars(owner).update({name: owned(value) for name, value in fields.items()})


def owned(value: Any) -> Any:
    """Return an array read-only, copied if it is writable; other values unchanged."""
    if isinstance(value, np.ndarray) and value.flags.writeable:
        value = value.copy()
    lock((value,))
    return value


def _of_shape(
    name: str, values: ArrayLike, shape: tuple[int, ...], kinds: str, wanted: str
) -> NDArray[Any]:
    """The argument as an array, if it has the shape and is of one of the kinds of types."""
    try:
        array = np.asarray(values)
    except (TypeError, ValueError, OverflowError):
        expected = f"{wanted} of shape {_text_of(shape)}"
        raise ArgumentError(name, values, expected) from None
    fits = array.shape == shape or _fits(array.shape, shape)
    fits &= not np.ma.is_masked(values)
    # a list without entries has no type of its own
    if not fits or (array.dtype.kind not in kinds and (array.size or array is values)):
        given = Described(f"an array of shape {array.shape} and type {array.dtype}")
        raise ArgumentError(name, given, f"{wanted} of shape {_text_of(shape)}")
    return array


def _are_finite(array: FloatArray, infinite: bool) -> bool:
    """Check whether all numbers are finite, or none is NaN if they may be infinite."""
    return not np.isnan(array).any() if infinite else bool(np.isfinite(array).all())


def _fits(found: tuple[int, ...], shape: tuple[int, ...]) -> bool:
    """Check whether an array's shape is one with -1 for any length."""
    if len(found) != len(shape):
        return False
    # all() of a generator takes thrice as long
    for length, wanted in zip(found, shape, strict=True):  # noqa: SIM110
        if wanted not in (-1, length):
            return False
    return True


def _range(low: float, high: float) -> str:
    """A range as the end of a sentence; empty if there is none."""
    if high < math.inf:
        return f" from {low:g} to {high:g}"
    return f" of at least {low:g}" if low > -math.inf else ""


def _dimensions(values: ArrayLike) -> int:
    """Number of an argument's dimensions; 1 of lists of different lengths, which are refused."""
    try:
        return np.ndim(values)
    except ValueError:
        return 1


def _text_of(shape: tuple[int, ...]) -> str:
    """Text of a shape as in docstrings, with letters for any length."""
    letters = iter(_LETTERS)
    parts = [next(letters) if length == -1 else str(length) for length in shape]
    return f"({', '.join(parts)}{',' * (len(parts) == 1)})"
