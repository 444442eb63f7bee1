"""Stances of an arm all over a mesh: its joints with the tip at each node, from node to node."""

from __future__ import annotations

import numpy as np

from abi.arm.chain_kernels import TABLE, ChainTable, reach_point, room_of
from abi.arrays import BoolArray, FloatArray, IntArray
from abi.compiled import FLOATS, IDS, NEW_FLAGS, NEW_FLOATS, compiled

_MOST_ITERATIONS = 15
_TRIES = 3
"""Neighbours from which a node is tried."""


@compiled(example=(TABLE, IDS, IDS, FLOATS, 0, FLOATS, (0.0, 0.0, 1.0), NEW_FLOATS, NEW_FLAGS))
def spread(
    chain: ChainTable,
    indptr: IntArray,
    indices: IntArray,
    points: FloatArray,
    first: int,
    home: FloatArray,
    rules: tuple[float, float, float],
    stances: FloatArray,
    reached: BoolArray,
) -> None:
    """Spread inverse kinematics over a mesh, breadth first, each node from a neighbour's stance.

    A node whose stance is far from its neighbour's belongs to another sheet and is not reached
    from there: no motion runs between them.

    Args:
        chain: the chain and its task.
        indptr: where each node's neighbours begin, (n + 1,).
        indices: the neighbours.
        points: the nodes, flat (3 n,), [m], world.
        first: node to begin with.
        home: coordinates to begin with, and that spare joints drift to, (m,).
        rules: part of the way home for each reach that the tip travels, error that still counts as
            reached, and the largest step of a coordinate between neighbours.
        stances: coordinates at each node reached, flat (n m,); written.
        reached: (n,), False at first; written.
    """
    count, nodes = len(home), len(reached)
    pull, allowed, longest = rules
    room, q = room_of(chain, count), home.copy()
    queue, tries = np.empty(nodes, np.int32), np.zeros(nodes, np.int32)
    if reach_point(chain, q, home, points, first, -1.0, 4 * _MOST_ITERATIONS, room) > allowed:
        return
    for j in range(count):
        stances[first * count + j] = q[j]
    queue[0], reached[first] = first, True
    done, found = 0, 1
    while done < found:
        node = queue[done]
        done += 1
        for place in range(indptr[node], indptr[node + 1]):
            to = indices[place]
            if reached[to] or tries[to] >= _TRIES:
                continue
            tries[to] += 1
            for j in range(count):
                q[j] = stances[node * count + j]
            if reach_point(chain, q, home, points, to, pull, _MOST_ITERATIONS, room) > allowed:
                continue
            jump = 0.0
            for j in range(count):
                jump = max(jump, abs(q[j] - stances[node * count + j]))
            if jump > longest:
                continue
            for j in range(count):
                stances[to * count + j] = q[j]
            queue[found], reached[to] = to, True
            found += 1
