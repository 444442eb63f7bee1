"""Extent of a plan in space: workspace, curve, and the whole arm over its motion."""

from __future__ import annotations

import numpy as np

from abi.arm_planning.motion.trajectory import rest_pose
from abi.arrays import FloatArray
from abi.planner.plan import Plan
from abi.robot.paper_arm.paper_arm import PaperArm
from app.drawing.box import box_corners

_CURVE_POINTS = 40
_POSES = 40
"""Number of poses of the motion that are looked at."""


def extent(plan: Plan) -> FloatArray:
    """Points (n, 3) whose convex hull contains nearly all of a plan, [unit], world."""
    corners = box_corners(plan.scene.workspace.min, plan.scene.workspace.max)
    parts = [corners, np.array([plan.scene.arm.base], dtype=float)]
    if plan.bspline is not None:
        curve = plan.bspline.curve
        parts.append(curve(np.linspace(*curve.interval, _CURVE_POINTS)))
    positions = _positions(plan)
    if plan.arm is not None and len(positions):
        for capsule in plan.arm.placed(positions):
            steps = capsule.radius * np.vstack([np.eye(3), -np.eye(3)])
            parts.append((capsule.ends.reshape(-1, 1, 3) + steps).reshape(-1, 3))
    return np.vstack(parts)


def _positions(plan: Plan) -> FloatArray:
    """Joint positions (k, n) in which the arm is drawn; none if it is not known where it stands."""
    if plan.motion is not None:
        positions = plan.motion.positions
        chosen = np.linspace(0, len(positions) - 1, _POSES).astype(int)
        return np.asarray(positions[chosen])
    if isinstance(plan.arm, PaperArm):
        scene = plan.scene
        return np.asarray(rest_pose(plan.arm, scene.arm, scene.start))[None, :]
    return np.empty((0, 0))
