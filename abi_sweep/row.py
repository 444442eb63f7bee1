"""A row of a study's table: the findings of one plan, in numbers and words for JSON and CSV."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from abi.planner.plan import Plan
from abi.planner.plan_json import finite

Row = dict[str, Any]

_PACKAGES = {"abi": "abi-visualiser", "numpy": "numpy", "scipy": "scipy", "numba": "numba"}


@cache
def versions() -> Mapping[str, str]:
    """Versions that a plan may depend on, by column."""
    found = {"python": platform.python_version(), "system": platform.system()}
    for column, package in _PACKAGES.items():
        try:
            found[column] = version(package)
        except PackageNotFoundError:
            found[column] = "not installed"
    return found


def plan_row(plan: Plan) -> Row:
    """Findings of a plan: lengths and distances [unit], gaps to the proven bound, times [ms].

    A value that the plan does not have is None. ``complete`` is whether the plan has no error.
    """
    lengths = plan.lengths
    bound = None if plan.optimum is None else plan.optimum.length
    kept = plan.kept_lengths  # of no other curve does the bound say anything
    gaps = {
        f"{name}_gap": kept[name] / bound - 1 if bound and name in kept else None
        for name in lengths
    }
    return {
        "complete": plan.error is None,
        "error": None if plan.error is None else plan.error.kind,
        "unit": plan.scene.unit,
        "mesh_seed": plan.scene.mesh.seed,
        "nodes": None if plan.mesh is None else len(plan.mesh.points),
        "edges": None if plan.graph is None else plan.graph.edge_count,
        "expanded": None if plan.path is None else plan.path.expanded,
        **lengths,
        "bound": bound,
        "bound_exact": None if plan.optimum is None else plan.optimum.exact,
        **gaps,
        **_clearances(plan),
        "duration": None if plan.profile is None else plan.profile.duration,
        **{f"{stage}_ms": time or None for stage, time in plan.ms.items()},
        "total_ms": plan.total_ms,
    }


def _clearances(plan: Plan) -> Row:
    """Distances to the obstacles, and whether they are proven to be what is asked for."""
    found: Row = {"path_clearance": finite(plan.path_clearance)}
    for name, fit in (("bspline", plan.bspline), ("quadratic", plan.quadratic)):
        found[f"{name}_clearance"] = None if fit is None else finite(fit.clearance.distance)
        found[f"{name}_proven"] = None if fit is None else fit.holds
    arm = plan.arm_clearance
    found["arm_clearance"] = None if arm is None else finite(arm.distance)
    found["arm_proven"] = None if arm is None else arm.certified
    return found
