"""Messages of a recording as JSON Schema, with the names and fields that Foxglove can draw.

Names and fields: https://docs.foxglove.dev/docs/sdk/schemas and, for the ROS messages,
https://docs.ros.org/en/rolling/p/sensor_msgs/msg/JointState.html.
"""

from __future__ import annotations

from typing import Any

Schema = dict[str, Any]
_NUMBER: Schema = {"type": "number"}
_INTEGER: Schema = {"type": "integer"}
_FLAG: Schema = {"type": "boolean"}
_TEXT: Schema = {"type": "string"}
_NANOSECONDS: Schema = {"type": "integer", "minimum": 0, "maximum": 999999999}


def _record(**fields: Schema) -> Schema:
    return {"type": "object", "properties": fields, "required": list(fields)}


def _list(items: Schema) -> Schema:
    return {"type": "array", "items": items}


_TIME = _record(sec={"type": "integer", "minimum": 0}, nsec=_NANOSECONDS)
_XYZ = _record(x=_NUMBER, y=_NUMBER, z=_NUMBER)
_XYZW = _record(x=_NUMBER, y=_NUMBER, z=_NUMBER, w=_NUMBER)
_COLOUR = _record(r=_NUMBER, g=_NUMBER, b=_NUMBER, a=_NUMBER)
_POSE = _record(position=_XYZ, orientation=_XYZW)
_SOLID = _record(pose=_POSE, size=_XYZ, color=_COLOUR)
_CYLINDER = _record(pose=_POSE, size=_XYZ, bottom_scale=_NUMBER, top_scale=_NUMBER, color=_COLOUR)
_CORNERS: dict[str, Schema] = {
    "points": _list(_XYZ),
    "color": _COLOUR,
    "colors": _list(_COLOUR),
    "indices": _list(_INTEGER),
}
_TRIANGLES = _record(pose=_POSE, **_CORNERS)
_LINE = _record(type=_INTEGER, pose=_POSE, thickness=_NUMBER, scale_invariant=_FLAG, **_CORNERS)
_ENTITY = _record(
    timestamp=_TIME,
    frame_id=_TEXT,
    id=_TEXT,
    lifetime=_TIME,
    frame_locked=_FLAG,
    cubes=_list(_SOLID),
    spheres=_list(_SOLID),
    cylinders=_list(_CYLINDER),
    lines=_list(_LINE),
    triangles=_list(_TRIANGLES),
)

_FRAME = _record(
    timestamp=_TIME,
    parent_frame_id=_TEXT,
    child_frame_id=_TEXT,
    translation=_XYZ,
    rotation=_XYZW,
)

SCHEMAS: dict[str, Schema] = {
    "foxglove.FrameTransforms": _record(transforms=_list(_FRAME)),
    "foxglove.PoseInFrame": _record(timestamp=_TIME, frame_id=_TEXT, pose=_POSE),
    "foxglove.SceneUpdate": _record(deletions=_list({"type": "object"}), entities=_list(_ENTITY)),
    "sensor_msgs/JointState": _record(
        header=_record(stamp=_TIME, frame_id=_TEXT),
        name=_list(_TEXT),
        position=_list(_NUMBER),
        velocity=_list(_NUMBER),
        effort=_list(_NUMBER),
    ),
    "std_msgs/String": _record(data=_TEXT),
}
"""JSON Schema of each message, by its name."""
