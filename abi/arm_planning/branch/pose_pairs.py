"""Pairs of start and goal poses that a motion with redundant joints may connect."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from abi.arrays import FloatArray
from abi.robot.kinematics.start_poses import REACHED
from abi.robot.urdf_arm import UrdfArm

_MOST = 8
"""Most pairs."""
_FIRSTS, _HOMES = 8, 4
"""Most start poses, and most goal poses for each, that are compared."""
_POINTS = 41
"""Points of the straight line at which pairs are compared."""


PosePair = tuple[int, int | None]
"""Number of a start pose, from 0, and of the pose at the goal towards which redundant joints drift;
None for the start pose itself."""


def pose_pairs(
    arm: UrdfArm,
    line: tuple[FloatArray, FloatArray],
    firsts: Mapping[int, FloatArray],
    lasts: Mapping[int, FloatArray],
    is_clear: Callable[[FloatArray], bool],
) -> list[PosePair]:
    """The most promising pairs, the best first, at most eight.

    First come pairs that are clear at all of a few points of the straight line to the goal, then
    those that are clear at its end; among equals, those whose poses are near each other.

    Args:
        arm: the arm.
        line: start and goal, (3,) each, [unit], world.
        firsts: poses (n,) with the tool at the start, by their numbers.
        lasts: those at the goal.
        is_clear: tells whether the arm is clear in a pose.
    """
    way = np.linspace(*line, _POINTS)
    found: list[tuple[tuple[int, float], PosePair]] = []
    for first, pose in [*firsts.items()][:_FIRSTS]:
        apart = {k: float(np.abs((home - pose) / arm.scales).max()) for k, home in lasts.items()}
        near = sorted(apart, key=lambda k: apart[k])[:_HOMES]
        homes: list[tuple[float, int | None, FloatArray]] = [(0.0, None, pose)]
        homes += [(apart[k], k, lasts[k]) for k in near]
        for distance, number, home in homes:
            positions, missed = arm.follow(pose, way, home)
            reached = bool((missed <= REACHED * arm.reach).all())
            at_end = reached and is_clear(positions[-1])
            whole = at_end and all(is_clear(one) for one in positions[1:-1:5])
            found.append(((2 - at_end - whole, distance), (first, number)))
    found.sort(key=lambda one: one[0])
    return [pair for _, pair in found[:_MOST]]
