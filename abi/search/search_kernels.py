"""Graph and ends in the format of the searches' compiled loops, and the path that results."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable

from abi.arrays import FloatArray, IntArray
from abi.compiled import FLOATS, IDS, compiled
from abi.obstacles.vector_kernels import distance, vec3_at
from abi.search.heuristic_kernels import NO_METRIC, Metric
from abi.tet_mesh.adjacency_kernels import NO_ADJACENCY, Adjacency, Links, OpenEdges

LITTLE = 1e-11
"""Part of the largest weight by which a cost must fall to be worth it."""


class Ends(NamedTuple):
    """Ends of a path.

    Attributes:
        start, goal: node ids.
        own: how many of the two are no nodes of the mesh.
    """

    start: int
    goal: int
    own: int


class Problem(NamedTuple):
    """A graph, and the path that is searched in it.

    Attributes:
        adjacency: the mesh.
        opened: its open edges.
        links: the edges of start and goal.
        ends: start and goal.
        largest: an upper bound of the weights, above 0; the estimates of nodes one edge away
            from the same node differ by at most four times as much.
        metric: the heuristic.
    """

    adjacency: Adjacency
    opened: OpenEdges
    links: Links
    ends: Ends
    largest: float
    metric: Metric


EXAMPLE = (
    Problem(
        NO_ADJACENCY, OpenEdges(IDS, FLOATS), Links(IDS, IDS, FLOATS), Ends(0, 0, 1), 1.0, NO_METRIC
    ),
)
"""Example of a problem, for the compiler."""


@compiled(example=(IDS, 1), error_model="numpy")
def reconstruct_path(parent: IntArray, goal: int) -> IntArray:
    """Nodes (k,) from the start, whose parent is -1, to the goal; by their parents (n,)."""
    return _path(parent, goal)


@compiled(example=(IDS, 1, FLOATS, FLOATS), error_model="numpy")
def measure_path(
    parent: IntArray, goal: int, places: FloatArray, own: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """That path and its measures.

    Args:
        parent: (n,) parents.
        goal: its last node.
        places: (3 m,) positions of the mesh's nodes, [unit], world.
        own: (3 (n - m),) those of start and goal that are no nodes of it.

    Returns:
        Nodes (k,), their positions (3 k,) and the lengths of the edges (k - 1,), [unit], world.
    """
    found = _path(parent, goal)
    points, lengths = np.empty(3 * len(found)), np.empty(len(found) - 1)
    for k in range(len(found)):
        at = 3 * found[k]
        for axis in range(3):
            beyond = at + axis - len(places)
            points[3 * k + axis] = places[at + axis] if beyond < 0 else own[beyond]
    for k in range(len(lengths)):
        lengths[k] = distance(vec3_at(points, 3 * k + 3), vec3_at(points, 3 * k))
    return found, points, lengths


@register_jitable
def _path(parent: IntArray, goal: int) -> IntArray:
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
