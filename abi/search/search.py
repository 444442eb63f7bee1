"""Stage 3: shortest paths by A*, Dijkstra and Bellman-Ford (paper, section III and Table I).

A new search is a function like :func:`a_star`, in a file beside this one, and an entry in
:data:`SEARCHES`. All are exact: with weights that are not negative and a consistent heuristic they
find paths of the same cost. The paths themselves, and their lengths when hops are counted, may
differ.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

import numpy as np

from abi.arrays import FloatArray, IntArray, ShortRepr, read_only
from abi.errors import no_path
from abi.scene.settings import Algorithm
from abi.search.best_first_kernels import best_first
from abi.search.graph import Graph
from abi.search.heuristic import Weight, metric
from abi.search.label_kernels import bellman_ford
from abi.search.packed_graph import problem_of
from abi.search.search_kernels import NO_METRIC, places_along, reconstruct_path


@dataclass(frozen=True, eq=False, repr=False)
class SearchResult(ShortRepr):
    """A path from start to goal, and the work that it took to find it.

    Attributes:
        algorithm: its name in :data:`SEARCHES`.
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


Expanded = tuple[FloatArray, IntArray, IntArray, int]
"""What a search finds of n nodes: costs, parents, the order of expansion, and edges examined.

Costs (n,) are the least from the start, inf where it was not reached; parents (n,) the nodes
before, -1 where there is none; the order (m,) node ids.
"""


@dataclass(frozen=True)
class PlannedSearch:
    """A search that every plan runs; called with a graph and a weight it finds the path.

    Attributes:
        name: in scene files and plans.
        label: its name on the page.
        expand: the search itself.
        queue: which node it expands next.
        factors: weights of g and h in the sum that a best-first search minimises.
    """

    name: Algorithm
    label: str
    expand: Callable[[Graph, Weight], Expanded]
    queue: Literal["best_first", "first_in"] = "best_first"
    factors: tuple[float, float] = (1.0, 0.0)

    def __call__(self, graph: Graph, weight: Weight) -> SearchResult:
        """Find the cheapest path from start to goal.

        Args:
            graph: the graph.
            weight: the cost of a path: ``length`` or ``hops``.

        Raises:
            StageError: no edges lead from start to goal.
        """
        costs, parents, order, relaxed = self.expand(graph, weight)
        least = float(costs[graph.goal])
        if math.isinf(least):
            reached = np.flatnonzero(np.isfinite(costs)).astype(np.int32)
            raise no_path(reached, graph.free_nodes, graph.mesh.pitch)
        vertices = read_only(reconstruct_path(parents, graph.goal))
        places, own = graph.mesh.points.reshape(-1), graph.own.reshape(-1)
        points, lengths = places_along(vertices, places, own)
        return SearchResult(
            algorithm=self.name,
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


def a_star(graph: Graph, weight: Weight) -> Expanded:
    """Search best-first by g + h; h is the cost of the path in the empty mesh."""
    return best_first(problem_of(graph, weight, metric(graph, weight)))


def dijkstra(graph: Graph, weight: Weight) -> Expanded:
    """Search best-first by g until the goal is expanded."""
    return best_first(problem_of(graph, weight, NO_METRIC))


def bellman_ford_by_queue(graph: Graph, weight: Weight) -> Expanded:
    """Find the paths to all nodes by Bellman-Ford with a queue."""
    return bellman_ford(problem_of(graph, weight, NO_METRIC))


SEARCHES: Mapping[str, PlannedSearch] = MappingProxyType(
    {
        one.name: one
        for one in (
            PlannedSearch("a_star", "A*", a_star, factors=(1.0, 1.0)),
            PlannedSearch("dijkstra", "Dijkstra", dijkstra),
            PlannedSearch(
                "bellman_ford", "Bellman-Ford (queue)", bellman_ford_by_queue, queue="first_in"
            ),
        )
    }
)
"""The searches of every plan by name, in the order in which they run and are shown."""
SearchFunction = Callable[[Graph, Weight], SearchResult]
"""Function that finds the cheapest path of a graph."""


def search(algorithm: str, graph: Graph, weight: Weight) -> SearchResult:
    """Find the cheapest path from start to goal.

    Args:
        algorithm: a name in :data:`SEARCHES`.
        graph: the graph.
        weight: the cost of a path: ``length`` or ``hops``.

    Raises:
        StageError: no edges lead from start to goal.
        ValueError: no search has that name.
    """
    if algorithm not in SEARCHES:
        raise ValueError(f"algorithm is {algorithm!r}; expected one of {', '.join(SEARCHES)}")
    return SEARCHES[algorithm](graph, weight)
