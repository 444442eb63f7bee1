"""Textbook Bellman-Ford: rounds over all arcs, with detection of negative cycles."""

from __future__ import annotations

import numpy as np

from abi.arrays import read_only
from abi.search.label_kernels import rounds
from abi.search.task import SearchTask
from abi.search.trace import NO_NODES, SearchTrace, with_path


def bellman_ford_rounds(task: SearchTask) -> SearchTrace:
    """Relax all arcs in rounds until one changes nothing.

    After k rounds the costs are those of the best walks of k arcs at most. Costs may be negative;
    a negative cycle ends the search and is returned in ``cycle``.
    """
    arcs = task.arcs
    most = len(arcs.points)
    ends, nodes, costs, parents, cycle = rounds(
        arcs.rows, arcs.start, arcs.negative is not None, most, arcs.little
    )
    count = len(ends) - 1
    examined = len(arcs.rows.indices) * np.arange(count + 1, dtype=np.int64)
    trace = SearchTrace(
        arcs=arcs,
        queue="rounds",
        factors=(1.0, 0.0),
        sides=1,
        order=read_only(np.full(count, -1, np.int32)),
        examined=read_only(examined),
        ends=read_only(ends),
        nodes=read_only(nodes),
        costs=read_only(costs),
        parents=read_only(parents),
        vertices=NO_NODES,
        cycle=read_only(cycle),
    )
    return with_path(trace)
