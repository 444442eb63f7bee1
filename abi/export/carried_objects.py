"""Objects that the gripper takes, carries and releases in a sequence of tasks."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from abi.obstacles.obstacle_set import Obstacle
from abi.planner.plan import Plan
from abi.robot.any_arm import AnyArm
from abi.robot.kinematics.chain import Chain


class CarriedObject(NamedTuple):
    """An object that the tool holds on some legs of a sequence.

    Attributes:
        number: of the obstacle that it is before and after, from 0.
        shape: the object in the frame of the tip.
        left: the obstacle that it is afterwards, where it is released.
        arm: the arm with the object as a body.
        first: sample of the whole motion at which it is taken; 0 where it is held from the start.
        last: sample at which it is released, or the motion ends.
        is_taken: whether it was an obstacle before.
    """

    number: int
    shape: Obstacle
    left: Obstacle | None
    arm: AnyArm
    first: int
    last: int
    is_taken: bool

    @property
    def link(self) -> str:
        """Name of the link that stands for the object while it is held."""
        return self.arm.chain.robot.attached


def carried_objects(plan: Plan) -> Iterator[CarriedObject]:
    """Objects that are held on some legs of a plan that joins several, in order."""
    counts = [0 if leg.motion is None else len(leg.motion.time) - 1 for leg in plan.legs]
    begins = [0, *np.cumsum(counts).tolist()]
    numbers = range(len(plan.legs))
    for holds, run in itertools.groupby(
        numbers, lambda k: plan.legs[k].scene.arm.attached is not None
    ):
        legs = [*run]
        if not holds:
            continue
        before = plan.scene.tasks[legs[0] - 1].attach if legs[0] > 0 else None
        number = len(plan.scene.obstacles) if before is None else before
        after = legs[-1] + 1
        here = plan.legs[legs[0]]
        assert here.arm is not None
        assert here.scene.arm.attached is not None
        yield CarriedObject(
            number=number,
            shape=here.scene.arm.attached,
            left=plan.legs[after].scene.obstacles[number] if after < len(plan.legs) else None,
            arm=here.arm,
            first=begins[legs[0]],
            last=begins[after],
            is_taken=before is not None,
        )


def chains_of_legs(plan: Plan) -> list[tuple[Chain, int]]:
    """Chain of each leg of a plan, or its only one, and the number of the sample that ends it."""
    found, last = [], 0
    for leg in plan.legs or (plan,):
        assert leg.motion is not None
        assert leg.arm is not None
        last += len(leg.motion.time) - 1
        found.append((leg.arm.chain, last))
    return found
