"""Small graphs with letters as nodes and integer lengths, as on a blackboard."""

from __future__ import annotations

import string
from dataclasses import dataclass

import numpy as np

from abi.arrays import read_only
from abi.search.arcs import Arcs
from abi.search.heap_kernels import ArcRows

_NODES = 6
_LONGEST = 9


@dataclass(frozen=True, eq=False)
class SmallGraph:
    """A graph whose nodes are A, B, C, …; the first is the start, the last the goal.

    Attributes:
        edges: (node, node, length), each once.
        arcs: the same for searches, without estimates.
    """

    edges: tuple[tuple[int, int, int], ...]
    arcs: Arcs

    @property
    def told(self) -> str:
        """The edges with their lengths, as text."""
        return ", ".join(f"{letter(a)}–{letter(b)} {length}" for a, b, length in self.edges)

    def length(self, a: int, b: int) -> int:
        """Length of the edge between two nodes."""
        return next(length for *ends, length in self.edges if set(ends) == {a, b})


def letter(node: int) -> str:
    """Name of a node."""
    return string.ascii_uppercase[node]


def small_graph(random: np.random.Generator) -> SmallGraph:
    """A random connected graph: a tree and some more edges."""
    edges = {}
    for node in range(1, _NODES):
        edges[(int(random.integers(0, node)), node)] = int(random.integers(1, _LONGEST + 1))
    for _ in range(_NODES - 1):
        a, b = sorted(random.choice(_NODES, 2, replace=False).tolist())
        edges.setdefault((a, b), int(random.integers(1, _LONGEST + 1)))
    ordered = tuple((a, b, length) for (a, b), length in sorted(edges.items()))
    return SmallGraph(ordered, _arcs(ordered))


def _arcs(edges: tuple[tuple[int, int, int], ...]) -> Arcs:
    both = sorted([*edges, *((b, a, length) for a, b, length in edges)])
    tails = np.array([tail for tail, _, _ in both])
    rows = ArcRows(
        read_only(np.searchsorted(tails, np.arange(_NODES + 1)).astype(np.int32)),
        read_only(np.array([head for _, head, _ in both], np.int32)),
        read_only(np.array([length for _, _, length in both], float)),
    )
    points = np.zeros((_NODES, 3))
    return Arcs(rows, read_only(np.zeros(_NODES)), points, 0, _NODES - 1)
