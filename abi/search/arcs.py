"""The graph as arcs with costs, one of which may be negative, for the searches to compare."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from abi import arguments
from abi.arrays import FloatArray, ShortRepr, lock, read_only
from abi.errors import ArgumentError
from abi.search.best_first_kernels import estimates
from abi.search.graph import Graph
from abi.search.heap_kernels import ArcRows
from abi.search.heuristic import Weight, metric
from abi.search.packed_graph import problem_of
from abi.search.search_kernels import LITTLE


@dataclass(frozen=True, eq=False, repr=False)
class Arcs(ShortRepr):
    """The edges of a graph as two arcs each, with estimates of the remaining cost to the goal.

    Attributes:
        rows: the arcs.
        estimates: (n,) A*'s heuristic h; if the start is no node of the mesh, its estimate is the
            least over its neighbours.
        points: (n, 3) positions of the nodes, [unit], world.
        start, goal: node ids.
        negative: (tail, head) of the arc that was added with a cost below 0; None without one.
    """

    rows: ArcRows
    estimates: FloatArray
    points: FloatArray
    start: int
    goal: int
    negative: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        points = arguments.points("points", self.points)
        nodes = len(points)
        indices = arguments.ids("rows.indices", self.rows.indices, (-1,), nodes)
        arcs = len(indices)
        indptr = arguments.ids("rows.indptr", self.rows.indptr, (nodes + 1,), arcs + 1)
        if indptr[0] != 0 or indptr[-1] != arcs or (indptr[1:] < indptr[:-1]).any():
            raise ArgumentError("rows.indptr", "no rows", f"numbers that rise from 0 to {arcs}")
        weights = arguments.numbers("rows.weights", self.rows.weights, (arcs,), infinite=True)
        lock((indptr, indices, weights))
        arguments.keep(
            self,
            rows=ArcRows(indptr, indices, weights),
            estimates=arguments.numbers("estimates", self.estimates, (nodes,), infinite=True),
            points=points,
            start=arguments.integer("start", self.start, 0, nodes - 1),
            goal=arguments.integer("goal", self.goal, 0, nodes - 1),
        )

    @classmethod
    def of(cls, graph: Graph, weight: Weight) -> Arcs:
        """The arcs of a graph, by length or each at cost 1."""
        weights = graph.lengths if weight == "length" else read_only(np.ones(len(graph.lengths)))
        left = estimates(problem_of(graph, weight, metric(graph, weight)))
        if graph.start >= len(graph.mesh.points):
            row = slice(graph.indptr[graph.start], graph.indptr[graph.start + 1])
            left[graph.start] = (weights[row] + left[graph.indices[row]]).min(initial=np.inf)
            if not np.isfinite(left[graph.start]):
                left[graph.start] = 0.0
        rows = ArcRows(graph.indptr, graph.indices, weights)
        return cls(rows, read_only(left), graph.points, graph.start, graph.goal)

    @property
    def little(self) -> float:
        """Smallest decrease of a cost that counts."""
        return LITTLE * float(np.abs(self.rows.weights).max(initial=1.0))

    def with_arc(self, tail: int, head: int, weight: float) -> Arcs:
        """The arcs with an additional one of any cost; the estimates may then be too large.

        Raises:
            ArgumentError: an end is no node, or the cost not finite.
        """
        indptr, indices, weights = self.rows
        tail = arguments.integer("tail", tail, 0, len(self.points) - 1)
        head = arguments.integer("head", head, 0, len(self.points) - 1)
        weight = arguments.number("weight", weight)
        place = int(indptr[tail + 1])
        longer = indptr.copy()
        longer[tail + 1 :] += 1
        rows = ArcRows(
            read_only(longer),
            read_only(np.insert(indices, place, np.int32(head))),
            read_only(np.insert(weights, place, weight)),
        )
        return replace(self, rows=rows, negative=(tail, head) if weight < 0 else self.negative)
