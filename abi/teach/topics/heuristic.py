"""Exercise: a heuristic that is consistent, and useful."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from abi.scene.scene import Scene
from abi.search.graph import Graph
from abi.search.search import search
from abi.teach.exercise import Counterexample, Exercise, Trial
from abi.teach.hidden_scenes import graph_of, hidden_scenes
from abi.teach.numbers import is_number, point, shown, text

_ROUNDING = 1e-9


def _trials(seed: int) -> tuple[Trial, ...]:
    scenes = hidden_scenes(seed)
    return tuple(_trial(one, telling=one is scenes[0]) for one in scenes)


def _trial(one: Scene, telling: bool) -> Trial:
    """A call for each node that has an edge, the goal among them.

    Args:
        one: the scene.
        telling: whether a useful heuristic is sure to spare nodes in it.
    """
    graph = graph_of(one)
    nodes = np.flatnonzero(np.diff(graph.indptr)).tolist()
    goal = graph.points[graph.goal].tolist()
    calls = tuple((place, goal) for place in graph.points[nodes].tolist())
    expanded = search("dijkstra", graph, "length").expanded if telling else 0
    return Trial(one, calls, {"graph": graph, "nodes": nodes, "dijkstra": expanded})


def _judge(trial: Trial, values: list[Any]) -> Counterexample | None:
    graph, nodes = trial.facts["graph"], trial.facts["nodes"]
    for call, value in enumerate(values):
        if not is_number(value):
            place = point(graph.points[nodes[call]].tolist())
            return trial.wrong(
                f"For the node at {place} it returns {shown(value)}, which is no finite number.",
                call,
            )
    estimates = dict(zip(nodes, map(float, values), strict=True))
    return _goal_fault(trial, estimates) or _edge_fault(trial, estimates) or _use(trial, estimates)


def _goal_fault(trial: Trial, estimates: dict[int, float]) -> Counterexample | None:
    graph = trial.facts["graph"]
    at_goal = estimates[graph.goal]
    if abs(at_goal) <= _ROUNDING:
        return None
    call = list(estimates).index(graph.goal)
    sentence = (
        f"At the goal itself nothing is left to go, so h must be 0; yours is {text(at_goal)}."
    )
    return trial.wrong(sentence, call, text(at_goal), "0")


def _edge_fault(trial: Trial, estimates: dict[int, float]) -> Counterexample | None:
    """The edge along which the estimate falls by most more than the edge is long."""
    graph: Graph = trial.facts["graph"]
    worst, most = None, _ROUNDING
    for node, estimate in estimates.items():
        for place in range(graph.indptr[node], graph.indptr[node + 1]):
            other, length = int(graph.indices[place]), float(graph.lengths[place])
            excess = estimate - length - estimates[other]
            if excess > most * max(length, 1.0):
                worst, most = (node, other, length), excess
    if worst is None:
        return None
    node, other, length = worst
    drop = estimates[node] - estimates[other]
    a, b = (point(graph.points[one].tolist()) for one in (node, other))
    return trial.wrong(
        f"The edge from {a} to {b} is {text(length)} long, but along it your h falls by "
        f"{text(drop)}, from {text(estimates[node])} to {text(estimates[other])}. A consistent h "
        "never falls by more than the edge is long; with yours A* may miss the shortest path.",
        list(estimates).index(node),
        f"h falls by {text(drop)}",
        f"by {text(length)} at most",
        steps=expanded_with(graph, estimates),
        right_steps=expanded_with(graph, _straight(graph, estimates)),
    )


def _use(trial: Trial, estimates: dict[int, float]) -> Counterexample | None:
    """Fault of an estimate that saves no node although any useful one does."""
    if not trial.facts["dijkstra"]:
        return None
    graph = trial.facts["graph"]
    steps, best = (expanded_with(graph, one) for one in (estimates, _straight(graph, estimates)))
    if len(steps) < trial.facts["dijkstra"]:
        return None
    return trial.wrong(
        f"It is consistent, but saves no work: with it A* expands {len(steps)} nodes, as many as "
        f"Dijkstra's algorithm does; with the straight distance {len(best)} are enough.",
        got=f"{len(steps)} nodes expanded",
        expected=f"fewer than {trial.facts['dijkstra']}",
        steps=steps,
        right_steps=best,
    )


def _straight(graph: Graph, nodes: dict[int, float]) -> dict[int, float]:
    goal = graph.points[graph.goal]
    return {node: float(np.linalg.norm(graph.points[node] - goal)) for node in nodes}


def expanded_with(graph: Graph, estimates: dict[int, float]) -> tuple[int, ...]:
    """Nodes that A* expands with estimates of the remaining length, none twice."""
    cost = {graph.start: 0.0}
    waiting = {graph.start: estimates[graph.start]}
    closed: set[int] = set()
    order: list[int] = []
    while waiting:
        node = min(waiting, key=lambda other: (waiting[other], other))
        del waiting[node]
        closed.add(node)
        order.append(node)
        if node == graph.goal:
            break
        for place in range(graph.indptr[node], graph.indptr[node + 1]):
            other = int(graph.indices[place])
            g = cost[node] + float(graph.lengths[place])
            if other not in closed and g < cost.get(other, math.inf):
                cost[other], waiting[other] = g, g + estimates[other]
    return tuple(order)


HEURISTIC = Exercise(
    name="heuristic",
    title="A consistent heuristic",
    task=(
        "Return an estimate of the length that is left from a node to the goal; both are points "
        "(x, y, z). It must be 0 at the goal and never fall along an edge by more than the edge "
        "is long, so that A* finds a shortest path and expands no node twice; and it must spare "
        "A* nodes that Dijkstra's algorithm expands."
    ),
    starter="def heuristic(node, goal):\n    return 0.0  # consistent, but of no use\n",
    lesson="03-search",
    caller="alone",
    trials=_trials,
    judge=_judge,
)
