"""A plan as plain data: the JSON that scripts read."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from abi.arm.arm import JOINTS
from abi.clearance.certificate import Certificate
from abi.curves.bspline import BSpline
from abi.curves.fit import Fit
from abi.curves.quadratic import Quadratic

if TYPE_CHECKING:
    from abi.planner.diagnosis import Reason
    from abi.planner.plan import Plan

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
        "taut": _taut(plan),
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


def reason(found: Reason | None) -> dict[str, Any] | None:
    """What was found out about a plan's error, as plain data; None where nothing was."""
    if found is None:
        return None
    return {"message": found.message, "hint": found.hint, "change": found.change}


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
        "degree": plan.bspline.curve.degree,
        "control_points": plan.bspline.curve.control_points.tolist(),
        "knots": plan.bspline.curve.knots.tolist(),
        "inserted": plan.bspline.curve.inserted,
        "moved": plan.bspline.curve.moved,
        "length": plan.bspline_arc.length,
        **_clear(plan.bspline),
        "ms": plan.ms["bspline"],
    }


def _quadratic(plan: Plan) -> dict[str, Any] | None:
    if plan.quadratic is None or plan.quadratic_arc is None:
        return None
    return {
        "mode": plan.scene.quadratic.mode,
        "pieces": [
            {"t0": t0, "t1": t1, "coefficients": coefficients.tolist()}
            for t0, t1, coefficients in plan.quadratic.curve.pieces
        ],
        "note": plan.quadratic.note or None,
        "length": plan.quadratic_arc.length,
        **_clear(plan.quadratic),
        "ms": plan.ms["quadratic"],
    }


def _clear(curve: Fit[BSpline] | Fit[Quadratic]) -> dict[str, Any]:
    """``certified`` where the distance asked for is proven; None where nothing is in the way.

    With a certificate the clearance is proven, be it as much as asked for or less.
    """
    found = curve.clearance
    return {
        "clearance": _finite(found.distance),
        "certified": curve.holds,
        "certificate": None if found.certificate is None else _certificate(found.certificate),
    }


def _certificate(proof: Certificate) -> dict[str, Any]:
    columns = (proof.pieces.tolist(), proof.obstacle.tolist(), proof.directions.tolist())
    return {
        "margin": _finite(proof.margin),
        "planes": [
            {"t0": t0, "t1": t1, "obstacle": obstacle, "direction": direction}
            for (t0, t1), obstacle, direction in zip(*columns, strict=True)
        ],
    }


def _taut(plan: Plan) -> dict[str, Any] | None:
    if plan.taut is None:
        return None
    return {
        "points": plan.taut.points.tolist(),
        "length": plan.taut.length,
        "clearance": _finite(plan.taut.clearance),
        "ms": plan.ms["taut"],
    }


def _optimum(plan: Plan) -> dict[str, Any] | None:
    """A proven bound, ``exact`` where it is the optimum; best known is the best of this plan."""
    if plan.optimum is None:
        return None
    arc = {"bspline": plan.bspline_arc, "quadratic": plan.quadratic_arc}.get(plan.followed or "")
    # what cuts through an obstacle has no ratio to a bound for what does not
    kept = plan.followed_curve is not None and plan.followed_curve.holds
    return {
        "lower_bound": plan.optimum.length,
        "exact": plan.optimum.exact,
        "best_known": plan.best_known,
        "ratio": arc.length / plan.optimum.length if arc is not None and kept else None,
    }


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
        "clearance_time": motion.clearance_time if motion.clearance_obstacle >= 0 else None,
        "clearance_obstacle": motion.clearance_obstacle if motion.clearance_obstacle >= 0 else None,
        "peak_joint_speed": motion.peak_joint_speed.tolist(),
        "limits_passed": [violation._asdict() for violation in motion.limit_violations],
        "within_limits": motion.within_limits,
        "ms": plan.ms["arm"],
    }


def _finite(distance: float) -> float | None:
    return float(distance) if math.isfinite(distance) else None
