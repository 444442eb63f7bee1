"""Textbook Bellman-Ford: rounds over all arcs, with detection of negative cycles."""

from __future__ import annotations

import numpy as np

from abi.search.label_kernels import rounds
from abi.search.search_problem import SearchProblem
from abi.search.trace import SearchTrace, finished_trace


def bellman_ford_rounds(problem: SearchProblem) -> SearchTrace:
    """Relax all arcs in rounds until one changes nothing.

    After k rounds the costs are those of the best walks of k arcs at most. Costs may be negative;
    a negative cycle ends the search and is returned in ``cycle``.
    """
    arcs = problem.arcs
    most = len(arcs.points)
    changes, cycle = rounds(arcs.rows, arcs.start, arcs.negative is not None, most, arcs.little)
    order = np.full(len(changes.ends) - 1, -1, np.int32)
    return finished_trace(arcs, "rounds", order, changes, cycle=cycle)
