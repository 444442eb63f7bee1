"""Elements of arrays, read and written with a third of the code that numba makes LLVM go through.

Numba takes any array and index apart into views, of which LLVM leaves nothing where an array has
one dimension and the index is a number. Here nothing else is made from the first, and the machine
code is the same.
"""

from __future__ import annotations

import operator
from typing import Any

from numba.core import types
from numba.np import arrayobj


def access_of(function: Any, signature: Any) -> Any:
    """Numba's implementation of a call for the compiler, if it reads or writes an element.

    Args:
        function: numba's type of what is called, or its name for it.
        signature: types of the call.

    Returns:
        A function that makes the code; None for any other call.
    """
    access = _ACCESS.get(getattr(function, "typing_key", None))
    if access is None or not _is_element(*signature.args[:2]):
        return None
    return access


def _is_element(array: Any, index: Any = None) -> bool:
    """Check whether an array of numbers has one dimension and no gaps, and its index is one."""
    return (
        isinstance(array, types.Array)
        and (array.ndim, array.layout) == (1, "C")
        and isinstance(array.dtype, (types.Integer, types.Float, types.Boolean))
        and (index is None or isinstance(index, types.Integer))
    )


def _read(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    array, index = signature.args
    place = _place(context, builder, array, arguments[0], index, arguments[1])
    return arrayobj.load_item(context, builder, array, place)  # type: ignore[no-untyped-call]


def _write(context: Any, builder: Any, signature: Any, arguments: Any) -> None:
    array, index, kind = signature.args
    place = _place(context, builder, array, arguments[0], index, arguments[1])
    value = context.cast(builder, arguments[2], kind, array.dtype)
    arrayobj.store_item(context, builder, array, value, place)  # type: ignore[no-untyped-call]


def _length(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return _length_of(context, builder, signature.args[0], arguments[0])


def _length_of(context: Any, builder: Any, kind: Any, array: Any) -> Any:
    position = context.data_model_manager[kind].get_field_position("shape")
    return builder.extract_value(array, (position, 0))


def _place(context: Any, builder: Any, kind: Any, array: Any, index_kind: Any, index: Any) -> Any:
    """Pointer to an element; a negative index counts from the end."""
    length = _length_of(context, builder, kind, array)
    number = arrayobj.fix_integer_index(context, builder, index_kind, index, length)  # type: ignore[no-untyped-call]
    position = context.data_model_manager[kind].get_field_position("data")
    return builder.gep(builder.extract_value(array, position), [number])


_ACCESS: dict[Any, Any] = {operator.getitem: _read, operator.setitem: _write, len: _length}
