"""A graph without some of its edges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from abi.arrays import read_only
from abi.search.graph import Graph


def without_edges(graph: Graph, pairs: Sequence[tuple[int, int]]) -> Graph:
    """The graph without the edges between pairs of nodes."""
    open_directions, weights = graph.open_directions.copy(), graph.weights.copy()
    kept = np.ones(len(graph.tails), dtype=np.bool_)
    mesh, count = graph.mesh, len(graph.mesh.points)
    for a, b in pairs:
        kept &= ~((graph.tails == a) & (graph.heads == b) | (graph.tails == b) & (graph.heads == a))
        if max(a, b) >= count:
            continue
        for tail, head in ((a, b), (b, a)):
            if mesh.stencil is None:
                row = np.arange(mesh.adjacency.indptr[tail], mesh.adjacency.indptr[tail + 1])
                weights[row[mesh.adjacency.indices[row] == head]] = np.inf
            else:
                heads = mesh.stencil.heads(np.array([tail], dtype=np.int32))[0]
                for bit in np.flatnonzero(heads == head).tolist():
                    open_directions[tail] &= ~np.int32(1 << bit)
    return replace(
        graph,
        open_directions=read_only(open_directions),
        weights=read_only(weights) if mesh.stencil is None else graph.weights,
        tails=read_only(graph.tails[kept]),
        heads=read_only(graph.heads[kept]),
        link_lengths=read_only(graph.link_lengths[kept]),
    )
