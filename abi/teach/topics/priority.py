"""Exercise: the priority by which A* chooses the next node."""

from __future__ import annotations

import contextlib
import math
from typing import Any

import numpy as np

from abi.errors import StageError
from abi.search.graph import Graph
from abi.teach.exercise import Counterexample, Exercise, Trial
from abi.teach.hidden_scenes import graph_of, hidden_scenes, rows_of
from abi.teach.numbers import point, text

_TIE = 1e-9
"""Relative difference of priorities that counts as a tie."""


def _trials(seed: int) -> tuple[Trial, ...]:
    """Hidden scenes, each second one on random nodes: of a lattice many sums are equal."""
    scenes = [*hidden_scenes(seed)]
    for number in range(1, len(scenes), 2):
        other = scenes[number].replace(mesh={"lattice": "delaunay", "seed": number})
        with contextlib.suppress(StageError):
            graph_of(other)
            scenes[number] = other
    return tuple(
        Trial(one, ((rows_of(graph_of(one)),),), {"graph": graph_of(one)}) for one in scenes
    )


def _judge(trial: Trial, values: list[Any]) -> Counterexample | None:
    """Follow the student's order: each node must have the least g + h of those waiting."""
    graph, order = trial.facts["graph"], values[0]
    fault = first_fault(graph, order)
    if fault is None:
        return None
    number, sentence = fault
    return trial.wrong(
        sentence,
        got=f"{len(order)} nodes expanded",
        expected=f"{len(expanded_by_a_star(graph))} nodes expanded",
        steps=tuple(order[: number + 1]),
        right_steps=expanded_by_a_star(graph, tuple(order[:number])),
    )


def first_fault(graph: Graph, order: list[int]) -> tuple[int, str] | None:
    """The first step that A* would not take, and why; None if there is none.

    One that is missing is the step after the last.
    """
    heuristic = straight_lines(graph)
    cost = {graph.start: 0.0}
    closed: set[int] = set()
    for number, node in enumerate(order):
        waiting = {other: g + heuristic[other] for other, g in cost.items() if other not in closed}
        if node not in waiting:
            return number, f"In step {number + 1} your search expands a node that is not waiting."
        best = min(waiting, key=waiting.__getitem__)
        if waiting[node] > waiting[best] + _TIE * max(waiting[best], 1.0):
            one, other = waiting[node], waiting[best]
            digits = next(k for k in range(4, 18) if f"{one:.{k}g}" != f"{other:.{k}g}")
            taken, least = (_sum(cost, heuristic, one, digits) for one in (node, best))
            return number, (
                f"In step {number + 1} your search expands the node at {_place(graph, node)} with "
                f"g + h = {taken}, although the node at "
                f"{_place(graph, best)} is waiting with a smaller g + h = "
                f"{least}."
            )
        _expand(graph, node, cost, closed)
    if not order or order[-1] != graph.goal:
        return len(order), f"Your search ends after step {len(order)}, before it is at the goal."
    return None


def expanded_by_a_star(graph: Graph, first: tuple[int, ...] = ()) -> tuple[int, ...]:
    """Nodes that A* with the straight-line distance expands, continuing the given ones."""
    heuristic = straight_lines(graph)
    cost = {graph.start: 0.0}
    closed: set[int] = set()
    order: list[int] = []
    while not order or order[-1] != graph.goal:
        if len(order) < len(first):
            node = first[len(order)]
        else:
            waiting = [other for other in cost if other not in closed]
            if not waiting:
                break
            node = min(waiting, key=lambda other: (cost[other] + heuristic[other], other))
        order.append(node)
        _expand(graph, node, cost, closed)
    return tuple(order)


def straight_lines(graph: Graph) -> list[float]:
    """Straight distances from the nodes to the goal, [unit]."""
    away = np.linalg.norm(graph.points - graph.points[graph.goal], axis=1)
    return [float(distance) for distance in away]


def _expand(graph: Graph, node: int, cost: dict[int, float], closed: set[int]) -> None:
    closed.add(node)
    row = slice(graph.indptr[node], graph.indptr[node + 1])
    for other, length in zip(graph.indices[row].tolist(), graph.lengths[row].tolist(), strict=True):
        if other not in closed:
            cost[other] = min(cost.get(other, math.inf), cost[node] + length)


def _place(graph: Graph, node: int) -> str:
    return point(graph.points[node].tolist())


def _sum(cost: dict[int, float], heuristic: list[float], node: int, digits: int) -> str:
    g, h = cost[node], heuristic[node]
    return f"{text(g)} + {text(h)} = {g + h:.{digits}g}"


PRIORITY = Exercise(
    name="priority",
    title="The priority of a best-first search",
    task=(
        "The search always expands the node with the least priority next. Of a node, g is the "
        "length of the best path found from the start, h the straight distance to the goal. "
        "Return the priority with which it finds a shortest path and expands as few nodes as "
        "these numbers allow. Where two nodes are as good, either may come first."
    ),
    starter="def priority(g, h):\n    return g  # Dijkstra: it looks in all directions\n",
    lesson="03-search",
    caller="search",
    trials=_trials,
    judge=_judge,
)
