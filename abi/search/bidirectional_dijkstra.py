"""Dijkstra's algorithm from both ends: two small balls instead of a large one."""

from __future__ import annotations

from abi.search.heap_kernels import bidirectional_order
from abi.search.task import SearchTask
from abi.search.trace import SearchTrace, trace_of


def bidirectional_dijkstra(task: SearchTask) -> SearchTrace:
    """Search from start and goal until their radii add up to the cost of the best path found."""
    arcs = task.arcs
    order = bidirectional_order(arcs.rows, (arcs.start, arcs.goal))
    return trace_of(arcs, order, "best_first", sides=2, reopens=True)
