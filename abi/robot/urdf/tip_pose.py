"""Pose of a robot's tip at joint positions."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from abi.arrays import FloatArray, read_only
from abi.robot.urdf.robot import Robot, joints_to


def tip_pose(robot: Robot, tip: str, positions: Mapping[str, float]) -> FloatArray:
    """Pose of a link in its robot's root, (4, 4), [m].

    Args:
        robot: the robot.
        tip: name of the link.
        positions: of the joints that move it, by their names, [rad] or [m].

    Raises:
        SceneError: there is no such link, or no joint moves it.
    """
    pose = np.eye(4)
    for joint in joints_to(robot, tip):
        pose = pose @ joint.origin
        if joint.kind != "fixed":
            pose = pose @ joint.motion(joint.position(positions[joint.coordinate]))
    return read_only(pose)
