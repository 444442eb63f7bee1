"""Graph libraries that search a stored mesh: each with what it does best.

All search for the shortest path by length; none knows the lattice.
"""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Callable

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import Obstacles
from abi.search.graph import Graph
from benchmarks.stored_mesh import StoredMesh

Library = Callable[[Graph, Obstacles, float], float]
"""Length of the path in a frame: our graph, for its ends; the obstacles; the margin."""

_MOST_NETWORKX = 30_000


def installed(stored: StoredMesh) -> dict[str, Library]:
    """The libraries that are installed, by name."""
    libraries: dict[str, Library] = {"scipy": _Scipy(stored).length}
    if importlib.util.find_spec("networkit"):
        libraries["networkit"] = _Networkit(stored).length
    if importlib.util.find_spec("igraph"):
        libraries["igraph"] = _Igraph(stored).length
    if len(stored.points) <= _MOST_NETWORKX:
        libraries["networkx"] = _Networkx(stored).length
    return libraries


class _Scipy:
    """One matrix, whose rows are exchanged."""

    def __init__(self, stored: StoredMesh) -> None:
        self._stored = stored
        indptr, heads, lengths = stored.rows
        rows = (lengths.copy(), heads.copy(), indptr.copy())
        self._matrix = csr_array(rows, shape=(len(indptr) - 1,) * 2)

    def length(self, graph: Graph, obstacles: Obstacles, margin: float) -> float:
        """Dijkstra's algorithm over the open rows, and the path's nodes."""
        matrix = self._matrix
        matrix.indptr, matrix.indices, matrix.data = self._stored.open_rows(obstacles, margin)
        cost, parents = dijkstra(matrix, indices=graph.start, return_predecessors=True)
        path = [graph.goal]
        while path[-1] != graph.start:
            path.append(int(parents[path[-1]]))
        return float(cost[graph.goal])


class _Networkit:
    """A new graph for each frame."""

    def __init__(self, stored: StoredMesh) -> None:
        self._stored = stored
        self._goal_distance: FloatArray | None = None

    def length(self, graph: Graph, obstacles: Obstacles, margin: float) -> float:
        """A* with the straight line."""
        import networkit

        networkit.setNumberOfThreads(1)
        indptr, heads, weights = self._stored.open_rows(obstacles, margin)
        ids = np.arange(len(indptr) - 1, dtype=np.uint64)
        tails, ends = np.repeat(ids, np.diff(indptr)), ids[heads]
        once = tails < ends
        network = networkit.GraphFromCoo(
            (weights[once], (tails[once], ends[once])),
            n=len(indptr) - 1,
            weighted=True,
            directed=False,
        )
        if self._goal_distance is None:
            self._goal_distance = np.linalg.norm(graph.points - graph.points[graph.goal], axis=1)
        search = networkit.distance.AStar(network, self._goal_distance, graph.start, graph.goal)
        search.run()
        search.getPath()
        return float(search.getDistance())


class _Igraph:
    """The whole mesh, in which shut edges weigh infinitely much."""

    def __init__(self, stored: StoredMesh) -> None:
        import igraph

        self._stored = stored
        indptr, heads, lengths = stored.rows
        self._once = np.flatnonzero(stored.tails < heads)
        self._lengths = lengths[self._once]
        ends = np.stack([stored.tails, heads], axis=1)[self._once]
        self._network = igraph.Graph(len(indptr) - 1, ends.tolist())

    def length(self, graph: Graph, obstacles: Obstacles, margin: float) -> float:
        """Dijkstra's algorithm, from start to goal."""
        shut = self._stored.shut_edges(obstacles, margin)[self._once]
        path = self._network.get_shortest_path(
            graph.start,
            graph.goal,
            weights=np.where(shut, np.inf, self._lengths).tolist(),
            output="vpath",
        )
        return _length(graph, path)


class _Networkx:
    """The whole mesh, of whose edges each is looked up when the search comes to it."""

    def __init__(self, stored: StoredMesh) -> None:
        import networkx

        self._stored = stored
        self._network = networkx.Graph()
        _, heads, lengths = stored.rows
        columns = (column.tolist() for column in (stored.tails, heads, lengths))
        for k, (a, b, length) in enumerate(zip(*columns, strict=True)):
            if a < b:
                self._network.add_edge(a, b, length=length, index=k)
        self._points = stored.points.tolist()

    def length(self, graph: Graph, obstacles: Obstacles, margin: float) -> float:
        """A* with the straight line."""
        import networkx

        shut = self._stored.shut_edges(obstacles, margin).tobytes()
        goal = self._points[graph.goal]
        path = networkx.astar_path(
            self._network,
            graph.start,
            graph.goal,
            heuristic=lambda node, _: math.dist(self._points[node], goal),
            weight=lambda a, b, edge: None if shut[edge["index"]] else edge["length"],
        )
        return _length(graph, path)


def _length(graph: Graph, path: list[int]) -> float:
    return float(np.linalg.norm(np.diff(graph.points[path], axis=0), axis=1).sum())
