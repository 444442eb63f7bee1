"""Shortcuts in viser 1.1.1, which is slow with unchanged fields and plain data.

A tab sets some two hundred fields for each picture, most of them to the values they have, and viser
looks up the types of each. The bytes that are sent stay the same.
"""

from __future__ import annotations

import functools
from types import NoneType, SimpleNamespace
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray
from viser import _assignable_props_api
from viser.infra import _messages

assert viser.__version__ == "1.1.1", "app/ui/viser_shortcuts.py uses private names of viser 1.1.1"

AnyArray = NDArray[Any]

_PLAIN = (bool, str, float, int)
_UNCHANGED = (bool, str, NoneType)
"""Types that viser sends unchanged, whatever a field is declared as."""
_POSE = ("position", "wxyz")

_set: Any = _assignable_props_api.props_setattr
_prepare: Any = _messages._prepare_for_serialization


def install() -> None:
    """Install the shortcuts; one call suffices."""
    props: Any = _assignable_props_api
    props.AssignablePropsBase.__setattr__ = _set_field
    # viser looks up the types of a handle's fields anew for each handle, most of the time that it
    # takes, and makes three array types for each field that is set, most of the time of that
    props.get_type_hints = functools.cache(props.get_type_hints)
    numbers = (np.float16, np.float32, np.float64, np.uint8)
    props.npt = SimpleNamespace(NDArray={one: NDArray[one] for one in numbers})  # type: ignore[valid-type]
    _messages._prepare_for_serialization = _prepare_field


def _set_field(self: Any, name: str, value: Any) -> None:
    """Set a handle's field, returning at once if it has that value."""
    impl = self.__dict__.get("_impl")
    if impl is not None and not impl.removed and _is_set(self, impl, name, value):
        return
    _set(self, name, value)


def _is_set(handle: Any, impl: Any, name: str, value: Any) -> bool:
    """Check whether a field has that value already."""
    fields = vars(impl.props)
    if name in fields:
        current = fields[name]
        if type(value) in _PLAIN:
            return type(current) is type(value) and bool(current == value)
        if not (type(value) is np.ndarray and type(current) is np.ndarray):
            return False
        if _is_only_field(type(handle), name) and _can_cast(value.dtype, current.dtype):  # type: ignore[arg-type]
            _set_array(handle, name, current, value)
            return True
        # viser is about to write into it, and it may still have to be sent
        fields[name] = current.copy()
        return False
    if name == "value":
        # a button that is not pressed: viser would call all who wait for it
        return value is False and getattr(impl, "value", None) is False
    if name == "visible":
        return getattr(impl, "visible", None) is value
    return name in _POSE and np.array_equal(getattr(impl, name, ()), value)


def _set_array(self: Any, name: str, current: AnyArray, value: AnyArray) -> None:
    """Set a handle's array, returning at once if it has those numbers.

    viser copies what it is given up to four times, as it writes into the array that it has. Here
    that is replaced, so that one copy serves both to be kept and to be sent.
    """
    kept = value.astype(current.dtype)
    if kept.shape == current.shape and (kept == current).all():
        return
    vars(self._impl.props)[name] = kept
    self._queue_update(name, kept)
    self._on_prop_assigned(name)


@functools.cache
def _is_only_field(handle: type, name: str) -> bool:
    """Check whether a handle's attribute of that name is a plain field."""
    return not isinstance(getattr(handle, name, None), property)


@functools.cache
def _can_cast(have: np.dtype[Any], wanted: np.dtype[Any]) -> bool:
    """Check whether numbers can be cast; colours given as fractions cannot."""
    return have == wanted or (have.kind == wanted.kind == "f")


def _prepare_field(value: Any, annotation: object, binary_buffers: Any = None) -> Any:
    """Content of a message's field as it is sent."""
    kind = type(value)
    if kind in _UNCHANGED and annotation is not float and annotation is not int:
        return value
    if kind is float and annotation is not int:
        return value
    if kind is dict:
        return {key: _prepare_field(one, Any, binary_buffers) for key, one in value.items()}
    return _prepare(value, annotation, binary_buffers)
