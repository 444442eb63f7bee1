"""Bellman-Ford with a queue, compiled by numba; see :mod:`abi.search.best_first_kernels`."""

from __future__ import annotations

import numpy as np
from numba.extending import register_jitable

from abi.arrays import ByteArray, FloatArray, IntArray
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


@compiled(example=EXAMPLE, error_model="numpy")
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
    # a ring: no node waits twice, so it never overflows
    queue = np.empty(total + 1, np.int32)
    order = np.empty(total, np.int32)
    expanded, relaxed = 0, 0
    little = LITTLE * largest
    cost[ends.start], parent[ends.start], queue[0] = 0.0, -1, ends.start
    first, last = 0, 1
    while first != last:
        if expanded == len(order):
            order = np.concatenate((order, np.empty_like(order)))
        # an array that grew in this loop would be counted in and out at each turn
        while first != last and expanded < len(order):
            node = queue[first]
            first = first + 1 if first < total else 0
            waiting[node] = 0
            order[expanded] = node
            expanded += 1
            so_far = cost[node]
            begin, end, linked = 0, 0, True
            bits, row, other = 0, 0, 0
            if node < nodes:
                bits = open_directions[node]
                linked = (bits >> LINKED_BIT) & 1 == 1
                if kind == CSR:
                    begin, end = indptr[node], indptr[node + 1]
                else:
                    relaxed += INTERIOR_DIRECTIONS if bits == ALL_INTERIOR else ones(bits)
                    i, j, h = cell(shape, node)
                    row = (i & 1) * directions
                    other = across(shape, i, j, h)
                    end = directions if (bits >> INTERIOR_DIRECTIONS) & 63 else INTERIOR_DIRECTIONS
            if bits == ALL_INTERIOR:  # as most nodes have: nothing to look at but the costs
                begin = end
                for k in range(INTERIOR_DIRECTIONS):
                    neighbour = (other if k < cross else node) + offsets[row + k]
                    through = so_far + weights[k]
                    if through < cost[neighbour] - little:
                        cost[neighbour], parent[neighbour] = through, node
                        last = _queued(neighbour, waiting, queue, last)
            for k in range(begin, end + len(tails) if linked else end):
                if k >= end:
                    tail, head = tails[k - end], heads[k - end]
                    if tail != node and head != node:
                        continue
                    neighbour, weight = head if tail == node else tail, link_weights[k - end]
                    relaxed += 1
                elif kind == CSR:
                    neighbour, weight = indices[k], weights[k]
                    relaxed += 1 if weight < np.inf else 0
                elif (bits >> k) & 1:
                    neighbour = (other if k < cross else node) + offsets[row + k]
                    weight = weights[k]
                else:
                    continue
                through = so_far + weight
                if through < cost[neighbour] - little:
                    cost[neighbour], parent[neighbour] = through, node
                    last = _queued(neighbour, waiting, queue, last)
    return cost, parent, order[:expanded], relaxed


@register_jitable(forceinline=True)
def _queued(node: int, waiting: ByteArray, queue: IntArray, last: int) -> int:
    """Put a node at the end of the ring unless it waits there; the place after the last node."""
    if waiting[node] == 1:
        return last
    waiting[node], queue[last] = 1, node
    return last + 1 if last + 1 < len(queue) else 0
