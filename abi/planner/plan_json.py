"""Sections of a plan as plain data: the JSON that scripts read.

A stage that was not reached is None. ``ms`` holds the time of each stage, [ms]; ``full`` adds what
most readers do without, such as the nodes of the mesh.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from abi.arm_planning.joint_rates import JointRates
from abi.arm_planning.joint_search.held_span import HeldSpan
from abi.arm_planning.joint_search.search_joints import JointSearch
from abi.arm_planning.motion.arm_clearance import ArmClearance
from abi.arm_planning.motion.links_clearance import links_clearance
from abi.arm_planning.motion.trajectory import ArmMotion, Violation
from abi.arrays import FloatArray
from abi.curves.bspline import BSpline
from abi.curves.clearance.certificate import Certificate
from abi.curves.cubic_profile import PathProfile
from abi.curves.fit import Fit
from abi.curves.fit_quadratic import Mode
from abi.curves.quadratic import Quadratic
from abi.curves.three_phase_profile import ThreePhaseProfile
from abi.errors import StageError
from abi.obstacles.obstacle_set import Obstacle
from abi.planner.arm_certificate_json import arm_certificate
from abi.robot.any_arm import AnyArm
from abi.search.graph import Graph
from abi.search.search import SearchResult
from abi.search.taut.lower_bound import Bound
from abi.search.taut.taut_path import TautPath
from abi.tet_mesh.exclusion import FreeMesh

SAMPLES = 200
"""Largest number of samples of the arm's motion, unless the JSON is full."""

Section = dict[str, Any] | None
Times = Mapping[str, float]


def mesh(free: FreeMesh | None, ms: Times, full: bool) -> Section:
    """Stage 1; ``full`` adds nodes and edges."""
    if free is None:
        return None
    mesh = free.mesh
    section = {
        "lattice": mesh.lattice,
        "pitch": mesh.pitch,
        "nodes": len(mesh.points),
        "tetrahedra": free.tetrahedra_kept,
        "excluded_nodes": int(free.excluded.sum()),
        "ms": ms["mesh"],
    }
    if full:
        section["points"] = mesh.points.tolist()
        section["edges"] = mesh.edges.tolist()
        section["excluded"] = np.flatnonzero(free.excluded).tolist()
    return section


def graph(graph: Graph | None, ms: Times) -> Section:
    """Stage 2."""
    if graph is None:
        return None
    return {
        "nodes": graph.free_nodes,
        "edges": graph.edge_count,
        "removed_edges": graph.removed_edges,
        "ms": ms["graph"],
    }


def searches(results: Sequence[SearchResult], ms: Times) -> list[dict[str, Any]] | None:
    """Stage 3, every search that ran."""
    if not results:
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
        for result in results
    ]


def path(path: SearchResult | None) -> Section:
    """Stage 3, the path of the chosen search."""
    if path is None:
        return None
    return {
        "algorithm": path.algorithm,
        "points": path.points.tolist(),
        "length": path.length,
    }


def taut(taut: TautPath | None, ms: Times) -> Section:
    """Stage 3½."""
    if taut is None:
        return None
    return {
        "points": taut.points.tolist(),
        "length": taut.length,
        "clearance": finite(taut.clearance),
        "ms": ms["taut"],
    }


def bspline(fit: Fit[BSpline] | None, ms: Times) -> Section:
    """Stage 4."""
    if fit is None:
        return None
    spline = fit.curve
    return {
        "degree": spline.degree,
        "control_points": spline.control_points.tolist(),
        "knots": spline.knots.tolist(),
        "inserted": spline.inserted,
        "moved": spline.moved,
        "length": fit.arc.length,
        **_clearance(fit),
        "ms": ms["bspline"],
    }


def quadratic(fit: Fit[Quadratic] | None, mode: Mode, ms: Times) -> Section:
    """Stage 5, the curve."""
    if fit is None:
        return None
    return {
        "mode": mode,
        "pieces": [
            {"t0": t0, "t1": t1, "coefficients": coefficients.tolist()}
            for t0, t1, coefficients in fit.curve.pieces
        ],
        "note": fit.note or None,
        "length": fit.arc.length,
        **_clearance(fit),
        "ms": ms["quadratic"],
    }


def optimum(bound: Bound | None, kept: Mapping[str, float], followed: str | None) -> Section:
    """Lower bound, ``exact`` where it is the optimum, beside the best of the lengths ``kept``.

    Those are of the paths and curves that keep the clearance, by stage; the followed curve has a
    ratio to the bound only if it is among them.
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


def timing(
    profile: PathProfile | None, followed: str | None, tilt: float | None, ms: Times
) -> Section:
    """Stage 5, the motion along the curve that the arm follows, and its phases if it has any."""
    if profile is None:
        return None
    phases = profile if isinstance(profile, ThreePhaseProfile) else None
    return {
        "curve": followed,
        "t1": None if phases is None else phases.t1,
        "t2": None if phases is None else phases.t2,
        "t3": None if phases is None else phases.t3,
        "duration": profile.duration,
        "peak_speed": profile.peak_speed,
        "theorem_residual": None if phases is None else phases.theorem_residual,
        "liquid_tilt": tilt,
        "ms": ms["timing"],
    }


def joint_search(found: JointSearch | None, model: AnyArm | None, ms: Times, full: bool) -> Section:
    """The search in the space of the joints; ``full`` adds its trees, and the tool's places."""
    if found is None or found.path is None or model is None:
        return None
    section: dict[str, Any] = {
        "path": found.path.tolist(),
        "length": found.length,
        "samples": found.samples,
        "nodes": [len(tree.positions) for tree in found.trees],
        "proofs": found.proofs,
        "refused": found.refused,
        "ms": ms["joint_search"],
    }
    if full:
        section["trees"] = [
            {
                "positions": tree.positions.tolist(),
                "parents": tree.parents.tolist(),
                "tool": model.tool(tree.positions).tolist(),
            }
            for tree in found.trees
        ]
    return section


