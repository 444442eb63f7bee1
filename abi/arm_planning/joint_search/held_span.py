"""The part of a motion during which the tool keeps a direction."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from abi import arguments
from abi.arm_planning.joint_search.held_direction import AT_RISK, HeldDirection
from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arrays import FloatArray, ShortRepr
from abi.obstacles.pose import Vec3
from abi.robot.any_arm import AnyArm
from abi.scene.held_axis import HeldAxis

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


def exact_span(arm: AnyArm, direction: Vec3, motion: ArmMotion) -> HeldSpan:
    """How well a direction is kept that is held exactly at the samples of a motion.

    Args:
        arm: the arm.
        direction: of the tip's z axis, not zero, world.
        motion: the motion.
    """
    hold = HeldDirection(arm, np.array(direction), EXACTLY)
    span = HeldPart(hold, 0.0, 1.0).span(motion)
    return span._replace(tolerance=max(EXACTLY, span.bound / AT_RISK))


@dataclass(frozen=True, eq=False, repr=False)
class HeldPart(ShortRepr):
    """A direction, and the part of a motion that keeps it.

    Attributes:
        hold: the direction.
        begin: where the part begins, as a share of the motion's time.
        end: where it ends, above that.
    """

    hold: HeldDirection
    begin: float
    end: float

    def __post_init__(self) -> None:
        begin = arguments.number("begin", self.begin, 0.0, 1.0)
        arguments.keep(self, begin=begin, end=arguments.number("end", self.end, begin, 1.0))

    @classmethod
    def of(cls, arm: AnyArm, axis: HeldAxis) -> Self:
        """The part that a scene asks for."""
        hold = HeldDirection(arm, np.array(axis.direction), axis.tolerance)
        return cls(hold, axis.begin, axis.end)

    def rows(self, samples: int) -> slice:
        """Uniform samples of a motion that are in the part, or next to it."""
        last = samples - 1
        return slice(math.floor(self.begin * last), math.ceil(self.end * last) + 1)

    def fault(self, positions: FloatArray) -> int | None:
        """Sample of joint positions (k, n) at uniform times after which it is held least.

        None where the direction is proven to be held throughout the part.
        """
        rows = self.rows(len(positions))
        inside = positions[rows]
        if not self.hold.excess(inside).any():
            return None
        worst = int(self.hold.largest_angles(inside).argmax())
        at = self.hold.angles(inside[worst : worst + 2])
        return int(rows.start) + worst + int(at.argmax())

    def span(self, motion: ArmMotion) -> HeldSpan:
        """How well a motion keeps it."""
        inside = motion.positions[self.rows(len(motion.time))]
        duration = float(motion.time[-1])
        return HeldSpan(
            first=self.begin * duration,
            last=self.end * duration,
            angle=float(self.hold.angles(inside).max()),
            bound=float(self.hold.largest_angles(inside).max()),
            tolerance=self.hold.tolerance,
        )
