"""A plan whose path a user's own search has found."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from abi import arguments
from abi.arrays import IntArray, read_only
from abi.errors import ArgumentError, no_path
from abi.planner.plan import Plan
from abi.planner.planner import Planner
from abi.scene.scene import Scene
from abi.search.graph import Graph
from abi.search.heuristic import Weight
from abi.search.search import SEARCHES, SearchFunction, SearchResult, search

OWN = "own"
"""Name of the search in the plan."""
OwnSearch = Callable[[Graph], Any]
"""Finds a path in a graph: its nodes from start to goal, and if it likes, those it has expanded."""


def plan_with(scene: Scene, own: OwnSearch) -> Plan:
    """Plan a scene with the path of a user's own search; all later stages take it.

    Args:
        scene: the scene; its tool alone is planned, for an arm that avoids has searches of ours.
        own: gets the graph and returns the nodes of the path, or these and the expanded nodes in
            their order; no nodes where it finds no path.

    Raises:
        ArgumentError: what it returns is no path of the graph.
    """
    found: SearchFunction = partial(_searched, own)
    searches: dict[str, SearchFunction] = {**SEARCHES, scene.search.algorithm: found}
    return Planner(searches=searches)(scene.replace(arm={"avoid": False}))


def expanded_by_a_star(graph: Graph) -> tuple[int, int]:
    """Nodes that A* expands, by length: with the straight distance, and with the grid's own."""
    return _expanded_in_textbook(graph), search("a_star", graph, "length").expanded


def _expanded_in_textbook(graph: Graph) -> int:
    """Nodes that A* with a heap of (f, node) expands, none twice: of equals the lower id first."""
    left = np.linalg.norm(graph.points - graph.points[graph.goal], axis=1).tolist()
    indptr, indices, lengths = graph.indptr, graph.indices, graph.lengths
    cost, closed = {graph.start: 0.0}, set()
    heap = [(left[graph.start], graph.start)]
    while heap:
        _, node = heapq.heappop(heap)
        if node in closed:
            continue
        closed.add(node)
        if node == graph.goal:
            break
        row = slice(int(indptr[node]), int(indptr[node + 1]))
        for other, length in zip(indices[row].tolist(), lengths[row].tolist(), strict=True):
            g = cost[node] + length
            if g < cost.get(other, math.inf):
                cost[other] = g
                heapq.heappush(heap, (g + left[other], other))
    return len(closed)


def _searched(own: OwnSearch, graph: Graph, weight: Weight) -> SearchResult:
    """What the user's search finds, checked, in the form of our searches' results."""
    returned = own(graph)
    both = isinstance(returned, tuple) and len(returned) == 2 and np.ndim(returned[0]) == 1
    path, expanded = returned if both else (returned, returned)
    if path is None or not len(path):
        raise no_path(
            _ids("expanded nodes", [graph.start], graph), graph.free_nodes, graph.mesh.pitch
        )
    vertices, order = _ids("path", path, graph), _ids("expanded nodes", expanded, graph)
    for name, end, wanted in (("first", 0, graph.start), ("last", -1, graph.goal)):
        if vertices[end] != wanted:
            raise ArgumentError(f"{name} node of the path", int(vertices[end]), str(wanted))
    legs = [_leg(graph, a, b) for a, b in itertools.pairwise(vertices.tolist())]
    return SearchResult(
        algorithm=OWN,
        weight=weight,
        vertices=vertices,
        points=read_only(graph.points[vertices]),
        length=sum(legs),
        hops=len(legs),
        cost=sum(legs) if weight == "length" else float(len(legs)),
        expanded=len(order),
        relaxed=int(np.diff(graph.indptr)[order].sum()),
        order=order,
    )


def _ids(name: str, nodes: Any, graph: Graph) -> IntArray:
    given = [int(node) for node in nodes]
    return arguments.ids(name, np.array(given, np.int32), (-1,), len(graph.points))


def _leg(graph: Graph, a: int, b: int) -> float:
    """Length of an edge, [unit]."""
    row = slice(int(graph.indptr[a]), int(graph.indptr[a + 1]))
    found = np.flatnonzero(graph.indices[row] == b)
    if not len(found):
        raise ArgumentError("path", (a, b), "nodes with an edge from each to the next")
    return float(graph.lengths[row][found[0]])