def arm(
    model: AnyArm | None,
    motion: ArmMotion | None,
    clearance: ArmClearance | None,
    obstacles: Sequence[Obstacle],
    limits: tuple[JointRates | None, Sequence[Violation]],
    held: Sequence[HeldSpan],
    ms: Times,
    full: bool,
) -> Section:
    """Stage 6; at most ``SAMPLES`` samples, or ``full`` all, with the capsules at each.

    Of every sample kept it has the links' distance to the obstacles. ``limits`` are the joints'
    rates beside theirs, and where limits are passed; ``held`` is when a direction is kept.
    """
    rates, passed = limits
    if model is None or motion is None or clearance is None or rates is None:
        return None
    last = len(motion.time) - 1
    step = 1 if full else _stride(last)
    keep = np.arange(0, last + 1, step).astype(int)  # evenly: users take differences
    has_obstacles = clearance.obstacle >= 0
    clearances = links_clearance(clearance, motion, model, obstacles, keep)
    nearest = {"link": clearance.link, "obstacle": clearance.obstacle, "time": clearance.time}
    section = {
        "joints": list(motion.joints),
        "time": motion.time[keep].tolist(),
        "positions": motion.positions[keep].tolist(),
        "tool": motion.tool[keep].tolist(),
        "elbow": motion.elbow if model.has_elbow else None,
        "reachable": motion.reachable,
        "clearance": finite(clearance.distance),
        "clearances": None if clearances is None else _finites(clearances),
        "certified": clearance.certified,
        "nearest": nearest if has_obstacles else None,
        "clearance_time": clearance.time if has_obstacles else None,
        "clearance_obstacle": clearance.obstacle if has_obstacles else None,
        "contacts": [contact._asdict() for contact in clearance.contacts],
        "allowed": [contact._asdict() for contact in clearance.allowed],
        "apart_only": list(clearance.apart_only),
        "certificate": arm_certificate(model, clearance),
        "peak_joint_speed": motion.peak_joint_speed.tolist(),
        "joint_speed_limits": _finites(rates.speed_limits),
        "peak_joint_acceleration": _peaks(rates.accelerations),
        "joint_acceleration_limits": _finites(rates.acceleration_limits),
        "torques": None if rates.torques is None else rates.torques[keep].tolist(),
        "peak_joint_torque": _peaks(rates.torques),
        "joint_torque_limits": _finites(rates.torque_limits),
        "limits_passed": [violation._asdict() for violation in passed],
        "within_limits": not passed,
        "axis": held[0]._asdict() if held else None,
        "ms": ms["arm"],
    }
    if full:
        ends = model.place(motion.positions[keep])
        section["capsules"] = [
            {
                "link": link,
                "radius": radius,
                "from": ends[:, k, 0].tolist(),
                "to": ends[:, k, 1].tolist(),
            }
            for k, (link, radius) in enumerate(
                zip(model.capsule_links, model.radii.tolist(), strict=True)
            )
        ]
    return section


def _stride(last: int) -> int:
    """Least stride that meets the last sample and leaves at most ``SAMPLES``."""
    return next(k for k in range(1, last + 2) if last % k == 0 and last // k < SAMPLES)


def error(stage_error: StageError | None) -> Section:
    """Error of the stage that has no result."""
    if stage_error is None:
        return None
    return {
        "stage": stage_error.stage,
        "kind": stage_error.kind,
        "message": stage_error.message,
        "hint": stage_error.hint,
    }


def _clearance(fit: Fit[BSpline] | Fit[Quadratic]) -> dict[str, Any]:
    """Clearance, None without obstacles; ``certified`` where it is proven to be the required one.

    With a certificate the clearance itself is proven, be it the required one or less.
    """
    proof = fit.clearance.certificate
    return {
        "clearance": finite(fit.clearance.distance),
        "certified": fit.holds,
        "certificate": None if proof is None else _certificate(proof),
    }


def _certificate(proof: Certificate) -> dict[str, Any]:
    columns = (proof.pieces.tolist(), proof.obstacle.tolist(), proof.directions.tolist())
    return {
        "margin": finite(proof.margin),
        "planes": [
            {"t0": t0, "t1": t1, "obstacle": obstacle, "direction": direction}
            for (t0, t1), obstacle, direction in zip(*columns, strict=True)
        ],
    }


def _peaks(values: FloatArray | None) -> list[float] | None:
    """Largest size of each column."""
    return None if values is None else [float(peak) for peak in np.abs(values).max(axis=0)]


def _finites(values: FloatArray) -> list[float | None]:
    return [finite(value) for value in values]


def finite(distance: float) -> float | None:
    """The distance; None where there is nothing that it could be measured to."""
    return float(distance) if math.isfinite(distance) else None
