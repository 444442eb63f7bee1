"""The B-spline of a plan with control points moved by hand: its clearance, and what differs."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from abi.arrays import BoolArray, FloatArray
from abi.curves.bspline import BSpline, clamped
from abi.curves.fit import Fit, proven_fit
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.pose import Vec3
from abi.planner.plan import Plan

_SAMPLES = 400
"""Points of the curve at which the influence of a moved control point is looked at."""


def bend(plan: Plan, places: Mapping[int, Vec3 | FloatArray]) -> Fit[BSpline]:
    """Bend the plan's B-spline, and prove its clearance anew where that can be.

    Args:
        plan: with a B-spline; it stays as it is.
        places: of the control points moved, by their numbers, (3,), [unit], world.
    """
    assert plan.bspline is not None
    spline, required = plan.bspline.curve, plan.bspline.required
    points = spline.control_points.copy()
    for number, place in places.items():
        points[number] = place
    curve = clamped(points, spline.degree, spline.added, spline.pushed)
    return proven_fit(curve, curve.extent, ObstacleSet(plan.scene.obstacles), required)


def moved_points(plan: Plan, bent: BSpline) -> BoolArray:
    """Which control points (n,) of the bent curve are not where the plan has them."""
    assert plan.bspline is not None
    return np.asarray((bent.control_points != plan.bspline.curve.control_points).any(axis=1))


def changed_share(plan: Plan, bent: BSpline) -> float:
    """Part of the bent curve that depends on a control point that was moved, 0 to 1."""
    influence = bent.influence(np.linspace(*bent.interval, _SAMPLES))
    return float((influence[:, moved_points(plan, bent)] > 0).any(axis=1).mean())
