"""Joint positions over time in the units of ROS, for robot controllers and recordings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arrays import read_only
from abi.errors import AbiError
from abi.explain.arm_faults import arm_warning, limits_warning
from abi.export.between_points import rows_warning
from abi.export.carried_objects import carried_objects
from abi.obstacles.pose import METRES
from abi.planner.arm_words import UNPAIRED_SENTENCE
from abi.planner.plan import Plan

_LONGEST = 2.0**31
"""Seconds that builtin_interfaces/msg/Duration holds, [s]."""


def motion_of(plan: Plan) -> ArmMotion:
    """The motion of a plan.

    Raises:
        AbiError: the plan has no motion.
    """
    if plan.motion is None:
        cause = "it was not planned" if plan.error is None else plan.error.message
        raise AbiError(f"There is no motion to export: {cause}")
    return plan.motion


def is_proven(plan: Plan) -> bool:
    """Whether the motion is proven clear, also between its poses; it may pass limits of speed."""
    return not (arm_warning(plan) or rows_warning(plan))


def is_marked(plan: Plan) -> bool:
    """Whether the motion is not proven clear, also between its poses, or passes limits."""
    return not is_proven(plan) or bool(limits_warning(plan))


def motion_state(plan: Plan) -> str:
    """Sentences that a file of the motion carries.

    They say whether the arm is clear, which limits it passes, and what its tool holds on the way.
    """
    warning = arm_warning(plan) or rows_warning(plan)
    state = "The arm's whole motion is proven clear of the scene's obstacles."
    if warning:
        state = f"The arm's motion is NOT proven clear. {warning}"
    if past := limits_warning(plan):
        state += f" It PASSES LIMITS of the joints. {past}"
    if plan.paper_arm is not None:
        state += f" {UNPAIRED_SENTENCE}"
    return " ".join((state, *holding(plan)))


def holding(plan: Plan) -> list[str]:
    """Sentences on what the tool holds, on the whole motion or a part of it, and on its gripper."""
    if plan.motion is None:
        return []
    time, scene = plan.motion.time, plan.scene
    told = [
        f"From {time[one.first]:.4g} to {time[one.last]:.4g} s its tool holds "
        f"{f'obstacle {one.number + 1}' if one.is_taken else 'an object'}, as a part of the arm."
        for one in carried_objects(plan)
    ]
    if not plan.legs and scene.arm.attached is not None:
        told.append("Its tool holds an object, as a part of the arm.")
    grippers = [leg.scene.arm.gripper for leg in plan.legs] or [scene.arm.gripper]
    if any(one != grippers[0] for one in grippers):
        told.append("Its gripper is held otherwise on some legs than on others.")
    elif grippers[0] and plan.arm is not None and scene.arm.model == "urdf":
        robot = scene.arm.robot
        slides = {one.name for one in robot.joints if one.kind == "prismatic"}
        held = [
            f"{name} at {at:.4g} {scene.unit if name in slides else 'rad'}"
            for name, at in grippers[0].items()
        ]
        told.append(f"Joints beside the arm are held: {', '.join(held)}.")
    return told


def joint_trajectory(plan: Plan) -> ArmMotion:
    """A plan's motion with its sliding joints in [m], and their rates in [m/s] and [m/s²].

    Like controllers, the plan begins and ends at rest: the drives hold before and after the
    motion.

    Raises:
        AbiError: there is no motion, it leaves the arm's reach, a joint leaves its range, or it
            lasts longer than times of ROS hold.
    """
    motion = motion_of(plan)
    if motion.error is not None:
        raise AbiError(f"The arm cannot execute this motion: {motion.error.message}")
    if motion.limit_violations:
        joint = motion.limit_violations[0]
        raise AbiError(
            f"The arm cannot execute this motion: {joint.joint} passes its limit of "
            f"{joint.limit:.4g} at {joint.since:.2f} s.",
            "Move the base, or change the elbow or the forces of the drives.",
        )
    if not motion.time[-1] < _LONGEST:
        raise AbiError(
            f"The motion lasts {motion.time[-1]:.3g} s, and times of ROS hold 68 years.",
            "Raise motion.speed, or whatever the plan says that it is slowed down by.",
        )
    metres = METRES[plan.scene.unit]
    scale = np.array([metres if slides else 1.0 for slides in motion.slides])
    rates = motion.joint_velocities * scale, motion.joint_accelerations * scale
    return replace(
        motion,
        positions=read_only(motion.positions * scale),
        peak_joint_speed=read_only(motion.peak_joint_speed * scale),
        rates=(read_only(rates[0]), read_only(rates[1])),
    )
