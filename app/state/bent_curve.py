"""The B-spline of a plan with control points moved by hand, and its clearance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from abi.arrays import FloatArray
from abi.curves.bspline import BSpline, clamped
from abi.curves.fit import Fit, proven_fit
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.pose import Vec3
from abi.planner.plan import Plan

_SAMPLES = 400
"""Points of the curve at which the influence of a moved control point is looked at."""


@dataclass(frozen=True, eq=False)
class BentCurve:
    """A B-spline bent by hand, which is not part of the plan.

    Attributes:
        of: the plan's curve.
        fit: the bent one and its clearance, proven anew where it can be.
        length: of the curve, [unit].
        moved: number of control points that are not where the plan has them.
        changed: part of the curve that depends on one of these, 0 to 1.
    """

    of: BSpline
    fit: Fit[BSpline]
    length: float
    moved: int
    changed: float


def bend(plan: Plan, places: Mapping[int, Vec3 | FloatArray]) -> BentCurve:
    """Bend the plan's B-spline.

    Args:
        plan: with a B-spline.
        places: of the control points moved, by their numbers, (3,), [unit], world.
    """
    assert plan.bspline is not None
    spline, required = plan.bspline.curve, plan.bspline.required
    points, numbers = spline.control_points.copy(), list(places)
    for number, place in places.items():
        points[number] = place
    curve = clamped(points, spline.degree, spline.added, spline.pushed)
    fit = proven_fit(curve, curve.extent, ObstacleSet(plan.scene.obstacles), required)
    influence = curve.influence(np.linspace(*curve.interval, _SAMPLES))[:, numbers]
    changed = float((influence > 0).any(axis=1).mean())
    return BentCurve(spline, fit, fit.arc.length, len(numbers), changed)
