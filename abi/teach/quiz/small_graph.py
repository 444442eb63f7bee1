"""Small graphs with letters as nodes and integer lengths, as on a blackboard."""

from __future__ import annotations

import string

import numpy as np

from abi.arrays import read_only
from abi.search.arcs import Arcs
from abi.search.heap_kernels import ArcRows

_NODES = 6
_LONGEST = 9


Edge = tuple[int, int, int]
"""Two nodes, the lesser first, and the length between them."""


def edges_of(graph: Arcs) -> tuple[Edge, ...]:
    """The edges of a small graph, each once, in the order of their nodes."""
    tails = np.repeat(np.arange(_NODES), np.diff(graph.rows.indptr)).tolist()
    lengths = map(int, graph.rows.weights)
    rows = zip(tails, graph.rows.indices.tolist(), lengths, strict=True)
    return tuple(edge for edge in rows if edge[0] < edge[1])


def told(graph: Arcs) -> str:
    """The edges of a small graph with their lengths, as text."""
    return ", ".join(f"{letter(a)}–{letter(b)} {length}" for a, b, length in edges_of(graph))


def letter(node: int) -> str:
    """Name of a node."""
    return string.ascii_uppercase[node]


def small_graph(random: np.random.Generator) -> Arcs:
    """A random connected graph, without estimates: a tree and some more edges.

    The first node is the start, the last the goal.
    """
    edges = {}
    for node in range(1, _NODES):
        edges[(int(random.integers(0, node)), node)] = int(random.integers(1, _LONGEST + 1))
    for _ in range(_NODES - 1):
        a, b = sorted(random.choice(_NODES, 2, replace=False).tolist())
        edges.setdefault((a, b), int(random.integers(1, _LONGEST + 1)))
    both = sorted(
        edge for (a, b), length in edges.items() for edge in ((a, b, length), (b, a, length))
    )
    tails = np.array([tail for tail, _, _ in both])
    rows = ArcRows(
        read_only(np.searchsorted(tails, np.arange(_NODES + 1)).astype(np.int32)),
        read_only(np.array([head for _, head, _ in both], np.int32)),
        read_only(np.array([length for _, _, length in both], float)),
    )
    points = np.zeros((_NODES, 3))
    return Arcs(rows, read_only(np.zeros(_NODES)), points, 0, _NODES - 1)
