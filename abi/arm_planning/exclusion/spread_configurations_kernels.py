"""Joint positions of a URDF arm with the tip at each node of a mesh, spread node by node."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.compiled import FLOATS, IDS, NEW_FLAGS, NEW_FLOATS, compiled
from abi.robot.kinematics.chain_kernels import TABLE, ChainTable
from abi.robot.kinematics.follow_path_kernels import NO_DRIFT, Drift, reach_point, room_of

_MOST_ITERATIONS = 15
_TRIES = 3
"""Neighbours from which a node is tried."""


class Nodes(NamedTuple):
    """Nodes of a mesh and their neighbours, as compressed rows.

    Attributes:
        points: the nodes, flat (3 n,), [m], world.
        indptr: where each node's neighbours begin, (n + 1,).
        indices: the neighbours.
    """

    points: FloatArray
    indptr: IntArray
    indices: IntArray


class SpreadLimits(NamedTuple):
    """Conditions on a configuration.

    Attributes:
        error: what a configuration may lack, over the reach or in [rad].
        step: the largest of a coordinate between neighbours, [rad] or [m].
    """

    error: float
    step: float


_NODES, _LIMITS = Nodes(FLOATS, IDS, IDS), SpreadLimits(0.0, 1.0)


@compiled(example=(TABLE, _NODES, 0, NO_DRIFT, _LIMITS, NEW_FLOATS, NEW_FLAGS))
def spread(
    chain: ChainTable,
    nodes: Nodes,
    first: int,
    drift: Drift,
    limits: SpreadLimits,
    configurations: FloatArray,
    reached: BoolArray,
) -> None:
    """Spread inverse kinematics over a mesh, breadth first, each node from a neighbour.

    A node whose configuration is far from its neighbour's belongs to another sheet and is not
    reached from there: no motion runs between them.

    Args:
        chain: the chain and its task.
        nodes: of the mesh.
        first: node to begin with.
        drift: of joints to spare.
        limits: what counts as reached.
        configurations: coordinates at each node reached, flat (n m,); written. Those of the first
            node are what it is reached from.
        reached: (n,), False at first; written.
    """
    points, indptr, indices = nodes
    allowed, longest = limits
    count, total = len(drift.home), len(reached)
    room = room_of(chain, count)
    q = configurations[first * count : (first + 1) * count].copy()
    queue, tries = np.empty(total, np.int32), np.zeros(total, np.int32)
    still = Drift(drift.home, -1.0)
    if reach_point(chain, q, still, points, first, 4 * _MOST_ITERATIONS, room) > allowed:
        return
    for j in range(count):
        configurations[first * count + j] = q[j]
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
                q[j] = configurations[node * count + j]
            if reach_point(chain, q, drift, points, to, _MOST_ITERATIONS, room) > allowed:
                continue
            jump = 0.0
            for j in range(count):
                jump = max(jump, abs(q[j] - configurations[node * count + j]))
            if jump > longest:
                continue
            for j in range(count):
                configurations[to * count + j] = q[j]
            queue[found], reached[to] = to, True
            found += 1
