"""Searches that lower labels: Bellman-Ford with a queue, and those whose every change is recorded.

Changes of cost and parent are recorded in order, Lazy Theta*'s among them. Compiled by numba; they
run uncompiled too. A primitive is a row of numbers, see ``abi.obstacles.primitive_kernels``; for
Bellman-Ford see :mod:`abi.search.best_first_kernels`.
"""

from __future__ import annotations

import heapq
from typing import NamedTuple

import numpy as np

from abi.arrays import ByteArray, FloatArray, IntArray
from abi.compilation.borrowed import borrowed, held
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, IDS, compiled
from abi.obstacles.primitive_tree_kernels import blocked
from abi.obstacles.vector_kernels import distance, vec3_at
from abi.search.heap_kernels import NO_ARCS, ArcRows
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


@compiled(example=EXAMPLE)
def bellman_ford(problem: Problem) -> tuple[FloatArray, IntArray, IntArray, int]:
    """Bellman-Ford with a queue (Moore, 1959): runs until no cost can be lowered.

    Only nodes whose cost was lowered are examined again, first come, first served. Takes and
    returns the same as ``best_first``, but needs no goal and no metric, and expands a node as often
    as its cost was lowered.
    """
    adjacency, open_directions = problem.adjacency, problem.open_directions
    weights, link_weights = problem.weights, problem.link_weights
    tails, heads = problem.tails, problem.heads
    source, beside, largest = problem.start, problem.own, problem.largest
    shape, offsets, _, _, indptr, indices = adjacency
    kind, nodes, directions, cross = shape.kind, shape.nodes, shape.directions, shape.cross
    total = nodes + beside
    cost, parent = np.full(total, np.inf), np.empty(total, np.int32)
    waiting = np.zeros(total, np.uint8)
    most = shape.most + len(tails)
    order = np.empty(total + most, np.int32)
    # how many had their turn, and how many have or had a place in the order
    expanded, last, relaxed = 0, 1, 0
    little = LITTLE * largest
    cost[source], parent[source], order[0] = 0.0, -1, source
    while expanded < last:
        if last + most > len(order):
            order = np.concatenate((order, np.empty_like(order)))
        own = (cost, parent, waiting, order)
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
    labels: tuple[FloatArray, IntArray, ByteArray, IntArray],
    node: int,
    neighbour: int,
    through: float,
    little: float,
    last: int,
) -> int:
    """Lower a neighbour's cost by way of a node, and queue it; return the new end of the queue.

    Args:
        labels: cost (n,), parent (n,), whether each node waits (n,), and the nodes in their turns,
            those that had theirs among them; written.
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


class Labels(NamedTuple):
    """Changes of cost and parent that a search makes in m steps.

    Attributes:
        ends: (m + 1,) changes made before each step and in all; those before the first step are
            the starts.
        nodes, costs, parents: of each change (c,); a start's parent is -1.
    """

    ends: IntArray
    nodes: IntArray
    costs: FloatArray
    parents: IntArray


@jitable
def recorded(ends: list[int], nodes: list[int], costs: list[float], parents: list[int]) -> Labels:
    """The labels that were recorded one by one."""
    return Labels(
        np.array(ends, np.int32),
        np.array(nodes, np.int32),
        np.array(costs),
        np.array(parents, np.int32),
    )


@compiled(example=(NO_ARCS, IDS, IDS, 1, True, 0.0))
def relax_in_order(
    arcs: ArcRows, order: IntArray, starts: IntArray, sides: int, reopens: bool, little: float
) -> Labels:
    """Relax the arcs of nodes in the order in which a search expanded them.

    Args:
        arcs: of n nodes.
        order: (m,) nodes; of a second search, from the goal, n is added to the node.
        starts: those with cost 0.
        sides: 2 where there is a second search, else 1.
        reopens: whether a node's cost may fall after its expansion.
        little: by how much a cost must fall to be worth it.
    """
    indptr, indices, weights = arcs
    nodes = len(indptr) - 1
    cost = np.full(sides * nodes, np.inf)
    closed = np.zeros(sides * nodes, np.uint8)
    node_of, cost_of, parent_of = [0] * 0, [0.0] * 0, [0] * 0
    for start in starts:
        cost[start] = 0.0
        node_of.append(int(start))
        cost_of.append(0.0)
        parent_of.append(-1)
    ends = [len(node_of)]
    for node in order:
        closed[node] = 1
        side = nodes if node >= nodes else 0
        for k in range(indptr[node - side], indptr[node - side + 1]):
            head = indices[k] + side
            through = cost[node] + weights[k]
            if through + little < cost[head] and (reopens or closed[head] == 0):
                cost[head] = through
                node_of.append(int(head))
                cost_of.append(float(through))
                parent_of.append(int(node))
        ends.append(len(node_of))
    return recorded(ends, node_of, cost_of, parent_of)


@jitable
def parent_cycle(parent: IntArray, seen: ByteArray) -> IntArray:
    """Nodes of a cycle of parents (c,), each before the one that it is the parent of; or none.

    Args:
        parent: (n,), -1 for none.
        seen: (n,) zeros; written.
    """
    for first in range(len(parent)):
        node = first
        while node >= 0 and seen[node] == 0:
            seen[node] = 1
            node = parent[node]
        if node >= 0 and seen[node] == 1:
            length, other = 1, parent[node]
            while other != node:
                other = parent[other]
                length += 1
            found = np.empty(length, np.int32)
            for k in range(length - 1, -1, -1):
                found[k] = node
                node = parent[node]
            return found
        node = first
        while node >= 0 and seen[node] == 1:
            seen[node] = 2
            node = parent[node]
    return np.empty(0, np.int32)


@compiled(example=(NO_ARCS, 0, True, 1, 0.0))
def rounds(
    arcs: ArcRows, start: int, may_cycle: bool, most: int, little: float
) -> tuple[Labels, IntArray]:
    """Bellman-Ford by rounds (Bellman, 1958): after k of them, the best walks of k arcs at most.

    Only arcs of nodes that the round before has changed can change anything, so only they are
    looked at; the result is that of looking at all.

    Args:
        arcs: of n nodes.
        start: a node.
        may_cycle: whether a weight is below 0; then each round looks for a cycle of parents, which
            is a negative cycle.
        most: rounds at the most.
        little: by how much a cost must fall to be worth it.

    Returns:
        The labels with a round as a step, and the nodes (c,) of a negative cycle, empty for none.
    """
    indptr, indices, weights = arcs
    nodes = len(indptr) - 1
    cost, pending = np.full(nodes, np.inf), np.full(nodes, np.inf)
    parent, proposed = np.full(nodes, -1, np.int32), np.full(nodes, -1, np.int32)
    touched = np.zeros(nodes, np.uint8)
    cost[start], pending[start] = 0.0, 0.0
    ends, node_of = [1], [start]
    cost_of, parent_of = [0.0], [-1]
    cycle = np.empty(0, np.int32)
    front = [start]
    while len(front) > 0 and len(ends) <= most:
        changed = [0] * 0
        for node in front:
            for k in range(indptr[node], indptr[node + 1]):
                head = indices[k]
                through = cost[node] + weights[k]
                if through + little < pending[head]:
                    pending[head], proposed[head] = through, node
                    if touched[head] == 0:
                        touched[head] = 1
                        changed.append(int(head))
        for node in changed:
            touched[node] = 0
            cost[node], parent[node] = pending[node], proposed[node]
            node_of.append(node)
            cost_of.append(float(cost[node]))
            parent_of.append(int(parent[node]))
        front = changed
        if len(changed) > 0:
            ends.append(len(node_of))
        if may_cycle:
            cycle = parent_cycle(parent, np.zeros(nodes, np.uint8))
            if len(cycle) > 0:
                break
    return recorded(ends, node_of, cost_of, parent_of), cycle


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
