"""Greedy best-first search: expands the node that seems nearest to the goal, whatever it cost."""

from __future__ import annotations

from abi.search.heap_kernels import best_first_order
from abi.search.task import SearchTask
from abi.search.trace import SearchTrace, trace_of


def greedy_best_first(task: SearchTask) -> SearchTrace:
    """Minimise h; nothing bounds how much longer than the shortest its path may be."""
    arcs, factors = task.arcs, (0.0, 1.0)
    order = best_first_order(arcs.rows, arcs.estimates, (arcs.start, arcs.goal), factors)
    return trace_of(arcs, order, "best_first", factors)
