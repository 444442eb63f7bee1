"""Stage 3: shortest paths by A*, Dijkstra and Bellman-Ford (paper, section III and Table I).

All three are exact: with weights that are not negative and a consistent heuristic they find paths
of the same cost. The paths themselves, and their lengths when hops are counted, may differ.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from abi.arrays import FloatArray, IntArray, read_only
from abi.errors import NoPath
from abi.graph import Graph
from abi.kernels import search as kernels

Weight = Literal["length", "hops"]

_COMPILE_FROM = 30_000
"""Nodes from which waiting for the compiler takes less time than running without it."""


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
    """A* with the straight line to the goal as heuristic; stops at the goal.

    By hops the heuristic is the straight line divided by the longest edge: no path has fewer.

    Raises:
        NoPath: no edges lead from start to goal.
    """
    away = np.linalg.norm(graph.points - graph.points[graph.goal], axis=1)
    longest = graph.longest_edge
    to_go = away if weight == "length" else away / (longest or 1.0)
    return _best_first("a_star", graph, weight, to_go)


def dijkstra(graph: Graph, weight: Weight) -> SearchResult:
    """Dijkstra's algorithm; stops at the goal.

    Raises:
        NoPath: no edges lead from start to goal.
    """
    return _best_first("dijkstra", graph, weight, np.zeros(len(graph.points)))


def bellman_ford(graph: Graph, weight: Weight) -> SearchResult:
    """Bellman-Ford with a queue; finds the paths to all nodes.

    Raises:
        NoPath: no edges lead from start to goal.
    """
    rows = (graph.indptr, graph.indices, _weights(graph, weight))
    found = _run(kernels.bellman_ford, graph, *rows, np.int32(graph.start))
    return _result("bellman_ford", graph, weight, *found)


SEARCHES: MappingProxyType[str, Callable[[Graph, Weight], SearchResult]] = MappingProxyType(
    {"a_star": a_star, "dijkstra": dijkstra, "bellman_ford": bellman_ford}
)
"""The algorithms by name."""


def _best_first(
    algorithm: str, graph: Graph, weight: Weight, heuristic: FloatArray
) -> SearchResult:
    rows = (graph.indptr, graph.indices, _weights(graph, weight), read_only(heuristic))
    ends = (np.int32(graph.start), np.int32(graph.goal))
    found = _run(kernels.best_first, graph, *rows, *ends)
    return _result(algorithm, graph, weight, *found)


def _weights(graph: Graph, weight: Weight) -> FloatArray:
    return graph.lengths if weight == "length" else read_only(np.ones(len(graph.lengths)))


def _run(kernel: Any, graph: Graph, *arguments: Any) -> tuple[FloatArray, IntArray, IntArray, int]:
    """Call a kernel: compiled when that is ready or worth waiting for, else as plain Python."""
    if not kernels.ready.is_set() and len(graph.points) > _COMPILE_FROM:
        kernels.warm()
    if not kernels.ready.is_set():
        kernel, arguments = kernel.py_func, tuple(value.tolist() for value in arguments)
    cost, parent, order, relaxed = kernel(*arguments)
    return cost, parent, order, relaxed


def _result(
    algorithm: str,
    graph: Graph,
    weight: Weight,
    cost: FloatArray,
    parent: IntArray,
    order: IntArray,
    relaxed: int,
) -> SearchResult:
    """Follow the parents back from the goal; raises NoPath."""
    if not np.isfinite(cost[graph.goal]):
        reached = np.flatnonzero(np.isfinite(cost)).astype(np.int32)
        raise NoPath(reached, graph.free_nodes, graph.pitch)
    path = [graph.goal]
    while path[-1] != graph.start:
        path.append(int(parent[path[-1]]))
    vertices = np.array(path[::-1], dtype=np.int32)
    points = graph.points[vertices]
    return SearchResult(
        algorithm=algorithm,
        weight=weight,
        vertices=read_only(vertices),
        points=read_only(points),
        length=float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()),
        hops=len(vertices) - 1,
        cost=float(cost[graph.goal]),
        expanded=len(order),
        relaxed=int(relaxed),
        order=read_only(order),
    )
