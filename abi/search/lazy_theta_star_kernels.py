"""Lazy Theta* over arcs, with a record of every step.

Compiled by numba; it runs uncompiled too. A primitive is a row of numbers, see
``abi.obstacles.primitive_kernels``.
"""

from __future__ import annotations

import heapq

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.compiled import FLOATS, IDS, compiled
from abi.obstacles.primitive_tree_kernels import blocked
from abi.obstacles.vector_kernels import distance, vec3_at
from abi.search.label_kernels import Labels, recorded


@compiled(example=(IDS, IDS, FLOATS, (0, 1), FLOATS, FLOATS))
def lazy_theta_star_steps(
    indptr: IntArray,
    indices: IntArray,
    places: FloatArray,
    ends: tuple[int, int],
    primitives: FloatArray,
    margins: FloatArray,
) -> tuple[IntArray, Labels]:
    """Search from start to goal; see :func:`abi.search.lazy_theta_star.lazy_theta_star`.

    Args:
        indptr, indices: neighbours of n nodes.
        places: (3n,) [unit], world, one node after the other.
        ends: start and goal.
        primitives: (k WIDTH,) rows, one after the other.
        margins: (k,) distance from the primitives that a line of sight keeps, [unit].

    Returns:
        Expanded nodes (m,), and the changes.
    """
    nodes = len(indptr) - 1
    start, goal = ends
    target = vec3_at(places, 3 * goal)
    cost, parent = np.full(nodes, np.inf), np.full(nodes, -1, np.int32)
    closed = np.zeros(nodes, np.uint8)
    cost[start] = 0.0
    queue = [(distance(vec3_at(places, 3 * start), target), 0, start)]
    order, counts = [start][:0], [1]
    node_of, cost_of, parent_of = [start], [0.0], [-1]
    while len(queue) > 0:
        node = heapq.heappop(queue)[2]
        if closed[node] == 1:
            continue
        first, last = indptr[node], indptr[node + 1]
        origin, here = parent[node] + 0, vec3_at(places, 3 * node)
        if origin >= 0:
            is_edge = False
            for k in range(first, last):
                is_edge = is_edge or indices[k] == origin
            if not is_edge and blocked(primitives, margins, 0, vec3_at(places, 3 * origin), here):
                least = np.inf
                for k in range(first, last):
                    other = indices[k]
                    through = cost[other] + distance(vec3_at(places, 3 * other), here)
                    if closed[other] == 1 and through < least:
                        least, origin = through, other + 0
                cost[node], parent[node] = least, origin
                node_of.append(node)
                cost_of.append(float(least))
                parent_of.append(origin)
        closed[node] = 1
        order.append(node)
        if node == goal:
            counts.append(len(node_of))
            break
        if origin < 0:
            origin = node
        so_far, there = cost[origin], vec3_at(places, 3 * origin)
        for k in range(first, last):
            other = indices[k] + 0
            place = vec3_at(places, 3 * other)
            through = so_far + distance(there, place)
            if closed[other] == 0 and through < cost[other]:
                cost[other], parent[other] = through, origin
                node_of.append(other)
                cost_of.append(float(through))
                parent_of.append(origin)
                value = through + distance(place, target)
                heapq.heappush(queue, (value, -len(node_of), other))
        counts.append(len(node_of))
    return np.array(order, np.int32), recorded(counts, node_of, cost_of, parent_of)
