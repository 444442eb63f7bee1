"""Searches with a binary heap, for comparison: with any weights of g and h, and from both ends.

Compiled by numba; they run uncompiled too. A node is expanded once, as in the textbooks.
"""

from __future__ import annotations

import heapq
from typing import NamedTuple

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.compiled import FLOATS, IDS, compiled


class ArcRows(NamedTuple):
    """Arcs (one-way edges) as compressed rows.

    Attributes:
        indptr: (n + 1,) where the arcs of each node begin.
        indices: (a,) heads.
        weights: (a,) costs; one below 0 is taken as it is.
    """

    indptr: IntArray
    indices: IntArray
    weights: FloatArray


NO_ARCS = ArcRows(IDS, IDS, FLOATS)
"""In an example: some arcs."""


@compiled(example=(NO_ARCS, FLOATS, (0, 1), (1.0, 1.0)))
def best_first_order(
    arcs: ArcRows, estimates: FloatArray, ends: tuple[int, int], factors: tuple[float, float]
) -> IntArray:
    """Expand the open node with the least ``a g + b h`` until that is the goal.

    A* for (1, 1), Dijkstra for (1, 0), greedy for (0, 1). Of equals the newest goes first.

    Args:
        arcs: of n nodes.
        estimates: (n,) h.
        ends: start and goal.
        factors: a and b.

    Returns:
        Expanded nodes in order (m,), the goal last where it is reached.
    """
    indptr, indices, weights = arcs
    start, goal = ends
    a, b = factors
    cost = np.full(len(estimates), np.inf)
    closed = np.zeros(len(estimates), np.uint8)
    order = np.empty(len(estimates), np.int32)
    cost[start] = 0.0
    queue = [(b * estimates[start], 0, start)]
    expanded, serial = 0, 0
    while len(queue) > 0:
        node = heapq.heappop(queue)[2]
        if closed[node] == 1:
            continue
        closed[node] = 1
        order[expanded] = node
        expanded += 1
        if node == goal:
            break
        so_far = cost[node]
        for k in range(indptr[node], indptr[node + 1]):
            neighbour = indices[k] + 0  # as wide as the queue's
            through = so_far + weights[k]
            if closed[neighbour] == 0 and through < cost[neighbour]:
                cost[neighbour] = through
                serial -= 1
                value = a * through + b * estimates[neighbour]
                heapq.heappush(queue, (value, serial, neighbour))
    return order[:expanded]


@compiled(example=(NO_ARCS, (0, 1)))
def bidirectional_order(arcs: ArcRows, ends: tuple[int, int]) -> IntArray:
    """Dijkstra's algorithm from both ends (Nicholson, 1966), the nearer front first.

    Ends when both fronts together are as far as the best path over a node that both have seen.
    The arcs lead both ways at the same cost.

    Returns:
        Expanded nodes in order (m,); n is added to those of the search from the goal.
    """
    indptr, indices, weights = arcs
    nodes = len(indptr) - 1
    cost = np.full(2 * nodes, np.inf)
    closed = np.zeros(2 * nodes, np.uint8)
    order = np.empty(2 * nodes, np.int32)
    start, goal = ends[0], ends[1] + nodes
    cost[start], cost[goal] = 0.0, 0.0
    forward, backward = [(0.0, 0, start)], [(0.0, 0, goal)]
    best = np.inf
    expanded, serial = 0, 0
    while len(forward) > 0 and len(backward) > 0:
        if forward[0][0] + backward[0][0] >= best:
            break
        ahead = forward[0][0] <= backward[0][0]
        node = heapq.heappop(forward)[2] if ahead else heapq.heappop(backward)[2]
        if closed[node] == 1:
            continue
        closed[node] = 1
        order[expanded] = node
        expanded += 1
        side = 0 if ahead else nodes
        for k in range(indptr[node - side], indptr[node - side + 1]):
            place = indices[k] + 0
            through = cost[node] + weights[k]
            if through < cost[place + side]:
                cost[place + side] = through
                serial -= 1
                if ahead:
                    heapq.heappush(forward, (through, serial, place + side))
                else:
                    heapq.heappush(backward, (through, serial, place + side))
                best = min(best, through + cost[place + nodes - side])
    return order[:expanded]
