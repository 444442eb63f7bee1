"""Searches over arcs with a binary heap: with any weights, from both ends, and repaired.

Those with any weights of g and h and those from both ends are there to compare with; a node is
expanded once, as in the textbooks. Lifelong Planning A* repairs a search where its graph has
changed. Compiled by numba; they run uncompiled too.
"""

from __future__ import annotations

import heapq
from typing import NamedTuple

import numpy as np

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, IDS, compiled
from abi.search.search_kernels import LITTLE


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


Key = tuple[float, float, int]


@jitable
def _key(cost: FloatArray, ahead: FloatArray, estimates: FloatArray, node: int) -> Key:
    """Place of a node in the queue: f, then g, by the lesser of its two costs."""
    least = min(cost[node], ahead[node])
    return least + estimates[node], least, node


@jitable
def _look_ahead(
    arcs: ArcRows, cost: FloatArray, ahead: FloatArray, parent: IntArray, node: int
) -> int:
    """Find a node's least cost by way of a neighbour; return the number of arcs examined."""
    least, origin = np.inf, -1
    for k in range(arcs.indptr[node], arcs.indptr[node + 1]):
        through = cost[arcs.indices[k]] + arcs.weights[k]
        if through < least:
            least, origin = through, arcs.indices[k] + 0
    ahead[node], parent[node] = least, origin
    return int(arcs.indptr[node + 1] - arcs.indptr[node])


@jitable
def _settle(
    arcs: ArcRows,
    cost: FloatArray,
    ahead: FloatArray,
    parent: IntArray,
    estimates: FloatArray,
    ends: tuple[int, int],
    queue: list[Key],
) -> tuple[list[int], int]:
    """Expand nodes whose cost is not that by their neighbours, until the goal's cost is certain.

    The estimates are consistent but for rounding: what promises as much as the goal does waits only
    if it is no nearer to the start.

    Args:
        arcs: of n nodes.
        cost: (n,) g, by which a node was expanded last; inf where it was not. Written.
        ahead: (n,) rhs, the best that g of the neighbours says now. Written.
        parent: (n,) the neighbour that says it; -1 for none. Written.
        estimates: (n,) h.
        ends: start and goal.
        queue: what waits.

    Returns:
        The expanded nodes, and the number of arcs looked at. The queue keeps what waits.
    """
    start, goal = ends
    order, examined = [start][:0], 0
    little = LITTLE * np.abs(arcs.weights).max() if len(arcs.weights) > 0 else 0.0
    later = queue[:0]
    while True:
        sure = cost[goal] == ahead[goal]
        while not sure and len(later) > 0:
            heapq.heappush(queue, later.pop())
        if len(queue) == 0:
            break
        top = queue[0]
        node = top[2]
        if cost[node] == ahead[node] or top != _key(cost, ahead, estimates, node):
            heapq.heappop(queue)  # settled since, or entered again with another key
            continue
        if sure and top[0] > cost[goal] + estimates[goal] + little:
            break
        heapq.heappop(queue)
        if sure and top[0] >= cost[goal] + estimates[goal] - little and top[1] >= cost[goal]:
            later.append(top)
            continue
        order.append(node)
        first, last = arcs.indptr[node], arcs.indptr[node + 1]
        if cost[node] > ahead[node]:
            cost[node] = ahead[node]
            for k in range(first, last):
                other = arcs.indices[k] + 0
                through = cost[node] + arcs.weights[k]
                if other != start and through < ahead[other]:
                    ahead[other], parent[other] = through, node
                    heapq.heappush(queue, _key(cost, ahead, estimates, other))
            examined += last - first
        else:
            # what it told its neighbours does not hold any more
            cost[node] = np.inf
            heapq.heappush(queue, _key(cost, ahead, estimates, node))
            for k in range(first, last):
                other = arcs.indices[k] + 0
                if other != start and parent[other] == node:
                    examined += _look_ahead(arcs, cost, ahead, parent, other)
                    if cost[other] != ahead[other]:
                        heapq.heappush(queue, _key(cost, ahead, estimates, other))
            examined += last - first
    for key in later:
        heapq.heappush(queue, key)
    return order, examined


@jitable
def _changed(before: ArcRows, now: ArcRows, node: int) -> bool:
    """Check whether a node has other arcs than before."""
    a, b = before.indptr[node], now.indptr[node]
    count = now.indptr[node + 1] - b
    if before.indptr[node + 1] - a != count:
        return True
    for k in range(count):
        if (
            before.indices[a + k] != now.indices[b + k]
            or before.weights[a + k] != now.weights[b + k]
        ):
            return True
    return False


@compiled(example=(NO_ARCS, NO_ARCS, FLOATS, (0, 1)))
def repair_order(
    before: ArcRows, now: ArcRows, estimates: FloatArray, ends: tuple[int, int]
) -> tuple[IntArray, int, BoolArray, FloatArray, IntArray]:
    """Search the arcs as they were, then mend that search for the arcs as they are.

    Args:
        before, now: arcs between the same n nodes, which lead both ways at the same cost.
        estimates: (n,) h, consistent for both.
        ends: start and goal.

    Returns:
        Nodes expanded by the repair in order (m,); arcs that it looked at; whether each node has
        other arcs than before (n,); g of each node now (n,); and where it comes from (n,).
    """
    nodes, start = len(estimates), ends[0]
    cost, ahead = np.full(nodes, np.inf), np.full(nodes, np.inf)
    parent = np.full(nodes, -1, np.int32)
    ahead[start] = 0.0
    queue = [_key(cost, ahead, estimates, start)]
    _settle(before, cost, ahead, parent, estimates, ends, queue)
    changed, examined = np.zeros(nodes, np.bool_), 0
    for node in range(nodes):
        changed[node] = _changed(before, now, node)
        if changed[node] and node != start:
            examined += _look_ahead(now, cost, ahead, parent, node)
            if cost[node] != ahead[node]:
                heapq.heappush(queue, _key(cost, ahead, estimates, node))
    order, more = _settle(now, cost, ahead, parent, estimates, ends, queue)
    expanded = np.array(order, np.int32)
    return expanded, examined + more, changed, ahead, parent
