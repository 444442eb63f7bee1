"""Messages between the server and the process that reads files: plain data that a class describes.

An array is sent as its shape and its bytes; the class, not the message, says of which numbers it
is. So nothing in a file can make the server run code.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, get_args, get_origin

import msgspec
import numpy as np

from abi.arrays import read_only

_Message = TypeVar("_Message")


def encode(message: object) -> bytes:
    """A message as bytes."""
    return msgspec.msgpack.encode(message, enc_hook=_plain)


def decode(content: bytes, kind: type[_Message]) -> _Message:
    """A message of a kind, checked as its classes check what they are made of.

    Raises:
        msgspec.ValidationError: it is of another kind.
    """
    return msgspec.msgpack.decode(content, type=kind, dec_hook=_decoded)


def _plain(value: object) -> object:
    """Plain data for an array, or a view of a mapping."""
    if isinstance(value, np.ndarray):
        return value.shape, np.ascontiguousarray(value).tobytes()
    if isinstance(value, Mapping):
        return dict(value)
    raise NotImplementedError(type(value).__name__)


def _decoded(kind: Any, value: Any) -> Any:
    """An array of the numbers that its type tells of."""
    if get_origin(kind) is not np.ndarray:
        raise NotImplementedError(kind)
    (number,) = get_args(get_args(kind)[1])
    shape, content = value
    return read_only(np.frombuffer(content, number).reshape(shape))
