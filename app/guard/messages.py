"""Messages that a tab may send, with the exact fields of each.

Those that this package reads have a class; of the others, which viser alone reads, only the fields
are checked. Fields are those of viser 1.1.1. Here a number must only be a number, but for the
camera's; whether it makes sense is checked by the panel that reads it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Literal, TypeAlias, Union

import msgspec

MAX_UPLOAD = 50_000_000
"""Bytes of one file."""
MAX_PARTS = 4096
_SHORTEST = 1e-9
"""Shortest viewing direction that a camera may report."""

_Id: TypeAlias = Annotated[str, msgspec.Meta(max_length=64)]
_Name: TypeAlias = Annotated[str, msgspec.Meta(max_length=256)]
_Text: TypeAlias = Annotated[str, msgspec.Meta(max_length=1_000_000)]
_Pixels: TypeAlias = Annotated[float, msgspec.Meta(ge=0, le=100_000)]
_Instance: TypeAlias = Annotated[int, msgspec.Meta(ge=0, le=10_000_000)] | None
_Modifier: TypeAlias = Annotated[str, msgspec.Meta(max_length=32)] | None
_Coordinate: TypeAlias = Annotated[float, msgspec.Meta(ge=-1e15, le=1e15)]
_Place: TypeAlias = tuple[_Coordinate, _Coordinate, _Coordinate]
_Distance: TypeAlias = Annotated[float, msgspec.Meta(ge=0, le=1e15)]
_Turn: TypeAlias = Annotated[float, msgspec.Meta(ge=-1.01, le=1.01)]
_Vec2: TypeAlias = tuple[float, float]
_Vec3: TypeAlias = tuple[float, float, float]
_Quaternion: TypeAlias = tuple[float, float, float, float]


class Message(msgspec.Struct, tag_field="type", forbid_unknown_fields=True, frozen=True):
    """A message that a tab may send; any missing or additional field is refused."""


class CameraMoved(Message, frozen=True, tag="ViewerCameraMessage"):
    """The camera has moved.

    What it sees is computed from these numbers at once, so they must make sense.
    """

    wxyz: tuple[_Turn, _Turn, _Turn, _Turn]
    position: _Place
    fov: Annotated[float, msgspec.Meta(ge=0.01, le=3.1)]
    near: _Distance
    far: _Distance
    image_height: _Pixels
    image_width: _Pixels
    look_at: _Place
    up_direction: _Place

    @property
    def looks_somewhere(self) -> bool:
        """Whether the viewing direction and the upward direction are not zero."""
        distance = math.dist(self.position, self.look_at)
        return distance >= _SHORTEST and math.hypot(*self.up_direction) >= _SHORTEST


class WidgetUpdate(Message, frozen=True, tag="GuiUpdateMessage"):
    """A widget was used; only its value can be set, and what that may be depends on the widget."""

    uuid: _Id
    updates: Annotated[dict[Literal["value"], object], msgspec.Meta(min_length=1)]


class GizmoUpdate(Message, frozen=True, tag="TransformControlsUpdateMessage"):
    """A gizmo was moved."""

    name: _Name
    owner: _Id
    wxyz: _Quaternion
    position: _Vec3


class UploadStart(Message, frozen=True, tag="FileTransferStartUpload"):
    """Announcement of an upload."""

    source_component_uuid: _Id
    transfer_uuid: _Id
    filename: _Name
    mime_type: _Name
    part_count: Annotated[int, msgspec.Meta(ge=0, le=MAX_PARTS)]
    size_bytes: Annotated[int, msgspec.Meta(ge=0, le=MAX_UPLOAD)]


class UploadPart(Message, frozen=True, tag="FileTransferPart"):
    """A part of an upload."""

    source_component_uuid: _Id | None
    transfer_uuid: _Id
    part_index: Annotated[int, msgspec.Meta(ge=0, lt=MAX_PARTS)]
    content: bytes


_CLICK = {
    "ray_origin": _Vec3,
    "ray_direction": _Vec3,
    "modifier": _Modifier,
}
_NODE = {"name": _Name, "owner": _Id}
_CHECKED_ONLY: Mapping[str, Mapping[str, object]] = {
    "TransformControlsDragStartMessage": _NODE,
    "TransformControlsDragEndMessage": _NODE,
    "SceneNodeClickMessage": {
        **_NODE,
        **_CLICK,
        "instance_index": _Instance,
        "screen_pos": _Vec2,
    },
    "ScenePointerMessage": {
        **_CLICK,
        "event_type": Literal["click"],
        "screen_pos": tuple[_Vec2],
    },
    "SceneNodeDragMessage": {
        **_NODE,
        "phase": Literal["start", "update", "end"],
        "instance_index": _Instance,
        "start_position": _Vec3,
        "start_screen_pos": _Vec2,
        "end_position": _Vec3,
        "end_screen_pos": _Vec2,
        "button": Literal["left", "middle", "right"],
        "modifier": _Modifier,
    },
    "CommandTriggerMessage": {"uuid": _Id},
    "LocalStorageGetItemResponseMessage": {
        "value": _Text | None,
        "error": _Name | None,
        "request_uuid": _Id,
    },
    "GetRenderResponseMessage": {"payload": bytes, "render_uuid": _Id},
}
"""Fields of the messages that viser alone reads: hands on a gizmo or in the scene, commands, and
answers to what the server has requested."""

_READ = (CameraMoved, WidgetUpdate, GizmoUpdate, UploadStart, UploadPart)
_DECODER: msgspec.msgpack.Decoder[Message] = msgspec.msgpack.Decoder(
    Union[
        *_READ,
        *(
            msgspec.defstruct(name, tuple(fields.items()), bases=(Message,), frozen=True, tag=name)
            for name, fields in _CHECKED_ONLY.items()
        ),
    ]
)


def decode(frame: bytes | bytearray | memoryview | str) -> Message | None:
    """Decode a frame; None if it is no message that a tab may send."""
    if isinstance(frame, str):
        return None
    try:
        return _DECODER.decode(frame)
    except (msgspec.MsgspecError, ValueError, RecursionError):
        return None
