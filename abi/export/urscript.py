"""The motion as URScript, for the controllers of Universal Robots."""

from __future__ import annotations

import numpy as np

from abi.arrays import FloatArray
from abi.errors import AbiError
from abi.export.joint_trajectory import joint_trajectory, motion_state
from abi.planner.plan import Plan

JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
"""Joints of every arm of Universal Robots, in the controller's order."""

_PERIOD = 0.008
"""Shortest time between two poses, [s]: a controller's cycle or a few."""
_NOTE = """\
# SAFETY. This program moves a real arm. The plan knows the obstacles of its scene alone: no people,
# cables, tool, payload, or limits set on the robot. Before it runs:
#   1. Read it, and run it in the simulator (URSim) first.
#   2. Check the mounting, the payload and the tool in the installation, and the safety limits.
#   3. Clear the cell. First the arm moves to the first pose in a straight way of its joints,
#      slowly; that way is NOT part of the plan and not checked against anything.
#   4. Begin with the speed slider at 10 % and a hand on the emergency stop.
"""


def write(plan: Plan, name: str) -> bytes:
    """Write a program that moves slowly to the first pose and then follows the motion.

    ``servoj`` gets every sample of the motion, since what is proven is the straight way of the
    joints from one to the next.

    Raises:
        AbiError: the arm is not one of Universal Robots, or cannot execute the motion.
    """
    trajectory = joint_trajectory(plan)
    if trajectory.joints != JOINTS:
        raise AbiError(
            "URScript is for the arms of Universal Robots, and this is another.",
            "Choose the UR5e in stage 6, or arm: {model: urdf, urdf: ur5e} in the scene.",
        )
    duration = float(trajectory.time[-1])
    steps = np.maximum(np.diff(trajectory.time), _PERIOD)
    lines = [
        f"  servoj({_pose(pose)}, t={step:.6f})"
        for pose, step in zip(trajectory.positions[1:], steps.tolist(), strict=True)
    ]
    takes = float(steps.sum())
    first = _pose(trajectory.positions[0])
    slowed = f"slowed down from {duration:.2f} s, " if takes > duration * 1.001 else ""
    state = motion_state(plan).replace("²", "^2").replace("·", "*")  # ASCII, as controllers read
    return "\n".join(
        [
            _NOTE + f"# It takes {takes:.2f} s, {slowed}from pose to pose. {state}",
            "def abi_motion():",
            f"  movej({first}, a=0.5, v=0.2)",
            *lines,
            "  stopj(1.0)",
            "end",
            "",
        ]
    ).encode()


def _pose(positions: FloatArray) -> str:
    return "[" + ", ".join(f"{position:.9f}" for position in positions.tolist()) + "]"
