"""Inner loops of the searches, compiled by numba.

Each runs uncompiled too, as ``best_first.py_func`` on plain lists: a first plan need not wait for
the compiler. Ties are broken the same way each time, so both ways give the same result.
"""

from __future__ import annotations

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.compiled import FLOATS, IDS, NEW_IDS, compiled
from abi.search.heuristic_kernels import NO_METRIC, Metric, to_go
from abi.tet_mesh.adjacency_kernels import LINKED, NO_SHAPE, ROWS, SIDES, Shape, across, cell, ones

BUCKETS = 2048
WIDTH = 4 / (BUCKETS - 4)
"""Of the largest weight: how wide a bucket is."""

_ALL_SIDES = (1 << SIDES) - 1
_LITTLE = 1e-11  # part of the largest weight by which a cost must fall to be worth it


_EXAMPLE = (
    *(NO_SHAPE, IDS, IDS, FLOATS, IDS, IDS, IDS, FLOATS, IDS, IDS, FLOATS),
    *(0, 0, 1, 1.0, NO_METRIC),
)


@compiled(example=_EXAMPLE, error_model="numpy")
def best_first(
    shape: Shape,
    offsets: IntArray,
    steps: IntArray,
    places: FloatArray,
    indptr: IntArray,
    indices: IntArray,
    exits: IntArray,
    weights: FloatArray,
    tails: IntArray,
    heads: IntArray,
    link_weights: FloatArray,
    own: int,
    start: int,
    goal: int,
    largest: float,
    metric: Metric,
) -> tuple[FloatArray, IntArray, IntArray, int]:
    """A* (Hart, Nilsson and Raphael, 1968); Dijkstra's algorithm where the metric is none.

    Stops at the goal, once nothing waits that promises less. The queue is a ring of buckets (Dial,
    1969; Dinitz, 1978), for an estimate grows along an edge by a few largest weights only. Within a
    bucket, a 500th of the largest weight, the newest node goes first: most estimates in a lattice
    tie, and of those the newest is the farthest on its way. A node whose cost is lowered after its
    expansion is expanded again. Dijkstra's never are, as no edge is shorter than a bucket is wide,
    save those to start and goal.

    Args:
        shape, offsets, steps, places, indptr, indices: the mesh, see ``adjacency_kernels``.
        exits, weights, tails, heads, link_weights: its open edges, see there.
        own: how many of start and goal are no nodes of the mesh.
        start: node id.
        goal: node id.
        largest: an upper bound of the weights, above 0; the estimates of nodes one edge away
            from the same node differ by at most four times as much.
        metric: the heuristic, see ``abi.search.heuristic_kernels``.

    Returns:
        cost (n,) from the start, inf where not reached; parent (n,), -1 at the start and without
        meaning where not reached; expanded nodes in order (m,), the goal last; number of edges
        examined.
    """
    kind, nodes, directions, cross = shape[0], shape[5], shape[6], shape[7]
    links = len(tails)
    most = shape[8] + links
    guided = metric[0] > 0
    cost = np.full(nodes + own, np.inf)
    parent = np.empty(nodes + own, np.int32)
    closed = np.zeros(nodes + own, np.uint8)
    order = np.empty(nodes + own + 1, np.int32)
    node_of = np.empty(nodes + own + most + 1, np.int32)
    after = np.empty(len(node_of), np.int32)
    first = np.full(BUCKETS, -1, np.int32)
    # a place more, for what is written before it is known to count
    better = np.empty(most + 1, np.int32)
    by = np.empty(most + 1, np.int32)
    expanded, relaxed = 0, 0
    little = _LITTLE * largest
    per_cost = 1 / (WIDTH * largest)
    # edges to a goal between the nodes may be shorter than the heuristic says
    slack = 0.0
    for k in range(2 * links if guided else 0):
        end = heads[k] if k < links else tails[k - links]
        if (tails[k] if k < links else heads[k - links]) == goal and end < nodes:
            if kind == ROWS:
                x, y, z = places[end], places[nodes + end], places[2 * nodes + end]
                left = to_go(shape, metric, x, y, z)
            else:
                a, b, c = cell(shape, end)
                left = to_go(shape, metric, 1.0 * a, 1.0 * b, 1.0 * c)
            slack = max(slack, left - link_weights[k % links])
    cost[start] = 0.0
    parent[start] = -1
    node_of[0] = start
    after[0] = -1
    first[0] = 0
    used, waiting, current = 1, 1, 0
    found, done = False, False
    while not done:
        # arrays that grew in the inner loop would be counted in and out at each turn
        while used + most <= len(after) and expanded + 1 < len(order):
            slot = current & (BUCKETS - 1)
            entry = first[slot]
            if entry < 0:
                done = found or waiting == 0
                if done:
                    break
                current += 1
                continue
            first[slot] = after[entry]
            waiting -= 1
            node = node_of[entry]
            if closed[node] == 1:
                continue
            closed[node] = 1
            if node == goal:
                found = True
                continue
            if found:
                # the goal's bucket may hold what leads to it at less cost
                left = 0.0
                if guided and node < nodes:
                    if kind == ROWS:
                        x, y, z = places[node], places[nodes + node], places[2 * nodes + node]
                        left = to_go(shape, metric, x, y, z)
                    else:
                        a, b, c = cell(shape, node)
                        left = to_go(shape, metric, 1.0 * a, 1.0 * b, 1.0 * c)
                if cost[node] + max(left - slack, 0.0) >= cost[goal] - little:
                    continue
            order[expanded] = node
            expanded += 1
            so_far = cost[node]
            enough = so_far + little
            count, linked = 0, True
            i, j, h, odd, turned = 0, 0, 0, 0, 1
            if node < nodes:
                bits = exits[node]
                linked = (bits >> LINKED) & 1 == 1
                if kind == ROWS:
                    for k in range(indptr[node], indptr[node + 1]):
                        better[count] = indices[k]
                        by[count] = k
                        count += 1 if enough + weights[k] < cost[indices[k]] else 0
                        relaxed += 1 if weights[k] < np.inf else 0
                else:
                    relaxed += SIDES if bits == _ALL_SIDES else ones(bits)
                    i, j, h = cell(shape, node)
                    odd = i & 1
                    row = odd * directions
                    turned = 1 - 2 * odd
                    other = across(shape, i, j, h)
                    for k in range(cross):
                        neighbour = other + offsets[row + k] if (bits >> k) & 1 else node
                        better[count] = neighbour
                        by[count] = k
                        count += 1 if enough + weights[k] < cost[neighbour] else 0
                    for k in range(cross, directions if (bits >> SIDES) & 63 else SIDES):
                        neighbour = node + offsets[row + k] if (bits >> k) & 1 else node
                        better[count] = neighbour
                        by[count] = k
                        count += 1 if enough + weights[k] < cost[neighbour] else 0
            of_mesh = count
            for k in range(links if linked else 0):
                if tails[k] == node or heads[k] == node:
                    neighbour = heads[k] if tails[k] == node else tails[k]
                    better[count] = neighbour
                    by[count] = k
                    count += 1 if enough + link_weights[k] < cost[neighbour] else 0
                    relaxed += 1
            lowest = np.iinfo(np.int64).max
            for e in range(count):
                neighbour, k = better[e], by[e]
                through = so_far + (weights[k] if e < of_mesh else link_weights[k])
                cost[neighbour] = through
                parent[neighbour] = node
                closed[neighbour] = 0
                if guided and neighbour < nodes:
                    if kind == ROWS:
                        x = places[neighbour]
                        y, z = places[nodes + neighbour], places[2 * nodes + neighbour]
                        left = to_go(shape, metric, x, y, z)
                    elif e < of_mesh:
                        sign = turned if k < cross else 1
                        a, b = i + sign * steps[3 * k], j + sign * steps[3 * k + 1]
                        c = h + sign * steps[3 * k + 2]
                        left = to_go(shape, metric, 1.0 * a, 1.0 * b, 1.0 * c)
                    else:
                        a, b, c = cell(shape, neighbour)
                        left = to_go(shape, metric, 1.0 * a, 1.0 * b, 1.0 * c)
                    through += left - slack if left > slack else 0.0
                bucket = int(through * per_cost)
                lowest = bucket if bucket < lowest else lowest
                slot = (bucket if bucket > current else current) & (BUCKETS - 1)
                node_of[used] = neighbour
                after[used] = first[slot]
                first[slot] = used
                used += 1
                waiting += 1
            if node == start and count > 0:
                current = lowest
        if not done:
            order = np.concatenate((order, np.empty_like(order)))
            node_of = np.concatenate((node_of, np.empty_like(node_of)))
            after = np.concatenate((after, np.empty_like(after)))
    if found:
        order[expanded] = goal
        expanded += 1
    return cost, parent, order[:expanded], relaxed


