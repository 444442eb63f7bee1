"""A* and Dijkstra's algorithm on a ring of buckets, compiled by numba.

It runs uncompiled too, on plain lists: a first plan need not wait for the compiler. Ties are broken
the same way each time, so both ways give the same result.

Arrays are taken out of tuples before a loop begins, and few are passed to helpers inside it; see
``abi.tet_mesh.adjacency_kernels``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from abi.arrays import ByteArray, FloatArray, IntArray
from abi.compilation.jitable import jitable
from abi.compiled import compiled
from abi.search.search_kernels import EXAMPLE, LITTLE, NONE, Metric, Problem, to_go
from abi.tet_mesh.adjacency_kernels import (
    ALL_INTERIOR,
    CSR,
    INTERIOR_DIRECTIONS,
    LINKED_BIT,
    Adjacency,
    MeshSizes,
    across,
    cell,
    cell_place,
    ones,
    row_place,
)

BUCKETS = 2048
WIDTH = 4 / (BUCKETS - 4)
"""Of the largest weight: how wide a bucket is."""


class _Search(NamedTuple):
    """What a search works in: labels of the nodes, a ring of buckets, each a linked list; counts.

    Attributes:
        cost, parent: (n,) of the nodes.
        closed: (n,) whether a node was expanded since its cost changed.
        left: (n,) what is left to the goal by the heuristic, once the cost is finite: in a lattice
            that takes as long as to look at its edges, and nodes are queued about twice.
        first: (BUCKETS,) entries, -1 where a bucket is empty.
        entries: two words of each, side by side in memory. The first has its node and the entry
            behind it in the same bucket, see :func:`_entry`. The second has the node's place in
            half cells, packed, as to find it by the id again takes longer; of rows it has no
            meaning.
        order: nodes that were expanded, in order.
        used: entries of the queue, those that are out of it included.
        waiting: entries in it.
        current: the bucket, counted from the first of all.
        expanded: nodes expanded.
        relaxed: edges examined.
        found: whether the goal was taken out of the queue.
    """

    cost: FloatArray
    parent: IntArray
    closed: ByteArray
    left: FloatArray
    first: IntArray
    entries: NDArray[np.int64]
    order: IntArray
    used: int
    waiting: int
    current: int
    expanded: int
    relaxed: int
    found: bool


@compiled(example=EXAMPLE)
def best_first(problem: Problem) -> tuple[FloatArray, IntArray, IntArray, int]:
    """A* (Hart, Nilsson and Raphael, 1968); Dijkstra's algorithm where the metric is none.

    Stops at the goal, once nothing waits that promises less. The queue is a ring of buckets (Dial,
    1969; Dinitz, 1978), for an estimate grows along an edge by a few largest weights only. Within a
    bucket, a 500th of the largest weight, the newest node goes first: most estimates in a lattice
    tie, and of those the newest is the farthest on its way. A node whose cost is lowered after its
    expansion is expanded again. Dijkstra's never are, as no edge is shorter than a bucket is wide,
    save those to start and goal.

    Returns:
        cost (n,) from the start, inf where not reached; parent (n,), -1 at the start and without
        meaning where not reached; expanded nodes in order (m,), the goal last; number of edges
        examined.
    """
    start, goal, own = problem.start, problem.goal, problem.own
    shape = problem.adjacency.shape
    total = shape.nodes + own
    room = total + shape.most + len(problem.tails) + 1
    cost, parent = np.full(total, np.inf), np.empty(total, np.int32)
    closed, left = np.zeros(total, np.uint8), np.empty(total)
    first, entries = np.full(BUCKETS, -1, np.int32), np.empty(2 * room, np.int64)
    order = np.empty(total + 1, np.int32)
    cost[start], parent[start] = 0.0, -1
    entries[0], first[0] = _entry(start, -1), 0
    if shape.kind != CSR:
        entries[1] = _packed(cell(shape, start))
    slack = _slack(problem)
    used, waiting, current, expanded, relaxed, found = 1, 1, 0, 0, 0, False
    while True:
        search = _Search(
            *(cost, parent, closed, left, first, entries, order),
            *(used, waiting, current, expanded, relaxed, found),
        )
        used, waiting, current, expanded, relaxed, found, done = _expand(problem, slack, search)
        if done:
            break
        order = np.concatenate((order, np.empty_like(order)))
        entries = np.concatenate((entries, np.empty_like(entries)))
    if found:
        order[expanded] = goal
        expanded += 1
    return cost, parent, order[:expanded], relaxed


@jitable
def _expand(
    problem: Problem, slack: float, search: _Search
) -> tuple[int, int, int, int, int, bool, bool]:
    """Expand nodes until the search is done, or the queue or the order is full.

    With the growth of arrays in the same loop, they would be counted in and out at each turn.

    Returns:
        The counts of the search, in their order there, and whether nothing is left to do.
    """
    adjacency, open_directions = problem.adjacency, problem.open_directions
    weights, link_weights = problem.weights, problem.link_weights
    tails, heads = problem.tails, problem.heads
    start, goal, largest, metric = problem.start, problem.goal, problem.largest, problem.metric
    shape, offsets, steps, places, indptr, indices = adjacency
    cost, parent, closed, left = search.cost, search.parent, search.closed, search.left
    first, entries, order = search.first, search.entries, search.order
    used, waiting, current = search.used, search.waiting, search.current
    expanded, relaxed, found, done = search.expanded, search.relaxed, search.found, False
    most = shape.most + len(tails)
    # a place more, for what is written before it is known to count
    cheaper = np.empty(2 * most + 2, np.int32)
    little, per_cost = LITTLE * largest, 1 / (WIDTH * largest)
    while 2 * (used + most) <= len(entries) and expanded + 1 < len(order):
        slot = current & (BUCKETS - 1)
        entry = first[slot]
        if entry < 0:
            if found or waiting == 0:
                done = True
                break
            current += 1
            continue
        word = entries[2 * entry]
        node, first[slot] = int(word >> 32), int(word & 0xFFFFFFFF) - 1
        waiting -= 1
        if closed[node] == 1:
            continue
        closed[node] = 1
        if node == goal:
            found = True
            continue
        if found:
            # the goal's bucket may hold what leads to it at less cost
            least = cost[node] + max(_estimate(adjacency, metric, node) - slack, 0.0)
            if least >= cost[goal] - little:
                continue
        order[expanded] = node
        expanded += 1
        enough = cost[node] + little
        count, linked, place = 0, True, (0, 0, 0)
        if node < shape.nodes:
            bits = open_directions[node]
            linked = (bits >> LINKED_BIT) & 1 == 1
            if shape.kind == CSR:
                row = (indptr[node], indptr[node + 1])
                count, examined = _cheaper_in_row(row, enough, indices, weights, cost, cheaper)
                relaxed += examined
            else:
                relaxed += INTERIOR_DIRECTIONS if bits == ALL_INTERIOR else ones(bits)
                place = _unpacked(entries[2 * entry + 1])
                count = _cheaper_in_lattice(
                    shape, (node, bits, place), enough, offsets, weights, cost, cheaper
                )
        of_mesh = count
        for k in range(len(tails) if linked else 0):
            if tails[k] == node or heads[k] == node:
                neighbour = heads[k] if tails[k] == node else tails[k]
                cheaper[count], cheaper[count + 1] = neighbour, k
                count += 2 if enough + link_weights[k] < cost[neighbour] else 0
                relaxed += 1
        lowest = np.iinfo(np.int64).max
        for e in range(0, count, 2):
            neighbour, k = cheaper[e], cheaper[e + 1]
            through = cost[node] + (weights[k] if e < of_mesh else link_weights[k])
            reached = cost[neighbour] < np.inf
            cost[neighbour], parent[neighbour], closed[neighbour] = through, node, 0
            there = (0, 0, 0)
            if shape.kind != CSR and neighbour < shape.nodes:
                there = _stepped(shape, steps, k, place) if e < of_mesh else cell(shape, neighbour)
                entries[2 * used + 1] = _packed(there)
            if metric.kind != NONE and neighbour < shape.nodes:
                if not reached:
                    at = row_place(places, shape.nodes, neighbour) if shape.kind == CSR else there
                    left[neighbour] = max(to_go(shape, metric, at) - slack, 0.0)
                through += left[neighbour]
            bucket = int(through * per_cost)
            lowest = bucket if bucket < lowest else lowest
            slot = (bucket if bucket > current else current) & (BUCKETS - 1)
            entries[2 * used] = _entry(neighbour, first[slot])
            first[slot] = used
            used += 1
            waiting += 1
        if node == start and count > 0:
            current = lowest
    return used, waiting, current, expanded, relaxed, found, done


@compiled(example=EXAMPLE)
def estimates(problem: Problem) -> FloatArray:
    """The heuristic of all nodes (n,), less by what links to the goal may be shorter."""
    total = problem.adjacency.shape.nodes + problem.own
    slack = _slack(problem)
    found = np.zeros(total)
    for node in range(total):
        found[node] = max(_estimate(problem.adjacency, problem.metric, node) - slack, 0.0)
    return found


@jitable
def _slack(problem: Problem) -> float:
    """Largest excess of the heuristic over the length of a link to the goal."""
    adjacency, goal, metric = problem.adjacency, problem.goal, problem.metric
    tails, heads, weights = problem.tails, problem.heads, problem.link_weights
    slack = 0.0
    count = len(tails)
    for k in range(2 * count if metric.kind != NONE else 0):
        tail, head = tails[k % count], heads[k % count]
        end = head if k < count else tail
        if (tail if k < count else head) == goal and end < adjacency.shape.nodes:
            slack = max(slack, _estimate(adjacency, metric, end) - weights[k % count])
    return slack


@jitable
def _estimate(adjacency: Adjacency, metric: Metric, node: int) -> float:
    """The heuristic of a node; 0 where there is none, and of start and goal beside the mesh."""
    if metric.kind == NONE or node >= adjacency.shape.nodes:
        return 0.0
    if adjacency.shape.kind == CSR:
        place = row_place(adjacency.places, adjacency.shape.nodes, node)
    else:
        place = cell_place(adjacency.shape, node)
    return to_go(adjacency.shape, metric, place)


@jitable(forceinline=True)
def _entry(node: int, behind: int) -> int:
    """First word of an entry: its node in the high half, the entry behind it, or -1, plus 1."""
    return (int(node) << 32) | (int(behind) + 1)


@jitable(forceinline=True)
def _packed(place: tuple[int, int, int]) -> int:
    """A place in one number, which is written in less time than three."""
    i, j, h = place
    # as Python they may have 32 bits, which do not hold it
    return (int(i) << 42) | (int(j) << 21) | int(h)


@jitable(forceinline=True)
def _unpacked(place: int) -> tuple[int, int, int]:
    """The place in that number."""
    return place >> 42, (place >> 21) & 0x1FFFFF, place & 0x1FFFFF


@jitable(forceinline=True)
def _stepped(
    shape: MeshSizes, steps: IntArray, k: int, place: tuple[int, int, int]
) -> tuple[int, int, int]:
    """Place of the neighbour in a direction of a lattice, in half cells."""
    i, j, h = place
    sign = 1 - 2 * (i & 1) if k < shape.cross else 1
    return i + sign * steps[3 * k], j + sign * steps[3 * k + 1], h + sign * steps[3 * k + 2]


@jitable(forceinline=True)
def _cheaper_in_row(
    row: tuple[int, int],
    enough: float,
    indices: IntArray,
    weights: FloatArray,
    cost: FloatArray,
    cheaper: IntArray,
) -> tuple[int, int]:
    """Neighbours of a node of rows that would become cheaper, and how many edges are open."""
    count, examined = 0, 0
    for k in range(row[0], row[1]):
        cheaper[count], cheaper[count + 1] = indices[k], k
        count += 2 if enough + weights[k] < cost[indices[k]] else 0
        examined += 1 if weights[k] < np.inf else 0
    return count, examined


@jitable(forceinline=True)
def _cheaper_in_lattice(
    shape: MeshSizes,
    node: tuple[int, int, tuple[int, int, int]],
    enough: float,
    offsets: IntArray,
    weights: FloatArray,
    cost: FloatArray,
    cheaper: IntArray,
) -> int:
    """Note the neighbours of a lattice node that cost more than by way of it; twice their number.

    Args:
        shape: that of the lattice.
        node: its id, open directions as bits, and place in half cells.
        enough: cost of the node, and what that of a neighbour must fall by.
        offsets, weights: of the directions.
        cost: (n,) known so far.
        cheaper: the neighbours, each before the direction that leads there; written.
    """
    count = 0
    tail, bits, (i, j, h) = node
    row = (i & 1) * shape.directions
    other = across(shape, i, j, h)
    if bits == ALL_INTERIOR:  # as most nodes have: no bits to look at
        for k in range(shape.cross):
            neighbour = other + offsets[row + k]
            cheaper[count], cheaper[count + 1] = neighbour, k
            count += 2 if enough + weights[k] < cost[neighbour] else 0
        for k in range(shape.cross, INTERIOR_DIRECTIONS):
            neighbour = tail + offsets[row + k]
            cheaper[count], cheaper[count + 1] = neighbour, k
            count += 2 if enough + weights[k] < cost[neighbour] else 0
        return count
    for k in range(shape.cross):
        neighbour = other + offsets[row + k] if (bits >> k) & 1 else tail
        cheaper[count], cheaper[count + 1] = neighbour, k
        count += 2 if enough + weights[k] < cost[neighbour] else 0
    for k in range(
        shape.cross, shape.directions if (bits >> INTERIOR_DIRECTIONS) & 63 else INTERIOR_DIRECTIONS
    ):
        neighbour = tail + offsets[row + k] if (bits >> k) & 1 else tail
        cheaper[count], cheaper[count + 1] = neighbour, k
        count += 2 if enough + weights[k] < cost[neighbour] else 0
    return count
