"""Recording of the changes of cost and parent that a search makes.

Compiled by numba; they run uncompiled too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abi.arrays import ByteArray, FloatArray, IntArray
from abi.compilation.jitable import jitable
from abi.compiled import IDS, compiled
from abi.search.heap_kernels import NO_ARCS, ArcRows


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
