"""Shortcuts in viser 1.1.1, which takes long over what has not changed and what is plain data.

A tab sets some two hundred fields at each picture, most of them to what they are, and viser asks
for the types of each. What is sent stays the same to the byte.
"""

from __future__ import annotations

from types import NoneType
from typing import Any

import numpy as np
import viser
from viser import _assignable_props_api
from viser.infra import _messages

assert viser.__version__ == "1.1.1", "app/viser_shortcuts.py uses private names of viser 1.1.1"

_PLAIN = (bool, str, float, int)
_UNCHANGED = (bool, str, NoneType)
"""Types that viser sends as they are, whatever a field is declared to be."""
_POSE = ("position", "wxyz")

_set: Any = _assignable_props_api.props_setattr
_prepare: Any = _messages._prepare_for_serialization


def install() -> None:
    """Take the shortcuts from now on; once is enough."""
    handle: Any = _assignable_props_api.AssignablePropsBase
    handle.__setattr__ = _set_field
    _messages._prepare_for_serialization = _prepare_field


def _set_field(self: Any, name: str, value: Any) -> None:
    """Set a handle's field; at once where it has that value."""
    impl = self.__dict__.get("_impl")
    if impl is not None and name != "value" and not impl.removed:
        if type(value) in _PLAIN:
            current = vars(impl.props).get(name)
            if type(current) is type(value) and current == value:
                return
        elif name in _POSE and np.array_equal(getattr(impl, name, ()), value):
            return
    _set(self, name, value)


def _prepare_field(value: Any, annotation: object, binary_buffers: Any = None) -> Any:
    """What of a message's field is sent."""
    kind = type(value)
    if kind in _UNCHANGED and annotation is not float and annotation is not int:
        return value
    if kind is float and annotation is not int:
        return value
    if kind is dict:
        return {key: _prepare_field(one, Any, binary_buffers) for key, one in value.items()}
    return _prepare(value, annotation, binary_buffers)
