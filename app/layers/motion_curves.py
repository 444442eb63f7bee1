"""Curves over the time of a motion that are plotted while nothing moves: they take a while."""

from __future__ import annotations

import numpy as np

from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.plan import Plan
from app.once_a_plan import once_a_plan


@once_a_plan
def acceleration(plan: Plan) -> FloatArray:
    """Acceleration of the tool: size and components, (m, 4), [unit/s²], by differences.

    It jumps where the three phases meet. Within them it is what the curve's bends ask for, which
    shows the steps of a B-spline's second derivative.
    """
    motion = plan.motion
    assert motion is not None
    along = np.gradient(motion.velocity, motion.time, axis=0)
    return np.column_stack([np.linalg.norm(along, axis=1), along])


@once_a_plan
def tool_clearance(plan: Plan) -> FloatArray | None:
    """Distance of the tool to the obstacles (m,), [unit]; None without obstacles."""
    if plan.motion is None or not plan.scene.obstacles:
        return None
    return ObstacleSet(plan.scene.obstacles).nearest(plan.motion.tool)[0]
