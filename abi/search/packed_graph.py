"""The graph in the format of the kernels that search it in every plan."""

from __future__ import annotations

import numpy as np

from abi.arrays import read_only
from abi.search.graph import Graph
from abi.search.heuristic import Weight
from abi.search.search_kernels import Metric, Problem


def problem_of(graph: Graph, weight: Weight, towards: Metric) -> Problem:
    """The graph in the format of the kernels, with a heuristic."""
    weights, link_weights, largest = graph.weights, graph.link_lengths, graph.longest_edge
    if weight == "hops":
        largest = _most_hops(graph)
        weights = read_only(np.where(np.isfinite(weights), 1.0, np.inf))
        link_weights = read_only(np.ones(len(link_weights)))
    return Problem(
        graph.mesh.adjacency,
        graph.open_directions,
        weights,
        graph.tails,
        graph.heads,
        link_weights,
        graph.start,
        graph.goal,
        len(graph.own),
        largest,
        towards,
    )


def _most_hops(graph: Graph) -> float:
    """Upper bound of half the change of the heuristic along an edge, in hops.

    A link counts as one hop however far it goes; a lattice takes up to two for each cell.
    """
    longest = float(graph.link_lengths.max(initial=0.0))
    stencil = graph.mesh.stencil
    return 1.0 if stencil is None else 1.0 + longest / min(stencil.cell)
