"""Capsules of the paper's arm at given joint positions.

See ``abi.robot.paper_arm.pose_kernels`` for the numbers of an arm and its capsules.
"""

from __future__ import annotations

import math

from abi.arrays import FloatArray
from abi.compiled import FLOATS, NEW_FLOATS, compiled
from abi.robot.paper_arm.pose_kernels import (
    CAPSULE,
    NO_NUMBERS,
    ArmNumbers,
    PaperArmPose,
    capsule_ends,
)


@compiled(example=(FLOATS, NO_NUMBERS, FLOATS, NEW_FLOATS))
def place_capsules(
    joints: FloatArray, arm: ArmNumbers, capsules: FloatArray, ends: FloatArray
) -> None:
    """Both ends of every capsule at joint positions.

    Args:
        joints: of each pose q1 to q6, flat (6 n,), [rad], q5 [unit].
        arm: its numbers.
        capsules: rows (4 c,).
        ends: flat (6 n c,), [unit], world; written.
    """
    count = len(capsules) // CAPSULE
    for i in range(len(joints) // 6):
        q1, q2, q3 = joints[6 * i], joints[6 * i + 1], joints[6 * i + 2]
        forearm = arm.forearm + joints[6 * i + 4]
        right, ahead = math.sin(q1), math.cos(q1)
        out, up = arm.upper * math.sin(q2), arm.shoulder + arm.upper * math.cos(q2)
        across, height = out + forearm * math.sin(q2 + q3), up + forearm * math.cos(q2 + q3)
        shoulder = (arm.x, arm.y, arm.shoulder)
        elbow = (arm.x + right * out, arm.y - ahead * out, up)
        tool = (arm.x + right * across, arm.y - ahead * across, height)
        pose = PaperArmPose(shoulder, elbow, tool, forearm, out, across, 0.0)
        for c in range(count):
            k = 6 * (i * count + c)
            a, b = capsule_ends(arm, pose, capsules, c)
            ends[k], ends[k + 1], ends[k + 2] = a
            ends[k + 3], ends[k + 4], ends[k + 5] = b
