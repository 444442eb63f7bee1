"""Extent of a plan in space: workspace, obstacles, curve, and the arm over its whole motion."""

from __future__ import annotations

import numpy as np

from abi.arm_planning.motion.trajectory import rest_pose
from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.plan import Plan
from abi.scene.scene import Scene
from app.drawing.box import box_corners

_CURVE_POINTS = 40
_POSES = 40
"""Number of poses of the motion that are looked at."""
_BEYOND = 0.5
"""Distance from the workspace, over its longest side, up to which obstacles count."""


def extent(plan: Plan) -> FloatArray:
    """Points (n, 3) whose convex hull contains nearly all of a plan, [unit], world."""
    corners = box_corners(plan.scene.workspace.min, plan.scene.workspace.max)
    parts = [corners, np.array([plan.scene.arm.base], dtype=float), _obstacles(plan.scene)]
    if plan.bspline is not None:
        curve = plan.bspline.curve
        parts.append(curve(np.linspace(*curve.interval, _CURVE_POINTS)))
    positions = _positions(plan)
    if plan.arm is not None and len(positions):
        steps = plan.arm.radii[:, None, None, None] * np.vstack([np.eye(3), -np.eye(3)])
        parts.append((plan.arm.place(positions)[..., None, :] + steps).reshape(-1, 3))
    return np.vstack(parts)


def _obstacles(scene: Scene) -> FloatArray:
    """Corners (n, 3) of boxes around the obstacles, as far as these are near the workspace."""
    if not scene.obstacles:
        return np.empty((0, 3))
    beyond = _BEYOND * max(scene.workspace.size)
    low, high = np.subtract(scene.workspace.min, beyond), np.add(scene.workspace.max, beyond)
    firsts, lasts = ObstacleSet(scene.obstacles).bounds
    near = ((firsts <= high) & (lasts >= low)).all(axis=1)
    firsts, lasts = np.maximum(firsts[near], low), np.minimum(lasts[near], high)
    return box_corners(firsts[:, None], lasts[:, None]).reshape(-1, 3)


def _positions(plan: Plan) -> FloatArray:
    """Joint positions (k, n) in which the arm is drawn; none if it is not known where it stands."""
    if plan.motion is not None:
        positions = plan.motion.positions
        chosen = np.linspace(0, len(positions) - 1, _POSES).astype(int)
        return np.asarray(positions[chosen])
    if plan.paper_arm is not None:
        scene = plan.scene
        return np.asarray(rest_pose(plan.paper_arm, scene.arm, scene.start))[None, :]
    return np.empty((0, 0))
