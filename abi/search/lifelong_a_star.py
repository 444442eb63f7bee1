"""Lifelong Planning A* (Koenig, Likhachev and Furcy, 2004): repairs the last search's result.

It keeps what it knows of every node. Where an obstacle has moved, nodes disagree with their
neighbours; only these, and the nodes that this affects, are expanded again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from abi.arrays import IntArray, read_only
from abi.errors import AbiError
from abi.search.arcs import Arcs
from abi.search.heap_kernels import repair_order
from abi.search.search_kernels import reconstruct_path
from abi.search.trace import NO_NODES


@dataclass(frozen=True, eq=False)
class Repair:
    """Result of a search that was repaired after its graph changed.

    Attributes:
        arcs: the present arcs.
        vertices: (k,) the path from start to goal; empty when there is none.
        cost: of the path; inf without one.
        order: (m,) nodes expanded for the repair; one may come twice.
        relaxed: number of arcs examined.
        changed: number of nodes whose arcs have changed.
    """

    arcs: Arcs
    vertices: IntArray
    cost: float
    order: IntArray
    relaxed: int
    changed: int

    @property
    def expanded(self) -> int:
        """Number of nodes expanded for the repair."""
        return len(self.order)


def can_repair(before: Arcs, now: Arcs) -> bool:
    """Check whether both have the same nodes, start and goal."""
    ends = (before.start, before.goal) == (now.start, now.goal)
    both_ways = before.negative is None and now.negative is None
    return ends and both_ways and np.array_equal(before.points, now.points)


def lifelong_a_star(before: Arcs, now: Arcs) -> Repair:
    """Search ``before``, then repair that search for ``now``.

    Raises:
        AbiError: nodes, start or goal differ, or an arc has one direction only.
    """
    if not can_repair(before, now):
        raise AbiError("The search before was on other nodes or between other ends: begin anew.")
    ends = (now.start, now.goal)
    order, relaxed, changed, cost, parent = repair_order(before.rows, now.rows, now.estimates, ends)
    has_path = np.isfinite(cost[now.goal])
    return Repair(
        now,
        read_only(reconstruct_path(parent, now.goal)) if has_path else NO_NODES,
        float(cost[now.goal]),
        read_only(order),
        int(relaxed),
        int(np.count_nonzero(changed)),
    )
