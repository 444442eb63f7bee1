"""What an arm stands on: obstacles that a plumb line through its base meets.

What stands still on something touches it for good, whatever the joints do; so links that no joint
moves may touch what is beneath the base. An obstacle pushed into the base from the side or from
above is none of that.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.pose import Quaternion, rotation

if TYPE_CHECKING:
    from abi.robot.urdf_arm import UrdfArm

ABOVE, BELOW = 0.02, 0.2
"""Ends of the plumb line: distances from the base's origin, along its z axis and against, [m].

The upper one is outside of what an arm stands on.
"""


def mounts(arm: UrdfArm, obstacles: ObstacleSet) -> tuple[int, ...]:
    """Numbers of the obstacles that an arm stands on."""
    return beneath(np.asarray(arm.base), arm.wxyz, arm.metres, obstacles)


def beneath(
    base: FloatArray, wxyz: Quaternion, metres: float, obstacles: ObstacleSet
) -> tuple[int, ...]:
    """Numbers of the obstacles that a robot stands on.

    Args:
        base: place of its root, (3,), [unit], world.
        wxyz: how that is turned, as a quaternion.
        metres: one [unit] in metres.
        obstacles: the obstacles.
    """
    if not obstacles.obstacles:
        return ()
    up = rotation(wxyz)[:, 2] / metres
    line = np.stack([base + ABOVE * up, base - BELOW * up])
    low, high = obstacles.bounds
    near = (low <= line.max(axis=0)).all(axis=1) & (high >= line.min(axis=0)).all(axis=1)
    return tuple(
        number
        for number in np.flatnonzero(near).tolist()
        if (one := ObstacleSet((obstacles[number],))).signed_distance(line[:1])[0] > 0
        and one.polyline_clearances(line[None])[0] <= 0
    )