@compiled(example=_EXAMPLE, error_model="numpy")
def bellman_ford(
    shape: Shape,
    offsets: IntArray,
    steps: IntArray,
    places: FloatArray,
    indptr: IntArray,
    indices: IntArray,
    exits: IntArray,
    weights: FloatArray,
    tails: IntArray,
    heads: IntArray,
    link_weights: FloatArray,
    own: int,
    start: int,
    goal: int,
    largest: float,
    metric: Metric,
) -> tuple[FloatArray, IntArray, IntArray, int]:
    """Bellman-Ford with a queue (Moore, 1959): runs until no cost can be lowered.

    Only nodes whose cost was lowered are examined again, first come, first served.

    Args:
        shape, offsets, steps, places, indptr, indices: the mesh, see ``adjacency_kernels``.
        exits, weights, tails, heads, link_weights: its open edges, see there.
        own: how many of start and goal are no nodes of the mesh.
        start: node id.
        goal: not needed.
        largest: an upper bound of the weights, above 0.
        metric: not needed.

    Returns:
        cost (n,) from the start, inf where not reached; parent (n,), -1 at the start and without
        meaning where not reached; expanded nodes in order (m,), a node as often as it was expanded;
        number of edges examined.
    """
    kind, nodes, directions, cross = shape[0], shape[5], shape[6], shape[7]
    links = len(tails)
    total = nodes + own
    cost = np.full(total, np.inf)
    parent = np.empty(total, np.int32)
    waiting = np.zeros(total, np.uint8)
    # a ring: no node waits twice, so it never overflows
    queue = np.empty(total + 1, np.int32)
    order = np.empty(total, np.int32)
    expanded, relaxed = 0, 0
    little = _LITTLE * largest
    cost[start] = 0.0
    parent[start] = -1
    queue[0] = start
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
                bits = exits[node]
                linked = (bits >> LINKED) & 1 == 1
                if kind == ROWS:
                    begin, end = indptr[node], indptr[node + 1]
                else:
                    relaxed += SIDES if bits == _ALL_SIDES else ones(bits)
                    i, j, h = cell(shape, node)
                    row = (i & 1) * directions
                    other = across(shape, i, j, h)
                    end = directions if (bits >> SIDES) & 63 else SIDES
            for k in range(begin, end + links if linked else end):
                if k >= end:
                    tail, head = tails[k - end], heads[k - end]
                    if tail != node and head != node:
                        continue
                    neighbour, weight = head if tail == node else tail, link_weights[k - end]
                    relaxed += 1
                elif kind == ROWS:
                    neighbour, weight = indices[k], weights[k]
                    relaxed += 1 if weight < np.inf else 0
                elif (bits >> k) & 1:
                    neighbour = (other if k < cross else node) + offsets[row + k]
                    weight = weights[k]
                else:
                    continue
                through = so_far + weight
                if through < cost[neighbour] - little:
                    cost[neighbour] = through
                    parent[neighbour] = node
                    if waiting[neighbour] == 0:
                        waiting[neighbour] = 1
                        queue[last] = neighbour
                        last = last + 1 if last < total else 0
    return cost, parent, order[:expanded], relaxed


@compiled(example=(NEW_IDS, 1), error_model="numpy")
def walked(parent: IntArray, goal: int) -> IntArray:
    """Nodes (k,) from the start, whose parent is -1, to the goal; by their parents (n,)."""
    count = 1
    node = parent[goal]
    while node >= 0:
        count += 1
        node = parent[node]
    found = np.empty(count, np.int32)
    node = goal
    for k in range(count - 1, -1, -1):
        found[k] = node
        node = parent[node]
    return found
