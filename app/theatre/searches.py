"""The searches of a plan's graph that the theatre shows, each searched once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from abi.arrays import read_only
from abi.planner.comparison import search_problem
from abi.planner.plan import Plan
from abi.search.compare import COMPARED
from abi.search.negative_arc import with_negative_arc
from abi.search.search_problem import SearchProblem
from abi.search.trace import SearchTrace, trace_of

EDGES = {"none": "", "one": "negative", "one, with a cycle": "cycle"}
"""Kinds of negative edge, by what they are called on the page."""
_MOST = 12
"""Traces that are kept."""


class TheatreSearches:
    """Problems and traces by the kind of negative edge: none (empty), ``negative`` or ``cycle``."""

    def __init__(self, plan: Plan | None = None) -> None:
        self._plan = plan
        self._problems: dict[str, SearchProblem] = {}
        self._followed: dict[tuple[int, ...], SearchTrace] = {}
        self._traces: dict[tuple[str, str, float], SearchTrace] = {}

    def are_of(self, plan: Plan) -> bool:
        """Check whether they search a plan's graph, by its weight."""
        own = self._plan
        return (
            own is not None
            and own.graph is plan.graph
            and own.scene.search.weight == plan.scene.search.weight
        )

    def prepare(self, kind: str) -> None:
        """Place the negative edge of that kind.

        Raises:
            StageError: there is no place for one.
        """
        assert self._plan is not None
        if "" not in self._problems:
            self._problems[""] = search_problem(self._plan)
        if kind not in self._problems:
            self._problems[kind] = with_negative_arc(self._problems[""], kind == "cycle")

    def followed(self, order: tuple[int, ...]) -> SearchTrace:
        """Trace of a best-first search that expands nodes in a given order."""
        if order not in self._followed:
            self.prepare("")
            nodes = read_only(np.array(order, np.int32))
            self._followed[order] = trace_of(self._problems[""].arcs, nodes, "best_first")
        return self._followed[order]

    def trace(self, name: str, kind: str, weight: float) -> SearchTrace:
        """Trace of a search, with the edge of a kind that was prepared.

        Args:
            name: in :data:`abi.search.compare.COMPARED`.
            kind: of the negative edge.
            weight: of the heuristic, where the search has one to choose.
        """
        w = float(weight) if name == "weighted_a_star" else 0.0
        key = (name, kind, w)
        if key not in self._traces:
            if len(self._traces) >= _MOST:
                self._traces.clear()
            problem = replace(self._problems[kind], heuristic_weight=w)
            self._traces[key] = COMPARED[name].find(problem)
        return self._traces[key]
