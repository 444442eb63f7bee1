"""Curves over a motion that take long to compute, so that they are plotted while nothing moves."""

from __future__ import annotations

import numpy as np

from abi.arm_planning.motion.links_clearance import links_clearance as measure
from abi.arrays import FloatArray
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.plan import Plan
from app.shared.computed_once import once_a_plan


@once_a_plan
def acceleration(plan: Plan) -> FloatArray:
    """Acceleration of the tool: size and components, (m, 4), [unit/s²], by differences.

    It jumps where the three phases meet. Within them it is what the curve's bends ask for, which
    shows the steps of a B-spline's second derivative.
    """
    motion = plan.motion
    assert motion is not None
    components = np.gradient(motion.tool_velocity, motion.time, axis=0)
    return np.column_stack([np.linalg.norm(components, axis=1), components])


@once_a_plan
def tool_clearance(plan: Plan) -> FloatArray | None:
    """Distance of the tool to the obstacles (m,), [unit]; None without obstacles."""
    if plan.motion is None or not plan.scene.obstacles:
        return None
    return ObstacleSet(plan.scene.obstacles).nearest(plan.motion.tool)[0]


def has_meshes(plan: Plan) -> bool:
    """Check whether an obstacle is a triangle mesh, to which distances take a while."""
    return any(isinstance(obstacle, MeshShape) for obstacle in plan.scene.obstacles)


@once_a_plan
def links_clearance(plan: Plan, stride: int) -> FloatArray | None:
    """Distance of the arm's links to the obstacles at every ``stride``-th sample (k,), [unit].

    None without obstacles or a motion.
    """
    motion, clearance = plan.motion, plan.arm_clearance
    if plan.arm is None or motion is None or clearance is None:
        return None
    samples = np.arange(0, len(motion.time), stride, dtype=np.int32)
    return measure(clearance, motion, plan.arm, plan.scene.obstacles, samples)
