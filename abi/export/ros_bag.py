"""The motion as a ROS 2 bag in one MCAP file, for ``ros2 bag play`` and programs that read bags.

Messages are encoded in CDR, with their definitions: https://mcap.dev/spec/registry#ros2. Lengths in
[m]; the motion begins at time 0.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import Any

from abi.export.carried_objects import chains_of_legs
from abi.export.joint_trajectory import joint_trajectory, motion_of
from abi.export.mcap_arm import Frames, joint_states, link_frames, quaternions, scene_frame
from abi.export.ros_definitions import DEFINITIONS
from abi.export.ros_trajectory import message_state, trajectory_message
from abi.obstacles.pose import METRES
from abi.planner.plan import Plan

_Message = dict[str, Any]

_TOPICS = {
    "/robot_description": "std_msgs/msg/String",
    "/joint_trajectory": "trajectory_msgs/msg/JointTrajectory",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/joint_states": "sensor_msgs/msg/JointState",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/tool": "geometry_msgs/msg/PoseStamped",
}
"""Kind of each topic's messages."""


def write(plan: Plan, name: str) -> bytes:
    """The bag, whose metadata say whether the arm is clear.

    Raises:
        AbiError: there is no motion that the arm can execute.
    """
    from mcap_ros2.writer import Writer  # here, since few need it

    motion_of(plan)
    file = io.BytesIO()
    writer = Writer(file)
    messages = list(_messages(plan))
    message = next(data for topic, _, data in messages if topic == "/joint_trajectory")
    writer.add_metadata("arm", {"state": message_state(plan, message)})
    schemas = {kind: writer.register_msgdef(kind, text) for kind, text in DEFINITIONS.items()}
    for topic, time, data in messages:
        writer.write_message(topic, schemas[_TOPICS[topic]], data, round(time * 1e9))
    writer.finish()  # type: ignore[no-untyped-call]
    return file.getvalue()


def _messages(plan: Plan) -> Iterator[tuple[str, float, _Message]]:
    """Topic, time [s] and fields of each message."""
    assert plan.arm is not None
    chain, trajectory = plan.arm.chain, joint_trajectory(plan)
    frame, root = scene_frame(chain), chain.robot.root
    tool = (motion_of(plan).tool * METRES[plan.scene.unit]).tolist()
    turns = quaternions(chain.poses(trajectory.positions)[:, -1, :, :3]).tolist()
    legs = chains_of_legs(plan)
    states = joint_states(trajectory, legs)
    still, moving = link_frames(chain, trajectory.positions, legs)
    text = {"data": plan.arm.description()}
    yield "/robot_description", 0.0, text
    yield "/joint_trajectory", 0.0, trajectory_message(plan)
    yield "/tf_static", 0.0, _transforms(still, 0, 0.0)
    for index, time in enumerate(trajectory.time.tolist()):
        state = {"header": _header(time, root), **states[index]}
        yield "/joint_states", time, state
        yield "/tf", time, _transforms(moving, index, time)
        pose = {"position": _xyz(tool[index]), "orientation": _wxyz(turns[index])}
        place = {"header": _header(time, frame), "pose": pose}
        yield "/tool", time, place


def _transforms(frames: Frames, sample: int, time: float) -> _Message:
    return {
        "transforms": [
            {
                "header": _header(time, parent),
                "child_frame_id": child,
                "transform": {
                    "translation": _xyz(poses[sample, :3].tolist()),
                    "rotation": _wxyz(poses[sample, 3:].tolist()),
                },
            }
            for (parent, child), poses in frames.items()
        ]
    }


def _header(time: float, frame: str) -> _Message:
    seconds, nanoseconds = divmod(round(time * 1e9), 10**9)
    return {"stamp": {"sec": seconds, "nanosec": nanoseconds}, "frame_id": frame}


def _xyz(numbers: list[float]) -> _Message:
    return dict(zip("xyz", numbers, strict=True))


def _wxyz(numbers: list[float]) -> _Message:
    return dict(zip("wxyz", numbers, strict=True))
