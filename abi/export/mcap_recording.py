"""The motion as an MCAP recording, which Foxglove plays: joints, tool, obstacles and curves.

The format: https://mcap.dev/spec. Lengths in [m]; the motion begins at time 0.
"""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Sequence
from typing import Literal

import numpy as np

from abi.export.carried_objects import carried_objects, chains_of_legs
from abi.export.joint_trajectory import joint_trajectory, motion_of, motion_state
from abi.export.mcap_arm import (
    Frames,
    joint_states,
    link_entities,
    link_frames,
    quaternions,
    scene_frame,
)
from abi.export.mcap_entities import (
    Part,
    by_kind,
    by_letter,
    entity,
    line,
    pose_of,
    solid,
    stamp,
    triangles,
)
from abi.export.mcap_schemas import SCHEMAS
from abi.export.solids import Solid, solids
from abi.obstacles.obstacle_set import Obstacle
from abi.planner.plan import Plan
from abi.robot.urdf.robot_files import packed

_CURVE_POINTS = 200
_RED, _BLUE = (0.85, 0.3, 0.2, 0.8), (0.15, 0.4, 0.9, 1.0)
_NO_FACES = np.empty((0, 3), dtype=np.int32)

_TOPICS = {
    "/robot_description": "std_msgs/String",
    "/scene": "foxglove.SceneUpdate",
    "/arm": "foxglove.SceneUpdate",
    "/tf_static": "foxglove.FrameTransforms",
    "/joint_states": "sensor_msgs/JointState",
    "/tf": "foxglove.FrameTransforms",
    "/tool": "foxglove.PoseInFrame",
}
"""Schema of each topic's messages."""


def write(plan: Plan, name: str) -> bytes:
    """The recording, with scene and arm attached, and as metadata whether the arm is clear.

    Raises:
        AbiError: there is no motion that the arm can execute.
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
    if len(files := plan.arm.files()) > 1:  # its meshes, too
        writer.add_attachment(0, 0, "arm.zip", "application/zip", packed(files))
    writer.add_metadata("arm", {"state": motion_state(plan)})
    schemas = {
        kind: writer.register_schema(kind, "jsonschema", json.dumps(schema).encode())
        for kind, schema in SCHEMAS.items()
    }
    channels = {
        topic: writer.register_channel(topic, "json", schemas[kind])
        for topic, kind in _TOPICS.items()
    }
    for topic, time, data in _messages(plan, description):
        moment = round(time * 1e9)
        content = json.dumps(data, allow_nan=False).encode()
        writer.add_message(channels[topic], moment, content, moment)
    writer.finish()  # type: ignore[no-untyped-call]
    return file.getvalue()


def _messages(plan: Plan, description: str) -> Iterator[tuple[str, float, Part]]:
    """Topic, time [s] and fields of each message."""
    assert plan.arm is not None
    chain = plan.arm.chain
    frame, root = scene_frame(chain), chain.robot.root
    trajectory, tool = joint_trajectory(plan), motion_of(plan).tool * plan.arm.metres
    turns = quaternions(chain.poses(trajectory.positions)[:, -1, :, :3]).tolist()
    legs = chains_of_legs(plan)
    states = joint_states(trajectory, legs)
    still, moving = link_frames(chain, trajectory.positions, legs)
    yield "/robot_description", 0.0, {"data": description}
    yield "/scene", 0.0, _scene(plan, frame)
    yield "/arm", 0.0, link_entities(chain)
    yield from _carried(plan, frame)
    # a topic of their own: where one seeks, only the last message of a topic counts
    yield "/tf_static", 0.0, _transforms(still, 0, 0.0)
    for index, time in enumerate(trajectory.time.tolist()):
        state = {"header": {"stamp": stamp(time), "frame_id": root}, **states[index]}
        yield "/joint_states", time, state
        yield "/tf", time, _transforms(moving, index, time)
        w, x, y, z = turns[index]
        pose = pose_of(tool[index], (w, x, y, z))
        place = {"timestamp": stamp(time), "frame_id": frame, "pose": pose}
        yield "/tool", time, place


def _transforms(frames: Frames, sample: int, time: float) -> Part:
    return {
        "transforms": [
            {
                "timestamp": stamp(time),
                "parent_frame_id": parent,
                "child_frame_id": child,
                "translation": by_letter("xyz", poses[sample, :3]),
                "rotation": by_letter("wxyz", poses[sample, 3:]),
            }
            for (parent, child), poses in frames.items()
        ]
    }


def _scene(plan: Plan, frame: str) -> Part:
    """Obstacles and the followed curve as one update of the scene."""
    obstacles = solids(plan.scene.obstacles, plan.scene.unit)
    entities = [_obstacle(number, frame, parts) for number, parts in enumerate(obstacles)]
    fit = plan.followed_curve
    if fit is not None and plan.arm is not None:
        points = fit.curve(np.linspace(*fit.curve.interval, _CURVE_POINTS)) * plan.arm.metres
        entities.append(entity("curve", frame, by_kind([line(points, _BLUE)])))
    return {"deletions": [], "entities": entities}


def _carried(plan: Plan, frame: str) -> Iterator[tuple[str, float, Part]]:
    """Updates of the scene in which an obstacle moves with the tip, or stands still again."""
    time = motion_of(plan).time
    for one in carried_objects(plan):
        moves = [(one.first, one.arm.tip, one.shape)] if one.is_taken else []
        moves += [(one.last, frame, one.left)] if one.left is not None else []
        for sample, where, shape in moves:
            yield _moved(float(time[sample]), one.number, where, shape, plan.scene.unit)


def _moved(
    time: float, number: int, frame: str, shape: Obstacle, unit: Literal["m", "cm", "mm"]
) -> tuple[str, float, Part]:
    """An update of the scene in which an obstacle is in another frame from a time on, [s]."""
    (parts,) = solids((shape,), unit)
    update = {"deletions": [], "entities": [_obstacle(number, frame, parts)]}
    return "/scene", time, update


def _obstacle(number: int, frame: str, parts: Sequence[Solid]) -> Part:
    return entity(f"obstacle {number + 1}", frame, by_kind([_part(one) for one in parts]))


def _part(part: Solid) -> tuple[str, Part]:
    pose = pose_of(part.position, part.wxyz)
    if part.kind == "mesh":
        return triangles(part.triangles.reshape(-1, 3), _NO_FACES, pose, [_RED])
    return solid(part.kind, part.size, pose, _RED)
