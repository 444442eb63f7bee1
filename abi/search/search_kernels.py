"""Graph and ends in the format of the searches' compiled loops, and the path that results."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

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


@compiled(example=(IDS, 1))
def reconstruct_path(parent: IntArray, goal: int) -> IntArray:
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


@compiled(example=(IDS, FLOATS, FLOATS))
def places_along(
    path: IntArray, places: FloatArray, own: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Places (3 k,) of a path's nodes (k,), and lengths (k - 1,) of its edges, [unit], world.

    By the places of the mesh's nodes (3 n,), and of start and goal that are no nodes of it.
    """
    points, lengths = np.empty(3 * len(path)), np.empty(len(path) - 1)
    for k in range(3 * len(path)):
        at = 3 * path[k // 3] + k % 3
        points[k] = places[at] if at < len(places) else own[at - len(places)]
    for k in range(len(lengths)):
        lengths[k] = distance(vec3_at(points, 3 * k + 3), vec3_at(points, 3 * k))
    return points, lengths
