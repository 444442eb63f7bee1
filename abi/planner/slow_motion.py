"""Motions that take far longer than anybody asked for, and why."""

from __future__ import annotations

import numpy as np

from abi.arm_planning.joint_rates import joint_rates
from abi.curves.three_phase_profile import three_phase
from abi.errors import StageError, format_length
from abi.planner.plan import Plan

_LONG, _TIMES = 60.0, 20.0
"""A motion is refused if it takes longer than this, [s], and so many times what would be enough."""


def refuse_slow(plan: Plan) -> None:
    """Raise for a motion that a law has slowed down beyond all use.

    Enough is the time that the tool's path takes at the scene's speed, and each joint for its own
    travel at its limits, whichever is longest. What takes many times as long follows from a bend or
    a turn of the joints that they can pass but slowly.

    Args:
        plan: the plan; without an arm and its motion, nothing is refused.

    Raises:
        StageError: the motion takes so long; names the joint, and when it is at its limit.
    """
    arm, profile, motion, asked = plan.arm, plan.profile, plan.motion, plan.scene.motion
    if arm is None or profile is None or motion is None or profile.duration <= _LONG:
        return
    speeds, accelerations, _ = arm.rate_limits(asked.joint_acceleration)
    travel = np.abs(np.diff(motion.positions, axis=0)).sum(axis=0)
    joints = float((travel / speeds + 2 * np.sqrt(travel / accelerations)).max())
    length = float(np.linalg.norm(np.diff(motion.tool, axis=0), axis=1).sum())
    alone = three_phase(length, asked.speed, asked.acceleration, asked.deceleration).duration
    if profile.duration <= _TIMES * max(joints, alone):
        return
    rates = joint_rates(arm, motion, asked.joint_acceleration)
    used = np.maximum(np.abs(rates.speeds) / speeds, np.abs(rates.accelerations) / accelerations)
    sample, joint = np.unravel_index(int(used.argmax()), used.shape)
    name, moment = motion.joints[joint], float(motion.time[sample])
    raise StageError(
        "timing",
        "too_slow",
        f"Within the joints' limits the motion would take {profile.duration:.0f} s for a way of "
        f"{format_length(length)}, for which {max(joints, alone):.2g} s should be enough: at "
        f"t = {moment:.3g} s {name.replace('_', ' ')} has to turn faster than anywhere else.",
        "Choose the law time_optimal, which slows down only there, or move the way from where "
        "the arm is nearly stretched out or its wrist straight.",
    )
