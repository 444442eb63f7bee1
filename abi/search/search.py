"""Stage 3: shortest paths by A*, Dijkstra and Bellman-Ford (paper, section III and Table I).

All three are exact: with weights that are not negative and a consistent heuristic they find paths
of the same cost. The paths themselves, and their lengths when hops are counted, may differ.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from operator import eq
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from abi.arrays import FloatArray, IntArray, read_only
from abi.errors import NoPath
from abi.search import search_kernels as kernels
from abi.search.graph import Graph
from abi.search.heuristic_kernels import NO_METRIC, ON_A_FACE, Metric
from abi.tet_mesh.adjacency import hop_norm

Weight = Literal["length", "hops"]


@dataclass(frozen=True, eq=False)
class SearchResult:
    """A path from start to goal and the work it took to find.

    Attributes:
        algorithm: ``a_star``, ``dijkstra`` or ``bellman_ford``.
        weight: what was made least: ``length`` or ``hops``.
        vertices: (k,) node ids from start to goal.
        points: (k, 3), [unit], world.
        length: length of the path, [unit].
        hops: number of edges, k - 1.
        cost: ``length`` or ``hops``, whichever was made least.
        expanded: nodes whose edges were examined, the goal that ends A* and Dijkstra included.
        relaxed: edges examined.
        order: (expanded,) node ids in the order of expansion; Bellman-Ford may repeat a node.
    """

    algorithm: str
    weight: str
    vertices: IntArray
    points: FloatArray
    length: float
    hops: int
    cost: float
    expanded: int
    relaxed: int
    order: IntArray


def a_star(graph: Graph, weight: Weight) -> SearchResult:
    """A*; stops at the goal.

    In a lattice the heuristic is what the way would cost with nothing in it, by length or by hops
    (:mod:`abi.search.heuristic_kernels`). In ``delaunay`` it is the straight line, by hops divided
    by the longest edge.

    Raises:
        NoPath: no edges lead from start to goal.
    """
    return _search("a_star", kernels.best_first, graph, weight, metric(graph, weight))


def dijkstra(graph: Graph, weight: Weight) -> SearchResult:
    """Dijkstra's algorithm; stops at the goal.

    Raises:
        NoPath: no edges lead from start to goal.
    """
    return _search("dijkstra", kernels.best_first, graph, weight, NO_METRIC)


def bellman_ford(graph: Graph, weight: Weight) -> SearchResult:
    """Bellman-Ford with a queue; finds the paths to all nodes.

    Raises:
        NoPath: no edges lead from start to goal.
    """
    return _search("bellman_ford", kernels.bellman_ford, graph, weight, NO_METRIC)


SEARCHES: MappingProxyType[str, Callable[[Graph, Weight], SearchResult]] = MappingProxyType(
    {"a_star": a_star, "dijkstra": dijkstra, "bellman_ford": bellman_ford}
)
"""The algorithms by name."""


def metric(graph: Graph, weight: Weight) -> Metric:
    """A*'s heuristic towards the goal of the graph, see :mod:`abi.search.heuristic_kernels`."""
    mesh, goal = graph.mesh, graph.goal
    inner = goal - len(mesh.points)
    x, y, z = (mesh.points[goal] if inner < 0 else graph.own[inner]).tolist()
    if mesh.stencil is None:
        scale = 1.0 if weight == "length" else 1 / graph.longest_edge
        return (1.0, scale, *mesh.norm[1:4], x, y, z, *mesh.norm[4:])
    norm = mesh.norm if weight == "length" else hop_norm()
    place = mesh.stencil.cell_of((x, y, z))
    on_a_face = 0.0 in place or any(map(eq, place, [2.0 * count for count in mesh.cells]))
    return (ON_A_FACE if on_a_face else 1.0, *norm[:4], *place, *norm[4:])


def _search(
    algorithm: str, kernel: Any, graph: Graph, weight: Weight, towards: Metric
) -> SearchResult:
    """Search the graph by one of the kernels."""
    weights, link_weights, largest = graph.weights, graph.link_lengths, graph.longest_edge
    if weight == "hops":
        largest = _most_hops(graph)
        weights = read_only(np.where(np.isfinite(weights), 1.0, np.inf))
        link_weights = read_only(np.ones(len(link_weights)))
    found = kernel(
        *graph.mesh.net,
        *(graph.exits, weights, graph.tails, graph.heads, link_weights, len(graph.own)),
        *(graph.start, graph.goal, largest, towards),
    )
    return _result(algorithm, graph, weight, *found)


def _most_hops(graph: Graph) -> float:
    """So many hops the heuristic may change by along an edge, at the most by twice as many.

    A link counts as one hop however far it goes; a lattice takes up to two for each cell.
    """
    longest = float(graph.link_lengths.max(initial=0.0))
    stencil = graph.mesh.stencil
    return 1.0 if stencil is None else 1.0 + longest / min(stencil.cell)


def _result(
    algorithm: str,
    graph: Graph,
    weight: Weight,
    cost: FloatArray,
    parent: IntArray,
    order: IntArray,
    relaxed: int,
) -> SearchResult:
    """The path that leads to the goal; raises NoPath."""
    least = float(cost[graph.goal])
    if math.isinf(least):
        reached = np.flatnonzero(np.isfinite(cost)).astype(np.int32)
        raise NoPath(reached, graph.free_nodes, graph.pitch)
    vertices = kernels.walked(parent, graph.goal)
    points = graph.places(vertices)
    return SearchResult(
        algorithm=algorithm,
        weight=weight,
        vertices=read_only(vertices),
        points=read_only(points),
        length=float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()),
        hops=len(vertices) - 1,
        cost=least,
        expanded=len(order),
        relaxed=int(relaxed),
        order=read_only(order),
    )
