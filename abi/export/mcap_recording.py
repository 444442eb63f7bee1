"""The motion as an MCAP recording, which Foxglove plays: joints, tool, obstacles and curves.

The format: https://mcap.dev/spec. Lengths in [m]; the motion begins at time 0.
"""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from abi.arrays import FloatArray
from abi.export.joint_trajectory import joint_trajectory, motion_of, motion_state
from abi.export.mcap_schemas import SCHEMAS
from abi.export.solids import Quaternion, Solid, solids
from abi.planner.plan import Plan

_CURVE_POINTS = 200
_UNTURNED: Quaternion = (1.0, 0.0, 0.0, 0.0)
_RED, _BLUE = (0.85, 0.3, 0.2, 0.8), (0.15, 0.4, 0.9, 1.0)


class _Message(NamedTuple):
    topic: str
    schema: str
    time: float
    data: dict[str, Any]


def write(plan: Plan, name: str) -> bytes:
    """The recording, with scene and URDF attached, and as metadata whether the arm is clear.

    Raises:
        ExportError: there is no motion that the arm can execute.
    """
    from mcap.writer import Writer

    motion_of(plan)
    assert plan.arm is not None
    description = plan.arm.description()
    file = io.BytesIO()
    writer = Writer(file)
    writer.start(profile="", library="abi-visualiser")
    attached = {"scene.json": json.dumps(plan.scene.to_dict()), "arm.urdf": description}
    for label, text in attached.items():
        writer.add_attachment(0, 0, label, "text/plain", text.encode())
    writer.add_metadata("arm", {"state": motion_state(plan)})
    schemas, channels = {}, {}
    for topic, schema, time, data in _messages(plan, description):
        if schema not in schemas:
            encoded = json.dumps(SCHEMAS[schema]).encode()
            schemas[schema] = writer.register_schema(schema, "jsonschema", encoded)
        if topic not in channels:
            channels[topic] = writer.register_channel(topic, "json", schemas[schema])
        stamp = round(time * 1e9)
        content = json.dumps(data, allow_nan=False).encode()
        writer.add_message(channels[topic], stamp, content, stamp)
    writer.finish()  # type: ignore[no-untyped-call]
    return file.getvalue()


def _messages(plan: Plan, description: str) -> Iterator[_Message]:
    assert plan.arm is not None
    metres = plan.arm.metres
    yield _Message("/robot_description", "std_msgs/String", 0.0, {"data": description})
    yield _Message("/scene", "foxglove.SceneUpdate", 0.0, _scene(plan))
    base = {
        "timestamp": _stamp(0.0),
        "parent_frame_id": "world",
        "child_frame_id": "base_link",
        "translation": _xyz(plan.arm.base * metres),
        "rotation": _xyzw(_UNTURNED),
    }
    yield _Message("/tf", "foxglove.FrameTransform", 0.0, base)
    trajectory, tool = joint_trajectory(plan), motion_of(plan).tool * metres
    for index, time in enumerate(trajectory.time.tolist()):
        state = {
            "header": {"stamp": _stamp(time), "frame_id": "base_link"},
            "name": list(trajectory.names),
            "position": trajectory.positions[index].tolist(),
            "velocity": trajectory.velocities[index].tolist(),
            "effort": [],
        }
        yield _Message("/joint_states", "sensor_msgs/JointState", time, state)
        pose = _pose(tool[index], _UNTURNED)
        place = {"timestamp": _stamp(time), "frame_id": "world", "pose": pose}
        yield _Message("/tool", "foxglove.PoseInFrame", time, place)


def _scene(plan: Plan) -> dict[str, Any]:
    """Obstacles and the followed curve as one update of the scene."""
    obstacles = solids(plan.scene.obstacles, plan.scene.unit)
    entities = [_entity(f"obstacle {number + 1}", parts) for number, parts in enumerate(obstacles)]
    fit = plan.followed_curve
    if fit is not None and plan.arm is not None:
        parameters = np.linspace(*fit.curve.interval, _CURVE_POINTS)
        line = {
            "type": 0,  # a strip
            "pose": _pose((0.0, 0.0, 0.0), _UNTURNED),
            "thickness": 2.0,
            "scale_invariant": True,
            "points": [_xyz(point) for point in fit.curve(parameters) * plan.arm.metres],
            "color": _colour(_BLUE),
            "colors": [],
            "indices": [],
        }
        entities.append({**_entity("curve", ()), "lines": [line]})
    return {"deletions": [], "entities": entities}


def _entity(label: str, parts: Sequence[Solid]) -> dict[str, Any]:
    return {
        "timestamp": _stamp(0.0),
        "frame_id": "world",
        "id": label,
        "lifetime": _stamp(0.0),
        "frame_locked": False,
        "cubes": [_solid(part) for part in parts if part.kind == "box"],
        "spheres": [_solid(part) for part in parts if part.kind == "sphere"],
        "cylinders": [
            {**_solid(part), "bottom_scale": 1.0, "top_scale": 1.0}
            for part in parts
            if part.kind == "cylinder"
        ],
        "lines": [],
        "triangles": [_triangles(part) for part in parts if part.kind == "mesh"],
    }


def _solid(part: Solid) -> dict[str, Any]:
    pose = _pose(part.position, part.wxyz)
    return {"pose": pose, "size": _xyz(part.size), "color": _colour(_RED)}


def _triangles(part: Solid) -> dict[str, Any]:
    return {
        "pose": _pose(part.position, part.wxyz),
        "points": [_xyz(corner) for corner in part.triangles.reshape(-1, 3)],
        "color": _colour(_RED),
        "colors": [],
        "indices": [],
    }


def _pose(position: Sequence[float] | FloatArray, wxyz: Quaternion) -> dict[str, Any]:
    return {"position": _xyz(position), "orientation": _xyzw(wxyz)}


def _xyz(vector: Sequence[float] | FloatArray) -> dict[str, float]:
    return dict(zip("xyz", map(float, vector), strict=True))


def _xyzw(wxyz: Quaternion) -> dict[str, float]:
    return dict(zip("wxyz", wxyz, strict=True))


def _colour(rgba: tuple[float, float, float, float]) -> dict[str, float]:
    return dict(zip("rgba", rgba, strict=True))


def _stamp(time: float) -> dict[str, int]:
    seconds, nanoseconds = divmod(round(time * 1e9), 10**9)
    return {"sec": seconds, "nsec": nanoseconds}
