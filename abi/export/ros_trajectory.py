"""The motion as a ROS 2 message ``trajectory_msgs/msg/JointTrajectory``, in YAML or JSON.

``ros2 topic pub --once TOPIC trajectory_msgs/msg/JointTrajectory "$(cat FILE)"`` sends it.
Definition: https://docs.ros.org/en/rolling/p/trajectory_msgs/msg/JointTrajectory.html
"""

from __future__ import annotations

import json
import math
from typing import Any

from abi.export.joint_trajectory import JointTrajectory, is_marked, joint_trajectory, motion_state
from abi.planner.plan import Plan
from abi.scene.scene_file import yaml_text


def write(plan: Plan, name: str) -> bytes:
    """The message; JSON where ``name`` ends so, else YAML. Lengths in [m].

    YAML says in a comment whether the arm is clear. JSON has no comments: there a motion that is
    not has a field more, so that a program that takes nothing but the message refuses it.

    Raises:
        ExportError: there is no motion that the arm can execute.
    """
    trajectory = joint_trajectory(plan)
    assert plan.arm is not None
    message = trajectory_message(trajectory, plan.arm.root)
    if name.lower().endswith(".json"):
        if is_marked(plan):
            message = {"state": motion_state(plan), **message}
        return (json.dumps(message, indent=1, allow_nan=False) + "\n").encode()
    return f"# {motion_state(plan)}\n{yaml_text(message, width=4096)}".encode()


def trajectory_message(trajectory: JointTrajectory, frame: str) -> dict[str, Any]:
    """The message's fields; ``frame`` is the name of the arm's root."""
    rows = zip(
        trajectory.positions.tolist(),
        trajectory.velocities.tolist(),
        trajectory.accelerations.tolist(),
        trajectory.time.tolist(),
        strict=True,
    )
    return {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": frame},
        "joint_names": list(trajectory.names),
        "points": [
            {
                "positions": positions,
                "velocities": velocities,
                "accelerations": accelerations,
                "effort": [],
                "time_from_start": duration(time),
            }
            for positions, velocities, accelerations, time in rows
        ],
    }


def duration(time: float) -> dict[str, int]:
    """A time [s] as ``builtin_interfaces/msg/Duration``: whole seconds and nanoseconds."""
    nanoseconds = round(math.fmod(time, 1.0) * 1e9)
    return {"sec": int(time) + nanoseconds // 10**9, "nanosec": nanoseconds % 10**9}
