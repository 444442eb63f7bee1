"""How well the tool keeps a direction during a part of a motion."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abi.arm_planning.joint_search.held_direction import AT_RISK, HeldDirection
from abi.arm_planning.motion.trajectory import ArmMotion
from abi.obstacles.pose import Vec3
from abi.robot.any_arm import AnyArm

EXACTLY = 0.01
"""Angle within which a direction that is held exactly at samples is proven to be between them, too,
if the joints turn little enough from one to the next, [rad]."""


class HeldSpan(NamedTuple):
    """How well a direction is kept during a part of a motion.

    Attributes:
        first: when the part begins, [s].
        last: when it ends, [s].
        angle: largest angle that is measured at samples, [rad].
        bound: largest that is possible between them, too, [rad].
        tolerance: largest that is asked for, or is claimed where it is held exactly, [rad].
    """

    first: float
    last: float
    angle: float
    bound: float
    tolerance: float

    def later(self, by: float) -> HeldSpan:
        """The span in a motion that begins that much later, [s]."""
        return self._replace(first=self.first + by, last=self.last + by)


def held_span(hold: HeldDirection, motion: ArmMotion) -> HeldSpan:
    """How well a motion keeps a direction."""
    inside = motion.positions[hold.rows(len(motion.time))]
    duration = float(motion.time[-1])
    return HeldSpan(
        first=hold.begin * duration,
        last=hold.end * duration,
        angle=float(hold.angles(inside).max()),
        bound=float(hold.largest_angles(inside).max()),
        tolerance=hold.tolerance,
    )


def exact_span(arm: AnyArm, direction: Vec3, motion: ArmMotion) -> HeldSpan:
    """How well a direction is kept that is held exactly at the samples of a motion.

    Args:
        arm: the arm.
        direction: of the tip's z axis, not zero, world.
        motion: the motion.
    """
    span = held_span(HeldDirection(arm, np.array(direction), EXACTLY), motion)
    return span._replace(tolerance=max(EXACTLY, span.bound / AT_RISK))
