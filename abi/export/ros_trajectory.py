"""The motion as a ROS 2 message ``trajectory_msgs/msg/JointTrajectory``, in YAML or JSON.

``ros2 topic pub --once TOPIC trajectory_msgs/msg/JointTrajectory "$(cat FILE)"`` sends it.
Definition: https://docs.ros.org/en/rolling/p/trajectory_msgs/msg/JointTrajectory.html
"""

from __future__ import annotations

import json
import math
from typing import Any

from abi.export.between_points import growth_warning, polynomials_are_clear
from abi.export.joint_trajectory import (
    holding,
    is_marked,
    is_proven,
    joint_trajectory,
    motion_state,
)
from abi.planner.plan import Plan
from abi.scene.scene_file import yaml_text

_STRAIGHT = (
    "The proof is of straight ways of the joints between the points: they have no velocities, with "
    "which a controller would go another way."
)


def write(plan: Plan, name: str) -> bytes:
    """The message; JSON where ``name`` ends so, else YAML. Lengths in [m].

    YAML says in a comment whether the arm is clear, what it holds, and which limits controllers
    pass between the points. JSON has no comments: there a motion that is not clear, passes limits
    itself, or holds something, has a field more, so that a program that takes nothing but the
    message refuses it.

    Raises:
        AbiError: there is no motion that the arm can execute.
    """
    message = trajectory_message(plan)
    state = message_state(plan, message)
    if name.lower().endswith(".json"):
        if is_marked(plan) or holding(plan):
            message = {"state": state, **message}
        return (json.dumps(message, indent=1, allow_nan=False) + "\n").encode()
    return f"# {state}\n{yaml_text(message, width=4096)}".encode()


def message_state(plan: Plan, message: dict[str, Any]) -> str:
    """Sentences on the motion and its message.

    Args:
        plan: with the motion.
        message: of :func:`trajectory_message`.
    """
    if not message["points"][0]["velocities"]:
        return f"{motion_state(plan)} {_STRAIGHT}"
    return " ".join(filter(None, [motion_state(plan), growth_warning(plan)]))


def trajectory_message(plan: Plan) -> dict[str, Any]:
    """The message's fields.

    Its points have no velocities and accelerations where the polynomials that a controller makes of
    them are not proven clear, but the straight way of the joints between the points is.

    Raises:
        AbiError: there is no motion that the arm can execute.
    """
    trajectory = joint_trajectory(plan)
    assert plan.arm is not None
    is_straight = is_proven(plan) and not polynomials_are_clear(plan)
    rows = zip(
        trajectory.positions.tolist(),
        trajectory.joint_velocities.tolist(),
        trajectory.joint_accelerations.tolist(),
        trajectory.time.tolist(),
        strict=True,
    )
    return {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": plan.arm.root},
        "joint_names": list(trajectory.joints),
        "points": [
            {
                "positions": positions,
                "velocities": [] if is_straight else velocities,
                "accelerations": [] if is_straight else accelerations,
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
