"""The curves as B-splines: degree, knots and control points, with every bit of their numbers.

scipy's ``BSpline(knots, control_points, degree)``, OpenCASCADE and any CAD kernel take these.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from abi.arrays import FloatArray
from abi.curves.fit import Fit
from abi.curves.quadratic import Quadratic
from abi.errors import AbiError
from abi.planner.plan import Plan

_TIMES = 201


def write(plan: Plan, name: str) -> bytes:
    """Write both curves, which of them is followed, and the motion along it, as JSON.

    Raises:
        AbiError: the plan has no curves.
    """
    if plan.bspline is None:
        cause = "they were not planned." if plan.error is None else plan.error.message
        raise AbiError(f"There are no curves to export: {cause}")
    spline, holds = plan.bspline.curve, plan.bspline.holds
    curves = [_curve("bspline", holds, spline.degree, spline.knots, spline.control_points)]
    if plan.quadratic is not None:
        curves.append(_quadratic(plan.quadratic))
    motion = None
    if (profile := plan.profile) is not None:
        times = np.linspace(0.0, profile.duration, _TIMES)
        motion = {
            "curve": plan.followed,
            "duration": profile.duration,
            "peak_speed": profile.peak_speed,
            "times": times.tolist(),
            "distances": profile(times).tolist(),
        }
    data = {"version": 1, "unit": plan.scene.unit, "curves": curves, "motion": motion}
    return (json.dumps(data, indent=1, allow_nan=False) + "\n").encode()


def _curve(
    name: str, certified: bool, degree: int, knots: FloatArray, points: FloatArray
) -> dict[str, Any]:
    return {
        "name": name,
        "degree": degree,
        "knots": knots.tolist(),
        "control_points": points.tolist(),
        "certified": certified,
    }


def _quadratic(fit: Fit[Quadratic]) -> dict[str, Any]:
    """The quadratic pieces as one B-spline whose inner knots occur twice: its Bézier points."""
    pieces = fit.curve.bezier()
    breaks = pieces.breaks
    knots = np.concatenate([breaks[:1], np.repeat(breaks, 2), breaks[-1:]])
    points = np.concatenate([pieces.points[0, :1], pieces.points[:, 1:].reshape(-1, 3)])
    return _curve("quadratic", fit.holds, 2, knots, points)
