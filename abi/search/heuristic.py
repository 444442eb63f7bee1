"""A*'s heuristic towards the goal of a graph, by length or by hops."""

from __future__ import annotations

import math
from functools import lru_cache
from operator import eq
from typing import Literal

from abi.obstacles.pose import Vec3
from abi.search.graph import Graph
from abi.search.search_kernels import INSIDE, ON_A_FACE, ZERO, Metric

Weight = Literal["length", "hops"]
"""The cost of a path: its length, or the number of its edges."""

_ONES = (1.0, 1.0, 1.0)
_HOPS = Metric(INSIDE, ZERO, axes=_ONES, faces=_ONES, diagonal=1.0, centres=2.0)
"""Every edge costs 1."""


def metric(graph: Graph, weight: Weight) -> Metric:
    """Cost of the path to the goal in the empty mesh, in the format of the kernels.

    In a lattice it counts the steps (:func:`abi.search.search_kernels.to_go`). In ``delaunay``
    it is the straight line; by hops, divided by the longest edge.
    """
    mesh, goal = graph.mesh, graph.goal
    own = goal - len(mesh.points)
    x, y, z = (mesh.points[goal] if own < 0 else graph.own[own]).tolist()
    if mesh.stencil is None:
        per_unit = 1.0 if weight == "length" else 1 / graph.longest_edge
        return Metric(INSIDE, (x, y, z), (per_unit,) * 3, ZERO, 0.0, 0.0)
    by_edges = by_length(mesh.stencil.cell) if weight == "length" else _HOPS
    place = mesh.stencil.cell_of((x, y, z))
    on_a_face = 0.0 in place or any(map(eq, place, [2.0 * count for count in mesh.cells]))
    return by_edges._replace(kind=ON_A_FACE if on_a_face else INSIDE, goal=place)


@lru_cache
def by_length(cell: Vec3) -> Metric:
    """Costs of the edges of a cell by their lengths, [unit], with the goal at the low corner."""
    x, y, z = (side * side for side in cell)
    faces = (math.sqrt(y + z), math.sqrt(x + z), math.sqrt(x + y))
    diagonal = math.sqrt(x + y + z)
    return Metric(INSIDE, ZERO, axes=cell, faces=faces, diagonal=diagonal, centres=diagonal)
