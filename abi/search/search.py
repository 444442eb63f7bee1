"""Stage 3: shortest paths by A*, Dijkstra and Bellman-Ford (paper, section III and Table I).

All three are exact: with weights that are not negative and a consistent heuristic they find paths
of the same cost. The paths themselves, and their lengths when hops are counted, may differ.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np

from abi.arrays import FloatArray, IntArray, ShortRepr, read_only
from abi.errors import NoPath
from abi.search import bellman_ford_kernels, best_first_kernels
from abi.search.graph import Graph
from abi.search.heuristic import Weight, metric
from abi.search.heuristic_kernels import NO_METRIC, Metric
from abi.search.search_kernels import Ends, Problem, places_along, reconstruct_path
from abi.tet_mesh.adjacency_kernels import Links, OpenEdges


@dataclass(frozen=True, eq=False, repr=False)
class SearchResult(ShortRepr):
    """A path from start to goal, and the work that it took to find it.

    Attributes:
        algorithm: ``a_star``, ``dijkstra`` or ``bellman_ford``.
        weight: what was minimised: ``length`` or ``hops``.
        vertices: (k,) node ids from start to goal.
        points: (k, 3), [unit], world.
        length: length of the path, [unit].
        hops: number of edges, k - 1.
        cost: ``length`` or ``hops``, whichever was minimised.
        expanded: number of nodes expanded, including the goal, which ends A* and Dijkstra.
        relaxed: number of edges examined.
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


def search(algorithm: str, graph: Graph, weight: Weight) -> SearchResult:
    """Search for the path from start to goal that costs least.

    A* and Dijkstra's algorithm stop at the goal; Bellman-Ford with a queue finds the paths to all
    nodes. A*'s heuristic is the cost of the path in the empty mesh
    (:func:`abi.search.heuristic.metric`).

    Args:
        algorithm: a name in :data:`SEARCHES`.
        graph: the graph.
        weight: the cost of a path: ``length`` or ``hops``.

    Raises:
        NoPath: no edges lead from start to goal.
        ValueError: no search has that name.
    """
    costs, parents, order, relaxed = _run(algorithm, graph, weight)
    least = float(costs[graph.goal])
    if math.isinf(least):
        reached = np.flatnonzero(np.isfinite(costs)).astype(np.int32)
        raise NoPath(reached, graph.free_nodes, graph.mesh.pitch)
    vertices = read_only(reconstruct_path(parents, graph.goal))
    places, own = graph.mesh.points.reshape(-1), graph.own.reshape(-1)
    points, lengths = places_along(vertices, places, own)
    return SearchResult(
        algorithm=algorithm,
        weight=weight,
        vertices=vertices,
        points=read_only(points.reshape(-1, 3)),
        length=float(lengths.sum()),
        hops=len(vertices) - 1,
        cost=least,
        expanded=len(order),
        relaxed=int(relaxed),
        order=read_only(order),
    )


SearchFunction = Callable[[Graph, Weight], SearchResult]
"""Finds the path of a graph that costs least."""
SEARCHES: Mapping[str, SearchFunction] = MappingProxyType(
    {name: partial(search, name) for name in ("a_star", "dijkstra", "bellman_ford")}
)
"""The algorithms by name."""


def order_of_expansion(algorithm: str, graph: Graph, weight: Weight) -> IntArray:
    """Nodes (m,) in the order in which one of :data:`SEARCHES` expands them."""
    return read_only(_run(algorithm, graph, weight)[2])


def problem_of(graph: Graph, weight: Weight, towards: Metric) -> Problem:
    """The graph in the format of the kernels, with a heuristic."""
    weights, link_weights, largest = graph.weights, graph.link_lengths, graph.longest_edge
    if weight == "hops":
        largest = _most_hops(graph)
        weights = read_only(np.where(np.isfinite(weights), 1.0, np.inf))
        link_weights = read_only(np.ones(len(link_weights)))
    return Problem(
        graph.mesh.adjacency,
        OpenEdges(graph.open_directions, weights),
        Links(graph.tails, graph.heads, link_weights),
        Ends(graph.start, graph.goal, len(graph.own)),
        largest,
        towards,
    )


def _run(
    algorithm: str, graph: Graph, weight: Weight
) -> tuple[FloatArray, IntArray, IntArray, int]:
    """Costs and parents of the nodes (n,), the order of expansion, and the edges tried."""
    if algorithm not in SEARCHES:
        raise ValueError(f"algorithm is {algorithm!r}; expected one of {', '.join(SEARCHES)}")
    towards = metric(graph, weight) if algorithm == "a_star" else NO_METRIC
    kernel: Any = best_first_kernels.best_first
    if algorithm == "bellman_ford":
        kernel = bellman_ford_kernels.bellman_ford
    costs, parents, order, relaxed = kernel(problem_of(graph, weight, towards))
    return costs, parents, order, relaxed


def _most_hops(graph: Graph) -> float:
    """Half the hops by which the heuristic may change along an edge, at most.

    A link counts as one hop however far it goes; a lattice takes up to two for each cell.
    """
    longest = float(graph.link_lengths.max(initial=0.0))
    stencil = graph.mesh.stencil
    return 1.0 if stencil is None else 1.0 + longest / min(stencil.cell)
