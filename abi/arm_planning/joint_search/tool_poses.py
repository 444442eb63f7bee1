"""Joint positions with the tool in a given pose, its orientation included."""

from __future__ import annotations

import numpy as np
import scipy

from abi import arguments
from abi.arrays import FloatArray, read_only
from abi.robot.urdf_arm import UrdfArm

_STARTS, _ROUNDS = 96, 60
_DAMPING = 1e-6
_LARGEST_STEP = 0.5
_STEP = 1e-6
_EXACT = 1e-8
"""Errors up to which a pose counts as reached without any tolerance, [rad] and over the reach."""
_ALIKE = 0.3
"""Joint distance below which two poses count as one, [rad] or [m]."""


def tool_poses(
    arm: UrdfArm,
    place: FloatArray,
    turn: FloatArray,
    tolerances: tuple[float, float] = (0.0, 0.0),
    seed: int = 0,
) -> FloatArray:
    """Different joint positions (k, n) within the limits with the tool in a pose.

    Damped least squares from random positions, all of them at once; k may be 0 although there are
    some. Those nearest to the middle of the limits come first.

    Args:
        arm: the arm.
        place: of the tool, (3,), [unit], world.
        turn: world from tool, a rotation (3, 3).
        tolerances: how far from it the tool may be, [unit] and [rad].
        seed: of the random positions.
    """
    place = arguments.numbers("place", place, (3,))
    turn = arguments.numbers("turn", turn, (3, 3))
    low, high = arm.chain.limits.T
    start, end = arm.chain.usual_range().T
    random = np.random.default_rng(seed)
    joints = np.concatenate([[(start + end) / 2], random.uniform(start, end, (_STARTS, len(low)))])
    target = place * arm.metres, turn
    for _ in range(_ROUNDS):
        missed = _missed(arm, joints, *target)
        slopes = np.stack(
            [
                (_missed(arm, joints + _STEP * axis, *target) - missed) / _STEP
                for axis in np.eye(len(low))
            ],
            axis=-1,
        )
        normal = slopes.swapaxes(1, 2) @ slopes + _DAMPING * np.eye(len(low))
        step = np.linalg.solve(normal, slopes.swapaxes(1, 2) @ missed[..., None])[..., 0]
        size = np.abs(step).max(axis=1, keepdims=True)
        joints = np.clip(
            joints - step * np.minimum(1, _LARGEST_STEP / np.maximum(size, _EXACT)), low, high
        )
    missed = _missed(arm, joints, *target)
    allowed = tolerances[0] / arm.reach + _EXACT, tolerances[1] + _EXACT
    near = np.linalg.norm(missed[:, :3], axis=1) <= allowed[0]
    turned = np.linalg.norm(missed[:, 3:], axis=1) <= allowed[1]
    reached = joints[near & turned]
    half = np.maximum((high - low) / 2, 1e-9)
    reached = reached[np.abs((reached - (low + high) / 2) / half).max(axis=1).argsort()]
    kept: list[FloatArray] = []
    for pose in reached:
        if all(np.abs(pose - other).max() > _ALIKE for other in kept):
            kept.append(pose)
    return read_only(np.array(kept).reshape(-1, len(low)) * arm.scales)


def _missed(arm: UrdfArm, joints: FloatArray, place: FloatArray, turn: FloatArray) -> FloatArray:
    """Errors (k, 6) of the tool at coordinates (k, n): of its place over the reach, then its turn.

    The turn is a rotation vector in the world.
    """
    tip = arm.chain.poses(joints)[:, -1]
    away = (tip[:, :, 3] - place) / arm.chain.table.reach
    between = scipy.spatial.transform.Rotation.from_matrix(tip[:, :, :3] @ turn.T)
    return np.concatenate([away, between.as_rotvec()], axis=1)
