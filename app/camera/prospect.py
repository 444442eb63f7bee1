"""Direction from which a plan is seen best: curve, ends and obstacles beside the moving arm."""

from __future__ import annotations

import numpy as np

from abi.arrays import BoolArray, FloatArray
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.pose import Vec3
from abi.planner.plan import Plan
from app.camera.occlusion import hidden
from app.shared.computed_once import once_a_plan

USUAL = np.array([0.82, -0.42, 0.38])
"""Default camera position relative to the scene's middle, in sizes of the scene."""

_TURNS = np.radians(np.arange(-160, 181, 20))
_HEIGHTS = np.radians([6, 15, 25, 38, 52])
_CURVE, _POSES, _OBSTACLES = 24, 12, 8
"""Largest numbers of points of the curve, poses of the motion and obstacles that are looked at."""
_NEAR = 0.08
"""Distance, over the scene's size, at which an arm in front of a point does not hide it."""
_FOOT = 0.07, 0.25
"""Radius and height of what the arm stands on, as parts of the scene's size."""
_MOST = 0.25, 0.5
"""Largest hidden parts of the curve and of the obstacles' centres that still count as in view."""
_COVERED, _UNSEEN, _TURNING, _END_ON = 2.0, 4.0, 1.0, 1.5
"""Penalties of a curve behind obstacles, of a motion that is never in view, of a quarter turn away
from the default direction, and of ends that lie behind each other."""
_APART = 0.75
"""Seen distance of the ends, over their true one, from which on they count as apart."""


@once_a_plan
def best_direction(plan: Plan, target: Vec3, size: float) -> FloatArray:
    """Direction to the camera, (3,), that keeps most in view for most of the motion.

    Args:
        plan: with a B-spline.
        target: what the camera looks at, [unit], world.
        size: length that a direction of length 1 stands for, [unit].
    """
    assert plan.bspline is not None
    curve = plan.bspline.curve(np.linspace(*plan.bspline.curve.interval, _CURVE))
    directions = _directions()
    eyes = np.array(target) + size * directions
    ways = np.repeat(eyes, len(curve), axis=0), np.tile(curve, (len(eyes), 1))
    behind = ObstacleSet(plan.scene.obstacles).blocked(ways[1], ways[0], 0.0)
    covered = behind.reshape(len(eyes), len(curve)).mean(axis=1)
    unseen = 1 - in_view(plan, curve, eyes, size).mean(axis=1)
    cosine = directions @ USUAL / (USUAL @ USUAL)
    end_on = np.maximum(_APART - _seen_apart(curve[-1] - curve[0], directions), 0.0)
    scores = _COVERED * covered + _UNSEEN * unseen + _TURNING * (1 - cosine) + _END_ON * end_on
    return np.asarray(directions[int(np.argmin(scores))])


def in_view(plan: Plan, curve: FloatArray, eyes: FloatArray, size: float) -> BoolArray:
    """Check at which moments curve, ends and obstacles are in view of which eyes.

    No end is in view that is behind an obstacle, and at no moment what the arm hides then.

    Args:
        plan: the plan; without a motion, nothing moves that hides anything.
        curve: points of its curve, from the start to the goal, (n, 3), [unit], world.
        eyes: (e, 3), [unit], world.
        size: of the scene, [unit].

    Returns:
        Shape (e, moments).
    """
    both = np.tile(curve[[0, -1]], (len(eyes), 1))
    obstacles = ObstacleSet(plan.scene.obstacles)
    is_behind = obstacles.blocked(both, np.repeat(eyes, 2, axis=0), 0.0).reshape(-1, 2)
    are_open = ~is_behind.any(axis=1, keepdims=True)
    if plan.motion is None or plan.arm is None:
        return np.asarray(are_open)
    positions = plan.motion.positions
    rows = np.linspace(0, len(positions) - 1, _POSES).astype(int)
    foot = np.array([plan.arm.base, np.add(plan.arm.base, (0.0, 0.0, _FOOT[1] * size))])
    feet = np.tile(foot, (len(rows), 1, 1, 1))
    ends = np.concatenate([plan.arm.place(positions[rows]), feet], axis=1)
    radii = np.append(plan.arm.radii, _FOOT[0] * size)
    middles = np.array([one.position for one in plan.scene.obstacles], float).reshape(-1, 3)
    if len(middles) > _OBSTACLES:
        middles = middles[:0]  # of a crowd there is always one behind the arm
    behind = hidden(eyes, np.vstack([curve, middles]), ends, radii, _NEAR * size)
    of_curve, of_obstacles = behind[..., : len(curve)], behind[..., len(curve) :]
    seen = ~(of_curve[..., 0] | of_curve[..., -1]) & (of_curve.mean(axis=-1) <= _MOST[0])
    if len(middles):
        seen &= of_obstacles.mean(axis=-1) <= _MOST[1]
    return np.asarray(seen & are_open)


def _seen_apart(way: FloatArray, directions: FloatArray) -> FloatArray:
    """Length of a way (3,) as seen from directions (n, 3), over its true length, (n,)."""
    length = np.linalg.norm(way)
    if length == 0:
        return np.ones(len(directions))
    cosine = directions @ way / (np.linalg.norm(directions, axis=1) * length)
    return np.asarray(np.sqrt(np.maximum(1 - cosine**2, 0.0)))


def _directions() -> FloatArray:
    """Candidate directions to the camera, (n, 3): all around, and from above."""
    length, azimuth = np.linalg.norm(USUAL), np.arctan2(USUAL[1], USUAL[0])
    found = [USUAL]
    for turn in azimuth + _TURNS:
        for height in _HEIGHTS:
            level = np.cos(height)
            found.append(
                length * np.array([level * np.cos(turn), level * np.sin(turn), np.sin(height)])
            )
    return np.stack(found)
