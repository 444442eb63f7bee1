"""Weighted A* (Pohl, 1970): trusts the heuristic more, for fewer nodes but a longer path."""

from __future__ import annotations

from abi.search.heap_kernels import best_first_order
from abi.search.task import SearchTask
from abi.search.trace import SearchTrace, trace_of


def weighted_a_star(task: SearchTask) -> SearchTrace:
    """Minimise (2 - w) g + w h: Dijkstra at w = 0, A* at 1, greedy at 2.

    No node is expanded twice; the path is still within :func:`bound` of the shortest (Likhachev,
    Gordon and Thrun, 2003), because the heuristic is consistent.
    """
    arcs, w = task.arcs, task.heuristic_weight
    factors = (2.0 - w, w)
    order = best_first_order(arcs.rows, arcs.estimates, (arcs.start, arcs.goal), factors)
    return trace_of(arcs, order, "best_first", factors)


def bound(w: float) -> float:
    """Bound of the path's cost, as a multiple of the cheapest one's; inf from w = 2 on."""
    if w >= 2:
        return float("inf")
    return max(w / (2 - w), 1.0)
