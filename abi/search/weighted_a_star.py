"""Weighted A* (Pohl, 1970): trusts the heuristic more, for fewer nodes but a longer path."""

from __future__ import annotations

from abi.search.heap_kernels import best_first_order
from abi.search.task import SearchTask
from abi.search.trace import SearchTrace, trace_of


def best_first(task: SearchTask, factors: tuple[float, float]) -> SearchTrace:
    """Minimise a g + b h, as in the textbook: no node is expanded twice.

    Greedy search, (0, 1), expands the node that seems nearest to the goal, whatever it cost;
    nothing bounds how much longer than the shortest its path may be.
    """
    arcs = task.arcs
    order = best_first_order(arcs.rows, arcs.estimates, (arcs.start, arcs.goal), factors)
    return trace_of(arcs, order, "best_first", factors)


def weighted_a_star(task: SearchTask) -> SearchTrace:
    """Minimise (2 - w) g + w h: Dijkstra at w = 0, A* at 1, greedy at 2.

    The path costs at most max(w / (2 - w), 1) times the least (Likhachev, Gordon and Thrun, 2003),
    though no node is expanded twice, because the heuristic is consistent.
    """
    w = task.heuristic_weight
    return best_first(task, (2.0 - w, w))
