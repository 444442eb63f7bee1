"""Trace of a search: the order of expansion, and every change of cost and parent."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from abi import arguments
from abi.arrays import FloatArray, IntArray, ShortRepr, read_only
from abi.search.arcs import Arcs
from abi.search.label_kernels import Labels, relax_in_order
from abi.search.search_kernels import reconstruct_path

Queue = Literal["best_first", "first_in", "rounds"]
"""Selection of the next node: the most promising, the first in the queue, or all at once."""

NO_NODES: IntArray = read_only(np.zeros(0, np.int32))


@dataclass(frozen=True, eq=False, repr=False)
class SearchTrace(ShortRepr):
    """A finished search. A step is the expansion of one node, or a round of all.

    In a search from both ends, n is added to the ids of the second search's nodes.

    Attributes:
        arcs: the arcs that were searched.
        queue: which node comes next.
        factors: weights a and b of g and h in the sum that a best-first search minimises.
        sides: 2 for a search from both ends, else 1.
        order: (m,) node of each step, -1 for a round.
        examined: (m + 1,) arcs examined before each step and in all.
        changes: of cost and parent, step by step.
        vertices: (k,) the path from start to goal; empty when there is none.
        cost: of the goal by the search's labels; inf if it was not reached.
        cycle: (c,) nodes of a negative cycle; empty when none was found.
    """

    arcs: Arcs
    queue: Queue
    factors: tuple[float, float]
    sides: int
    order: IntArray
    examined: NDArray[np.int64]
    changes: Labels
    vertices: IntArray
    cost: float
    cycle: IntArray = field(default_factory=lambda: NO_NODES)

    @property
    def steps(self) -> int:
        """Number of steps m."""
        return len(self.order)

    @property
    def relaxed(self) -> int:
        """Arcs examined in all."""
        return int(self.examined[-1])

    @property
    def hops(self) -> int:
        """Number of edges of the path; -1 without one."""
        return len(self.vertices) - 1

    @property
    def length(self) -> float:
        """Length of the path, [unit]; inf without one."""
        if not len(self.vertices):
            return np.inf
        legs = np.diff(self.arcs.points[self.vertices], axis=0)
        return float(np.linalg.norm(legs, axis=1).sum())


def last_labels(trace: SearchTrace, step: int) -> tuple[FloatArray, IntArray]:
    """Costs and parents (n or 2n,) after a number of steps; inf and -1 for unreached nodes."""
    ends, nodes, costs, parents = trace.changes
    total, count = trace.sides * len(trace.arcs.points), int(ends[step])
    cost, parent = np.full(total, np.inf), np.full(total, -1, np.int32)
    # of several changes of a node the last one stays
    cost[nodes[:count]] = costs[:count]
    parent[nodes[:count]] = parents[:count]
    return cost, parent


def trace_of(
    arcs: Arcs,
    order: IntArray,
    queue: Queue,
    factors: tuple[float, float] = (1.0, 0.0),
    sides: int = 1,
    reopens: bool = False,
) -> SearchTrace:
    """The trace of a search with a known order of expansion.

    Args:
        arcs: the arcs that were searched.
        order: (m,) expanded nodes.
        queue: which node came next.
        factors: weights of g and h.
        sides: 2 for a search from both ends.
        reopens: whether a node's cost may decrease after its expansion.
    """
    n = len(arcs.points)
    sides = arguments.integer("sides", sides, 1, 2)
    order = arguments.ids("order", order, (-1,), sides * n)
    starts = np.array([arcs.start, arcs.goal + n][:sides], np.int32)
    stops = _stops(arcs, order, queue, sides)
    scanned = read_only(order[:-1].copy()) if stops else order
    changes = relax_in_order(arcs.rows, scanned, read_only(starts), sides, reopens, arcs.little)
    if stops:
        changes = changes._replace(ends=np.append(changes.ends, changes.ends[-1]))
    return finished_trace(arcs, queue, order, changes, factors, sides)


def finished_trace(
    arcs: Arcs,
    queue: Queue,
    order: IntArray,
    changes: Labels,
    factors: tuple[float, float] = (1.0, 0.0),
    sides: int = 1,
    cycle: IntArray = NO_NODES,
) -> SearchTrace:
    """The trace of a search, with the path that its final labels give.

    Args:
        arcs, queue, order, factors, sides, cycle: see :class:`SearchTrace`.
        changes: as they were recorded.
    """
    n = len(arcs.points)
    order = arguments.bits("order", order, (-1,), -1, sides * n - 1)  # -1 for a round
    cycle = arguments.ids("cycle", cycle, (-1,), n)
    counts = np.full(len(order), len(arcs.rows.indices))
    if queue != "rounds":
        counts = np.diff(arcs.rows.indptr)[order % n]
        counts[len(order) - _stops(arcs, order, queue, sides) :] = 0
    examined = np.concatenate(([0], np.cumsum(counts, dtype=np.int64)))
    for array in (order, examined, cycle, *changes):
        array.setflags(write=False)
    trace = SearchTrace(
        arcs, queue, factors, sides, order, examined, changes, NO_NODES, np.inf, cycle
    )
    cost, parent = last_labels(trace, trace.steps)
    least, found = float(cost[arcs.goal]), NO_NODES
    if sides == 2:
        meeting = int((cost[:n] + cost[n:]).argmin())
        least = float(cost[meeting] + cost[meeting + n])
        if np.isfinite(least):
            ahead, back = (reconstruct_path(parent, node) for node in (meeting, meeting + n))
            found = np.concatenate([ahead, back[-2::-1] - n])
    elif np.isfinite(least) and not len(cycle):
        found = reconstruct_path(parent, arcs.goal)
    return replace(trace, vertices=read_only(found), cost=least)


def _stops(arcs: Arcs, order: IntArray, queue: Queue, sides: int) -> bool:
    """Check whether a search ends at the goal without examining the goal's arcs."""
    at_goal = len(order) > 0 and int(order[-1]) == arcs.goal
    return sides == 1 and queue == "best_first" and at_goal
