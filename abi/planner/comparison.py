"""Comparison of further searches on a plan's graph, beside those of every plan."""

from __future__ import annotations

import math
import time
from typing import Any

from abi.errors import AbiError
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.plan import Plan
from abi.search.arcs import Arcs
from abi.search.compare import COMPARED
from abi.search.heuristic import Weight
from abi.search.search_problem import SearchProblem
from abi.search.trace import SearchTrace


def search_problem(plan: Plan, heuristic_weight: float = 1.0) -> SearchProblem:
    """Make the problem of a comparison from a plan's graph.

    Args:
        plan: a plan with a graph.
        heuristic_weight: w of weighted A*, from 0 (Dijkstra) by 1 (A*) to 2 (greedy).

    Raises:
        AbiError: the plan has no graph, or the weight is not from 0 to 2.
    """
    if plan.graph is None:
        raise AbiError("The plan has no graph to search: see its error.")
    if not 0 <= heuristic_weight <= 2:
        raise AbiError(f"heuristic_weight is {heuristic_weight}; expected a number from 0 to 2.")
    scene = plan.scene
    return SearchProblem(
        graph=plan.graph,
        arcs=Arcs.of(plan.graph, scene.search.weight),
        weight=scene.search.weight,
        heuristic_weight=float(heuristic_weight),
        obstacles=ObstacleSet(scene.obstacles),
        margin=scene.spline.clearance + scene.workspace.slack,
    )


def compare(problem: SearchProblem) -> dict[str, tuple[SearchTrace, float]]:
    """Run every search that can take the problem's arcs, one after the other.

    Returns:
        By the names in :data:`abi.search.compare.COMPARED`, every step of the search, and the time
        that it took, [ms], including the recording of the steps.
    """
    found = {}
    for name, search in COMPARED.items():
        if problem.arcs.negative is None or search.substitute is None:
            begin = time.thread_time()
            trace = search.find(problem)
            found[name] = trace, 1e3 * (time.thread_time() - begin)
    return found


def minimised(name: str, problem: SearchProblem) -> Weight:
    """What a search makes least, by its name: the length if it may leave the edges."""
    return "length" if COMPARED[name].any_angle else problem.weight


def compared_searches(problem: SearchProblem) -> list[dict[str, Any]]:
    """The searches as plain data, as in a plan's ``searches``; numbers of a path None without."""
    return [
        {"algorithm": name, "weight": minimised(name, problem)} | _path_of(trace) | {"ms": ms}
        for name, (trace, ms) in compare(problem).items()
    ]


def _path_of(trace: SearchTrace) -> dict[str, Any]:
    """A search's path and its work as plain data."""
    found = len(trace.vertices) > 0
    return {
        "vertices": trace.vertices.tolist() if found else None,
        "points": trace.arcs.points[trace.vertices].tolist() if found else None,
        "length": trace.length if found else None,
        "hops": trace.hops if found else None,
        "cost": trace.cost if math.isfinite(trace.cost) else None,
        "expanded": trace.steps,
        "relaxed": trace.relaxed,
    }
