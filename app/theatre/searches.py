"""The searches of a plan's graph that the theatre shows, each searched once."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from abi.arrays import read_only
from abi.planner.comparison import search_problem
from abi.planner.plan import Plan
from abi.search.compare import COMPARED
from abi.search.negative_arc import with_negative_arc
from abi.search.search_problem import SearchProblem
from abi.search.trace import SearchTrace, trace_of
from app.shared.computed_once import once_a_plan

EDGES = {"none": "", "one": "negative", "one, with a cycle": "cycle"}
"""Kinds of negative edge, by what they are called on the page."""
_MOST = 64
"""Traces that are kept of a plan's graph with one kind of edge, for all tabs that show them."""


def are_searched_alike(plan: Plan, other: Plan) -> bool:
    """Check whether the searches of two plans are the same: in one graph, by one weight."""
    alike = plan.scene.search.weight == other.scene.search.weight
    return plan.graph is other.graph and alike


@once_a_plan
def problem_with(plan: Plan, kind: str) -> SearchProblem:
    """What is searched in a plan's graph, with a negative edge of a kind, or none (empty).

    Raises:
        StageError: there is no place for one.
    """
    return (
        with_negative_arc(problem_with(plan, ""), kind == "cycle") if kind else search_problem(plan)
    )


@once_a_plan
def followed(plan: Plan, order: tuple[int, ...]) -> SearchTrace:
    """Trace of a best-first search of a plan's graph that expands nodes in a given order."""
    nodes = read_only(np.array(order, np.int32))
    return trace_of(problem_with(plan, "").arcs, nodes, "best_first")


def trace(plan: Plan, name: str, kind: str, weight: float) -> SearchTrace:
    """Trace of a search of a plan's graph.

    Args:
        plan: with a graph.
        name: in :data:`abi.search.compare.COMPARED`.
        kind: of negative edge, see :func:`problem_with`.
        weight: of the heuristic, where the search has one to choose.

    Raises:
        StageError: there is no place for the edge.
    """
    return _traces(plan, kind)(name, float(weight) if name == "weighted_a_star" else 0.0)


@once_a_plan
def _traces(plan: Plan, kind: str) -> Callable[[str, float], SearchTrace]:
    """Function that finds traces by name and weight, and keeps the latest."""
    return functools.lru_cache(_MOST)(functools.partial(_find, problem_with(plan, kind)))


def _find(problem: SearchProblem, name: str, weight: float) -> SearchTrace:
    return COMPARED[name].find(replace(problem, heuristic_weight=weight))
