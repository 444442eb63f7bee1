"""Bellman-Ford with a queue, compiled by numba; see :mod:`abi.search.best_first_kernels`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abi.arrays import ByteArray, FloatArray, IntArray
from abi.compilation.borrowed import borrowed, held
from abi.compilation.jitable import jitable
from abi.compiled import compiled
from abi.search.search_kernels import EXAMPLE, LITTLE, Problem
from abi.tet_mesh.adjacency_kernels import (
    ALL_INTERIOR,
    CSR,
    INTERIOR_DIRECTIONS,
    LINKED_BIT,
    across,
    cell,
    ones,
)


class _RoundLabels(NamedTuple):
    """Knowledge of the nodes.

    Attributes:
        cost: (n,) from the start, so far.
        parent: (n,) node before.
        waiting: (n,) whether it waits for its turn.
        order: nodes in their turns; those that had theirs stay.
    """

    cost: FloatArray
    parent: IntArray
    waiting: ByteArray
    order: IntArray


@compiled(example=EXAMPLE)
def bellman_ford(problem: Problem) -> tuple[FloatArray, IntArray, IntArray, int]:
    """Bellman-Ford with a queue (Moore, 1959): runs until no cost can be lowered.

    Only nodes whose cost was lowered are examined again, first come, first served. Takes and
    returns the same as ``best_first``, but needs no goal and no metric, and expands a node as often
    as its cost was lowered.
    """
    adjacency, opened, links, ends, largest, _ = problem
    shape, offsets, _, _, indptr, indices = adjacency
    open_directions, weights = opened
    tails, heads, link_weights = links
    kind, nodes, directions, cross = shape.kind, shape.nodes, shape.directions, shape.cross
    total = nodes + ends.own
    cost, parent = np.full(total, np.inf), np.empty(total, np.int32)
    waiting = np.zeros(total, np.uint8)
    most = shape.most + len(tails)
    order = np.empty(total + most, np.int32)
    # how many had their turn, and how many have or had a place in the order
    expanded, last, relaxed = 0, 1, 0
    little = LITTLE * largest
    cost[ends.start], parent[ends.start], order[0] = 0.0, -1, ends.start
    while expanded < last:
        if last + most > len(order):
            order = np.concatenate((order, np.empty_like(order)))
        own = _RoundLabels(cost, parent, waiting, order)
        labels = borrowed(own)
        while expanded < last and last + most <= len(order):
            node = order[expanded]
            waiting[node] = 0
            expanded += 1
            so_far, linked = cost[node], True
            if node < nodes:
                bits = open_directions[node]
                linked = (bits >> LINKED_BIT) & 1 == 1
                if kind == CSR:
                    for k in range(indptr[node], indptr[node + 1]):
                        if weights[k] < np.inf:
                            relaxed += 1
                            through = so_far + weights[k]
                            last = _lower(labels, node, indices[k], through, little, last)
                else:
                    i, j, h = cell(shape, node)
                    row = (i & 1) * directions
                    other = across(shape, i, j, h)
                    if bits == ALL_INTERIOR:  # as most have: nothing to look at but the costs
                        relaxed += INTERIOR_DIRECTIONS
                        for k in range(INTERIOR_DIRECTIONS):
                            neighbour = (other if k < cross else node) + offsets[row + k]
                            through = so_far + weights[k]
                            last = _lower(labels, node, neighbour, through, little, last)
                    else:
                        relaxed += ones(bits)
                        others = (bits >> INTERIOR_DIRECTIONS) & 63
                        for k in range(directions if others else INTERIOR_DIRECTIONS):
                            if (bits >> k) & 1:
                                neighbour = (other if k < cross else node) + offsets[row + k]
                                through = so_far + weights[k]
                                last = _lower(labels, node, neighbour, through, little, last)
            if linked:
                for k in range(len(tails)):
                    tail, head = tails[k], heads[k]
                    if tail == node or head == node:
                        neighbour = head if tail == node else tail
                        relaxed += 1
                        through = so_far + link_weights[k]
                        last = _lower(labels, node, neighbour, through, little, last)
        held(own)
    return cost, parent, order[:expanded], relaxed


@jitable(forceinline=True)
def _lower(
    labels: _RoundLabels, node: int, neighbour: int, through: float, little: float, last: int
) -> int:
    """Reach a neighbour by way of a node if that costs less; where the order ends then.

    Args:
        labels: written.
        node, neighbour: the nodes.
        through: cost of the neighbour by that way.
        little: what its cost must fall by.
        last: end of the order.
    """
    cost, parent, waiting, order = labels
    if through < cost[neighbour] - little:
        cost[neighbour], parent[neighbour] = through, node
        if waiting[neighbour] == 0:
            waiting[neighbour], order[last] = 1, neighbour
            return last + 1
    return last
