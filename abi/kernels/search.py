"""Inner loops of the searches, compiled by numba.

Each runs uncompiled too, as ``best_first.py_func`` on plain lists: a first plan need not wait for
the compiler. Ties are broken the same way each time, so both ways give the same result.
"""

from __future__ import annotations

import heapq
import threading

import numba
import numpy as np

from abi.arrays import FloatArray, IntArray, read_only

ready = threading.Event()
"""Set once the kernels are compiled."""


@numba.njit(cache=True, nogil=True)
def best_first(
    indptr: IntArray,
    indices: IntArray,
    weights: FloatArray,
    heuristic: FloatArray,
    start: np.int32,
    goal: np.int32,
) -> tuple[FloatArray, IntArray, IntArray, int]:
    """A* (Hart, Nilsson and Raphael, 1968); Dijkstra's algorithm where the heuristic is 0.

    Stops when it expands the goal. The heuristic must be consistent: then no node is expanded
    twice. Of equal estimates the node nearest to the goal goes first, then the lower id.

    Args:
        indptr: (n + 1,) where each node's edges begin.
        indices: (2e,) neighbours.
        weights: (2e,) weights of the edges, at least 0.
        heuristic: (n,) a bound from below of the cost from each node to the goal.
        start: node id, of the type of ``indices``.
        goal: node id.

    Returns:
        cost (n,) from the start, inf where not reached; parent (n,), -1 where none; expanded nodes
        in order (m,), the goal last; number of edges examined.
    """
    nodes = len(indptr) - 1
    cost = np.full(nodes, np.inf)
    parent = np.full(nodes, -1, np.int32)
    closed = np.zeros(nodes, np.bool_)
    order = np.empty(nodes, np.int32)
    expanded = 0
    relaxed = 0
    cost[start] = 0.0
    queue = [(heuristic[start], heuristic[start], start)]
    while len(queue) > 0:
        node = heapq.heappop(queue)[2]
        if closed[node]:
            continue
        closed[node] = True
        order[expanded] = node
        expanded += 1
        if node == goal:
            break
        so_far = cost[node]
        for k in range(indptr[node], indptr[node + 1]):
            relaxed += 1
            neighbour = indices[k]
            through = so_far + weights[k]
            if through < cost[neighbour] and not closed[neighbour]:
                cost[neighbour] = through
                parent[neighbour] = node
                to_go = heuristic[neighbour]
                heapq.heappush(queue, (through + to_go, to_go, neighbour))
    return cost, parent, order[:expanded], relaxed


@numba.njit(cache=True, nogil=True)
def bellman_ford(
    indptr: IntArray, indices: IntArray, weights: FloatArray, start: np.int32
) -> tuple[FloatArray, IntArray, IntArray, int]:
    """Bellman-Ford with a queue (Moore, 1959): runs until no cost can be lowered.

    Only nodes whose cost was lowered are examined again, first come, first served.

    Args:
        indptr: (n + 1,) where each node's edges begin.
        indices: (2e,) neighbours.
        weights: (2e,) weights of the edges, at least 0.
        start: node id, of the type of ``indices``.

    Returns:
        cost (n,) from the start, inf where not reached; parent (n,), -1 where none; expanded nodes
        in order (m,), a node as often as it was expanded; number of edges examined.
    """
    nodes = len(indptr) - 1
    cost = np.full(nodes, np.inf)
    parent = np.full(nodes, -1, np.int32)
    waiting = np.zeros(nodes, np.bool_)
    # a ring: no node waits twice, so it never overflows
    queue = np.empty(nodes + 1, np.int32)
    order = np.empty(nodes, np.int32)
    expanded = 0
    relaxed = 0
    cost[start] = 0.0
    queue[0] = start
    first, last = 0, 1
    while first != last:
        node = queue[first]
        first = first + 1 if first < nodes else 0
        waiting[node] = False
        if expanded == len(order):
            order = np.concatenate((order, np.empty_like(order)))
        order[expanded] = node
        expanded += 1
        so_far = cost[node]
        for k in range(indptr[node], indptr[node + 1]):
            relaxed += 1
            neighbour = indices[k]
            through = so_far + weights[k]
            if through < cost[neighbour]:
                cost[neighbour] = through
                parent[neighbour] = node
                if not waiting[neighbour]:
                    waiting[neighbour] = True
                    queue[last] = neighbour
                    last = last + 1 if last < nodes else 0
    return cost, parent, order[:expanded], relaxed


def warm() -> None:
    """Compile both kernels, or load them from numba's cache, for the arrays of a Graph."""
    indptr = read_only(np.array([0, 1, 2], dtype=np.int32))
    indices = read_only(np.array([1, 0], dtype=np.int32))
    weights = read_only(np.ones(2))
    heuristic = read_only(np.zeros(2))
    best_first(indptr, indices, weights, heuristic, np.int32(0), np.int32(1))
    bellman_ford(indptr, indices, weights, np.int32(0))
    ready.set()
