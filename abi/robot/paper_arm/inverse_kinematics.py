"""Stage 6, inverse kinematics of the paper's arm: q1, q2 and q3 that put the tool on given points.

The arm is a planar two-link arm (a3, a6) in a vertical plane that q1 turns about the base axis.
In that plane the tool is at (r, z) from the shoulder, D² = r² + z², and

    q1 = atan2(x, −y)
    tan²(q3/2) = ((a3 + a6)² − D²) / (D² − (a3 − a6)²)
    q2 = atan2(r, z) − atan2(a6·sin q3, a3 + a6·cos q3)

which is the cosine rule cos q3 = (D² − a3² − a6²) / (2·a3·a6) in the form that stays exact at
full stretch and full fold. The paper's own q1, q2 and q3 (stage 6) have misprints: its q1 is right
in one quadrant only. That of URDF arms is in :mod:`abi.robot.kinematics.follow_path_kernels`.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from abi import arguments
from abi.arrays import FloatArray, flat, read_only
from abi.robot.paper_arm import inverse_kinematics_kernels as kernels
from abi.robot.paper_arm.paper_arm import PaperArm

THROUGH = 1e-6
"""Distance from the base axis, over the arm's reach, below which a path counts as passing through
it."""


def solve(
    arm: PaperArm,
    points: FloatArray,
    q5: FloatArray,
    elbow: Literal["up", "down"],
    tangents: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Solve for the joint positions that lead the tool along a path, on one elbow branch.

    q1 is continuous: where the path goes through the base axis, r changes its sign and q1 does not
    jump by π; on the axis q1 is its limit along the path, 0 when the whole path is on the axis.
    Passing the axis at a small distance d turns q1 by nearly π at the speed v/d, as it must.
    A path through the shoulder itself (possible only when a3 = a6) has no continuous q2.

    Args:
        arm: the arm.
        points: the path in the order it is followed, shape (n, 3), [unit], world; n >= 1.
        q5: extension at each point, shape (n,), [unit].
        elbow: ``up`` for q3 >= 0, the upper arm more upright; ``down`` for q3 <= 0.
        tangents: direction of the path at each point, shape (n, 3), unit vectors or zero.

    Returns:
        Joint positions (n, 3), [rad]: q1 about the base axis and q2 of the shoulder, unwrapped
        along the path, and q3 of the elbow, of one sign along it. And the distances (n,) by which
        points are out of reach, [unit]: > 0 too far from the shoulder, < 0 too near, 0 within
        reach. There the joints are those of the stretched or folded arm that points at the point;
        nothing is raised.
    """
    points = arguments.points("points", points)
    q5 = arguments.numbers("q5", q5, points.shape[:1])
    tangents = arguments.numbers("tangents", tangents, points.shape)
    offset = points - arm.shoulder
    forearm = arm.forearm(q5)
    rounding = 1e-13 * (
        float(np.abs(offset).max())
        + float(np.abs(arm.base).max())
        + arm.a3
        + float(np.abs(forearm).max())
    )
    solution = np.empty((5, len(offset)))
    q1, across, q2, q3, shortfall = solution
    path = flat(offset), flat(np.asarray(tangents, dtype=float))
    through = THROUGH * (arm.a3 + arm.a4 + arm.a5)
    kernels.base_angle(*path, rounding, through, q1, across)
    side = 1.0 if elbow == "up" else -1.0
    in_plane = across, flat(offset[:, 2]), flat(forearm)
    kernels.elbow_angles(*in_plane, float(arm.a3), side, rounding, solution[2:].reshape(-1))
    return read_only(np.stack([_centred(q1), _centred(q2), q3], axis=1)), read_only(shortfall)


def _centred(angle: FloatArray) -> FloatArray:
    """Shift angles by whole turns, so that their range is as near to 0 as can be."""
    middle = (angle.max() + angle.min()) / 2
    return np.asarray(angle - 2 * np.pi * np.ceil((middle - np.pi) / (2 * np.pi)))
