"""The result of each stage, short enough for its heading; empty where the plan has none."""

from __future__ import annotations

import math

from abi.curves.curve import ArcLength
from abi.planner.plan import Plan
from abi.planner.stage_results import AnyFit
from app.ui import style
from app.ui.numbers import format_length

_MOST_LETTERS = 16
"""Most characters of a search's result that fit beside its title and an arrow."""


def mesh_result(plan: Plan) -> str:
    """Number of nodes that are left."""
    return "" if plan.free is None else f"{plan.free.nodes:,} free nodes"


def graph_result(plan: Plan) -> str:
    """Number of edges."""
    return "" if plan.graph is None else f"{plan.graph.edge_count:,} edges"


def search_result(plan: Plan) -> str:
    """Length of the path, and of the straightened one or the algorithm where there is room."""
    if plan.path is None:
        return ""
    length, unit = format_length(plan.path.length), plan.scene.unit
    if plan.taut is not None:
        return f"{length} → {format_length(plan.taut.length)} {unit}"
    named = f"{style.ALGORITHMS[plan.path.algorithm][0]} {length} {unit}"
    return named if len(named) <= _MOST_LETTERS else f"{length} {unit}"


def bspline_result(plan: Plan) -> str:
    """Length of the B-spline, or that it is not clear."""
    return _curve_result(plan, plan.bspline, plan.bspline_arc)


def quadratic_result(plan: Plan) -> str:
    """Length of the quadratic, or that it is not clear."""
    return _curve_result(plan, plan.quadratic, plan.quadratic_arc)


def _curve_result(plan: Plan, fit: AnyFit | None, arc: ArcLength | None) -> str:
    if fit is None or arc is None:
        return ""
    if fit.holds or math.isinf(fit.clearance.distance):
        return f"{format_length(arc.length)} {plan.scene.unit} ✓"
    return "too close ✗" if fit.clearance.nearest > 0 else "collides ✗"
