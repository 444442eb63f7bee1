"""A plan as plain data: the JSON that scripts read."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from abi.arm import JOINTS
from abi.bspline import BSpline
from abi.quadratic import Quadratic

if TYPE_CHECKING:
    from abi.plan import Plan

SAMPLES = 200


def to_dict(plan: Plan, full: bool) -> dict[str, Any]:
    """Plain data; a stage that was not reached is None. See ``Plan.to_dict``."""
    error = plan.error
    return {
        "version": 1,
        "scene": plan.scene.to_dict(),
        "mesh": _mesh(plan, full),
        "graph": _graph(plan),
        "searches": _searches(plan),
        "path": _path(plan),
        "bspline": _bspline(plan),
        "quadratic": _quadratic(plan),
        "optimum": _optimum(plan),
        "timing": _timing(plan),
        "arm": _arm(plan, full),
        "total_ms": plan.total_ms,
        "error": None
        if error is None
        else {
            "stage": error.stage,
            "kind": error.kind,
            "message": error.message,
            "hint": error.hint,
        },
    }


def _mesh(plan: Plan, full: bool) -> dict[str, Any] | None:
    if plan.mesh is None or plan.free is None:
        return None
    mesh = {
        "lattice": plan.mesh.lattice,
        "pitch": plan.mesh.pitch,
        "nodes": len(plan.mesh.points),
        "tetrahedra": plan.free.tetrahedra_kept,
        "excluded_nodes": int(plan.free.excluded.sum()),
        "ms": plan.ms["mesh"],
    }
    if full:
        mesh["points"] = plan.mesh.points.tolist()
        mesh["edges"] = plan.mesh.edges.tolist()
        mesh["excluded"] = np.flatnonzero(plan.free.excluded).tolist()
    return mesh


def _graph(plan: Plan) -> dict[str, Any] | None:
    if plan.graph is None:
        return None
    return {
        "nodes": plan.graph.free_nodes,
        "edges": plan.graph.edge_count,
        "removed_edges": plan.graph.removed_edges,
        "ms": plan.ms["graph"],
    }


def _searches(plan: Plan) -> list[dict[str, Any]] | None:
    if not plan.searches:
        return None
    return [
        {
            "algorithm": result.algorithm,
            "weight": result.weight,
            "vertices": result.vertices.tolist(),
            "points": result.points.tolist(),
            "length": result.length,
            "hops": result.hops,
            "cost": result.cost,
            "expanded": result.expanded,
            "relaxed": result.relaxed,
            "ms": plan.ms[result.algorithm],
        }
        for result in plan.searches
    ]


def _path(plan: Plan) -> dict[str, Any] | None:
    if plan.path is None:
        return None
    return {
        "algorithm": plan.path.algorithm,
        "points": plan.path.points.tolist(),
        "length": plan.path.length,
    }


def _bspline(plan: Plan) -> dict[str, Any] | None:
    if plan.bspline is None or plan.bspline_arc is None:
        return None
    return {
        "degree": plan.bspline.degree,
        "control_points": plan.bspline.control_points.tolist(),
        "knots": plan.bspline.knots.tolist(),
        "inserted": plan.bspline.inserted,
        "moved": plan.bspline.moved,
        "length": plan.bspline_arc.length,
        **_clear(plan.bspline),
        "ms": plan.ms["bspline"],
    }


def _quadratic(plan: Plan) -> dict[str, Any] | None:
    if plan.quadratic is None or plan.quadratic_arc is None:
        return None
    return {
        "pieces": [{"t0": 0.0, "t1": 1.0, "coefficients": plan.quadratic.coefficients.tolist()}],
        "length": plan.quadratic_arc.length,
        **_clear(plan.quadratic),
        "ms": plan.ms["quadratic"],
    }


def _clear(curve: BSpline | Quadratic) -> dict[str, Any]:
    """Measured by adaptive sampling, so never ``certified``; None where nothing is in the way."""
    return {"clearance": _finite(curve.clearance.distance), "certified": False}


def _optimum(plan: Plan) -> dict[str, Any] | None:
    followed = {"bspline": plan.bspline_arc, "quadratic": plan.quadratic_arc}
    arc = followed.get(plan.followed or "")
    if arc is None:
        return None
    return {"lower_bound": plan.lower_bound, "ratio": arc.length / plan.lower_bound}


def _timing(plan: Plan) -> dict[str, Any] | None:
    if plan.profile is None:
        return None
    profile = plan.profile
    return {
        "curve": plan.followed,
        "t1": profile.t1,
        "t2": profile.t2,
        "t3": profile.t3,
        "duration": profile.duration,
        "peak_speed": profile.peak_speed,
        "theorem_residual": profile.theorem_residual,
        "ms": plan.ms["timing"],
    }


def _arm(plan: Plan, full: bool) -> dict[str, Any] | None:
    if plan.motion is None:
        return None
    motion = plan.motion
    last = len(motion.time) - 1
    keep = np.linspace(0, last, last + 1 if full else min(last + 1, SAMPLES)).round().astype(int)
    return {
        "joints": list(JOINTS),
        "time": motion.time[keep].tolist(),
        "positions": motion.positions[keep].tolist(),
        "tool": motion.tool[keep].tolist(),
        "reachable": motion.reachable,
        "clearance": _finite(motion.clearance),
        "within_limits": motion.within_limits,
        "ms": plan.ms["arm"],
    }


def _finite(distance: float) -> float | None:
    return float(distance) if math.isfinite(distance) else None
