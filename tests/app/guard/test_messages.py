"""Only what viser's page sends is let through, with the fields that viser reads."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from viser import _messages
from viser.infra import _messages as infra

from app.guard import messages
from benchmarks.web_tab import CAMERA

EXAMPLES: tuple[dict[str, Any], ...] = (
    CAMERA,
    {"type": "GuiUpdateMessage", "uuid": "a", "updates": {"value": [1, 2]}},
    {
        "type": "TransformControlsUpdateMessage",
        "name": "/a",
        "wxyz": [1, 0, 0, 0],
        "position": [1.5, float("nan"), 0],
        "owner": "3",
    },
    {"type": "TransformControlsDragStartMessage", "name": "/a", "owner": ""},
    {"type": "TransformControlsDragEndMessage", "name": "/a", "owner": ""},
    {
        "type": "SceneNodeClickMessage",
        "name": "/a",
        "instance_index": None,
        "ray_origin": [0, 0, 0],
        "ray_direction": [0, 0, 1],
        "screen_pos": [0.5, 0.5],
        "modifier": None,
        "owner": "",
    },
    {
        "type": "ScenePointerMessage",
        "event_type": "click",
        "ray_origin": [0, 0, 0],
        "ray_direction": [0, 0, 1],
        "screen_pos": [[0.5, 0.5]],
        "modifier": None,
    },
    {
        "type": "SceneNodeDragMessage",
        "phase": "update",
        "name": "/a",
        "instance_index": None,
        "start_position": [0, 0, 0],
        "start_screen_pos": [0.5, 0.5],
        "end_position": [0, 0, float("inf")],
        "end_screen_pos": [0.5, 0.6],
        "button": "left",
        "modifier": None,
        "owner": "",
    },
    {
        "type": "FileTransferStartUpload",
        "source_component_uuid": "a",
        "transfer_uuid": "b",
        "filename": "scene.yaml",
        "mime_type": "",
        "part_count": 1,
        "size_bytes": 3,
    },
    {
        "type": "FileTransferPart",
        "source_component_uuid": None,
        "transfer_uuid": "b",
        "part_index": 0,
        "content": b"abc",
    },
    {"type": "CommandTriggerMessage", "uuid": "a"},
    {
        "type": "LocalStorageGetItemResponseMessage",
        "value": "a",
        "error": None,
        "request_uuid": "b",
    },
    {"type": "GetRenderResponseMessage", "payload": b"a", "render_uuid": "b"},
)
PLAIN = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**63), 2**64 - 1)
    | st.floats()
    | st.text(max_size=5),
    lambda part: (
        st.lists(part, max_size=4) | st.dictionaries(st.text(max_size=5), part, max_size=3)
    ),
    max_leaves=5,
)


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: str(example["type"]))
def test_each_message_has_the_fields_that_viser_reads(example: dict[str, Any]) -> None:
    frame = msgspec.msgpack.encode(example)
    decoded = messages.decode(frame)
    assert decoded is not None

    kind = getattr(_messages, example["type"])
    assert set(decoded.__struct_fields__) == set(infra.wire_field_names(kind))
    assert isinstance(_messages.Message.deserialize(frame), kind)

    for field in set(example) - {"type"}:
        assert messages.decode(_without(example, field)) is None
    assert messages.decode(msgspec.msgpack.encode({**example, "more": 1})) is None
    assert messages.decode(frame[:-1]) is None
    assert messages.decode(frame + b"\x00") is None


@given(st.sampled_from(EXAMPLES), st.data(), PLAIN)
def test_what_passes_with_any_field_replaced_viser_can_read(
    example: dict[str, Any], data: st.DataObject, value: object
) -> None:
    field = data.draw(st.sampled_from(sorted(set(example) - {"type"})))
    frame = msgspec.msgpack.encode({**example, field: value})
    if messages.decode(frame) is not None:
        _messages.Message.deserialize(frame)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("position", [1e30, 0, 0]),
        ("position", [float("nan"), 0, 0]),
        ("look_at", [0, 0, float("-inf")]),
        ("up_direction", [0, 1e16, 0]),
        ("wxyz", [2, 0, 0, 0]),
        ("fov", 0.0),
        ("fov", float("nan")),
        ("fov", 3.2),
        ("near", float("nan")),
        ("far", float("inf")),
    ],
)
def test_a_camera_that_sees_nothing_is_refused(field: str, value: object) -> None:
    assert messages.decode(msgspec.msgpack.encode({**CAMERA, field: value})) is None


@pytest.mark.parametrize(
    ("changes", "somewhere"),
    [
        ({}, True),
        ({"position": CAMERA["look_at"]}, False),
        ({"up_direction": [0, 0, 1e-320]}, False),
        ({"up_direction": [0, 0, 0]}, False),
        ({"position": [0, 0, 1e-300], "look_at": [0, 0, 0]}, False),
    ],
)
def test_a_camera_has_a_direction_and_an_upward_one(
    changes: dict[str, Any], somewhere: bool
) -> None:
    camera = messages.decode(msgspec.msgpack.encode({**CAMERA, **changes}))
    assert isinstance(camera, messages.CameraMoved)
    assert camera.looks_somewhere is somewhere


@given(st.binary(max_size=60) | st.builds(msgspec.msgpack.encode, PLAIN))
def test_noise_is_refused(frame: bytes) -> None:
    assert messages.decode(frame) is None


@pytest.mark.parametrize(
    "frame",
    [
        "text",
        b"",
        b"\x91" * 100_000,
        msgspec.msgpack.encode({"type": "ShareUrlRequest"}),
        msgspec.msgpack.encode({"type": "GuiFormDirtyMessage", "uuid": "a"}),
        msgspec.msgpack.encode({"type": ["GuiUpdateMessage"]}),
        msgspec.msgpack.encode(
            {"type": "GuiUpdateMessage", "uuid": "a", "updates": {"value": 1, "removed": True}}
        ),
        msgspec.msgpack.encode(
            {"type": "GuiUpdateMessage", "uuid": "a", "updates": {"update_cb": []}}
        ),
        msgspec.msgpack.encode({"type": "CommandTriggerMessage", "uuid": "a" * 65}),
    ],
)
def test_known_attacks_are_refused(frame: bytes | str) -> None:
    assert messages.decode(frame) is None


def _without(example: dict[str, Any], field: str) -> bytes:
    return msgspec.msgpack.encode({key: example[key] for key in example if key != field})
