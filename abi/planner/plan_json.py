"""The sections of a plan as plain data: the JSON that scripts read.

A stage that was not reached is None. ``ms`` is what each stage took, [ms].
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from abi.arm.arm import JOINTS
from abi.arm.trajectory import ArmMotion
from abi.clearance.certificate import Certificate
from abi.curves.bspline import BSpline
from abi.curves.curve import ArcLength
from abi.curves.fit import Fit
from abi.curves.quadratic import Quadratic
from abi.curves.speed_profile import Profile
from abi.errors import StageError
from abi.search.graph import Graph
from abi.search.search import SearchResult
from abi.taut.lower_bound import Bound
from abi.taut.taut_path import TautPath
from abi.tet_mesh.exclusion import FreeMesh

SAMPLES = 200
"""Samples of the arm's motion, unless all are asked for."""

Section = dict[str, Any] | None
Times = Mapping[str, float]


def mesh(free: FreeMesh | None, ms: Times, full: bool) -> Section:
    """Stage 1; ``full`` adds nodes and edges."""
    if free is None:
        return None
    whole = free.mesh
    section = {
        "lattice": whole.lattice,
        "pitch": whole.pitch,
        "nodes": len(whole.points),
        "tetrahedra": free.tetrahedra_kept,
        "excluded_nodes": int(free.excluded.sum()),
        "ms": ms["mesh"],
    }
    if full:
        section["points"] = whole.points.tolist()
        section["edges"] = whole.edges.tolist()
        section["excluded"] = np.flatnonzero(free.excluded).tolist()
    return section


def graph(found: Graph | None, ms: Times) -> Section:
    """Stage 2."""
    if found is None:
        return None
    return {
        "nodes": found.free_nodes,
        "edges": found.edge_count,
        "removed_edges": found.removed_edges,
        "ms": ms["graph"],
    }


def searches(found: Sequence[SearchResult], ms: Times) -> list[dict[str, Any]] | None:
    """Stage 3, every search that ran."""
    if not found:
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
            "ms": ms[result.algorithm],
        }
        for result in found
    ]


def path(found: SearchResult | None) -> Section:
    """Stage 3, the path that goes on."""
    if found is None:
        return None
    return {
        "algorithm": found.algorithm,
        "points": found.points.tolist(),
        "length": found.length,
    }


def taut(found: TautPath | None, ms: Times) -> Section:
    """Stage 3½."""
    if found is None:
        return None
    return {
        "points": found.points.tolist(),
        "length": found.length,
        "clearance": _finite(found.clearance),
        "ms": ms["taut"],
    }


def bspline(fit: Fit[BSpline] | None, arc: ArcLength | None, ms: Times) -> Section:
    """Stage 4."""
    if fit is None or arc is None:
        return None
    spline = fit.curve
    return {
        "degree": spline.degree,
        "control_points": spline.control_points.tolist(),
        "knots": spline.knots.tolist(),
        "inserted": spline.inserted,
        "moved": spline.moved,
        "length": arc.length,
        **_clearance(fit),
        "ms": ms["bspline"],
    }


def quadratic(fit: Fit[Quadratic] | None, arc: ArcLength | None, mode: str, ms: Times) -> Section:
    """Stage 5, the curve."""
    if fit is None or arc is None:
        return None
    return {
        "mode": mode,
        "pieces": [
            {"t0": t0, "t1": t1, "coefficients": coefficients.tolist()}
            for t0, t1, coefficients in fit.curve.pieces
        ],
        "note": fit.note or None,
        "length": arc.length,
        **_clearance(fit),
        "ms": ms["quadratic"],
    }


def optimum(bound: Bound | None, kept: Mapping[str, float], followed: str | None) -> Section:
    """A proven bound, ``exact`` where it is the optimum; best known is the best of this plan.

    Args:
        bound: no curve that keeps the clearance is shorter.
        kept: lengths of what keeps the clearance, by stage, [unit]; only these have a ratio to a
            bound for what does not cut through an obstacle.
        followed: name of the curve that the arm executes.
    """
    if bound is None:
        return None
    length = kept.get(followed or "")
    return {
        "lower_bound": bound.length,
        "exact": bound.exact,
        "best_known": min(kept.values(), default=None),
        "ratio": None if length is None else length / bound.length,
    }


def timing(profile: Profile | None, followed: str | None, ms: Times) -> Section:
    """Stage 5, the motion along the curve that is followed."""
    if profile is None:
        return None
    return {
        "curve": followed,
        "t1": profile.t1,
        "t2": profile.t2,
        "t3": profile.t3,
        "duration": profile.duration,
        "peak_speed": profile.peak_speed,
        "theorem_residual": profile.theorem_residual,
        "ms": ms["timing"],
    }


def arm(motion: ArmMotion | None, ms: Times, full: bool) -> Section:
    """Stage 6; at most 200 samples, or ``full`` all."""
    if motion is None:
        return None
    last = len(motion.time) - 1
    keep = np.linspace(0, last, last + 1 if full else min(last + 1, SAMPLES)).round().astype(int)
    measured = motion.clearance_obstacle >= 0
    return {
        "joints": list(JOINTS),
        "time": motion.time[keep].tolist(),
        "positions": motion.positions[keep].tolist(),
        "tool": motion.tool[keep].tolist(),
        "reachable": motion.reachable,
        "clearance": _finite(motion.clearance),
        "clearance_time": motion.clearance_time if measured else None,
        "clearance_obstacle": motion.clearance_obstacle if measured else None,
        "peak_joint_speed": motion.peak_joint_speed.tolist(),
        "limits_passed": [violation._asdict() for violation in motion.limit_violations],
        "within_limits": motion.within_limits,
        "ms": ms["arm"],
    }


def error(found: StageError | None) -> Section:
    """Reason why there is no complete plan."""
    if found is None:
        return None
    return {
        "stage": found.stage,
        "kind": found.kind,
        "message": found.message,
        "hint": found.hint,
    }


def _clearance(fit: Fit[BSpline] | Fit[Quadratic]) -> dict[str, Any]:
    """Clearance, ``certified`` where what was asked for is proven; None with nothing in the way.

    With a certificate the clearance is proven, be it as much as asked for or less.
    """
    proof = fit.clearance.certificate
    return {
        "clearance": _finite(fit.clearance.distance),
        "certified": fit.holds,
        "certificate": None if proof is None else _certificate(proof),
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


def _finite(distance: float) -> float | None:
    return float(distance) if math.isfinite(distance) else None
