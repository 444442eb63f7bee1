"""Lifelong Planning A* (Koenig, Likhachev and Furcy, 2004): repairs the last search's result.

It keeps what it knows of every node. Where an obstacle has moved, nodes disagree with their
neighbours; only these, and the nodes that this affects, are expanded again.
"""

from __future__ import annotations

import numpy as np

from abi.arrays import read_only
from abi.errors import AbiError
from abi.search.arcs import Arcs
from abi.search.heap_kernels import repair_order
from abi.search.search import Expanded


def can_repair(before: Arcs, now: Arcs) -> bool:
    """Check whether both have the same nodes, start and goal."""
    ends = (before.start, before.goal) == (now.start, now.goal)
    both_ways = before.negative is None and now.negative is None
    return ends and both_ways and np.array_equal(before.points, now.points)


def lifelong_a_star(before: Arcs, now: Arcs) -> tuple[Expanded, int]:
    """Search ``before``, then repair that search for ``now``.

    Returns:
        What the repaired search finds, with the nodes that were expanded and the arcs that were
        examined for the repair alone; and the number of nodes whose arcs have changed.

    Raises:
        AbiError: nodes, start or goal differ, or an arc has one direction only.
    """
    if not can_repair(before, now):
        raise AbiError("The search before was on other nodes or between other ends: begin anew.")
    ends = (now.start, now.goal)
    order, relaxed, changed, cost, parent = repair_order(before.rows, now.rows, now.estimates, ends)
    found = read_only(cost), read_only(parent), read_only(order), int(relaxed)
    return found, int(np.count_nonzero(changed))
