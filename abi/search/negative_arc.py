"""An arc of negative cost, placed where Dijkstra's algorithm fails or a negative cycle arises.

It is a one-way shortcut that pays those who take it, such as a lift that recovers power on its way
down.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.errors import StageError
from abi.search.bellman_ford_rounds import bellman_ford_rounds
from abi.search.search_kernels import reconstruct_path
from abi.search.search_problem import SearchProblem
from abi.search.trace import last_labels

_HEADS = 8
"""Number of path nodes that are tried as heads."""
_TAILS = 400
"""Number of nodes that are tried as tails for each head."""
_SAMPLES = 200
"""Points of an arc whose distance from the obstacles is checked."""
_TOO_LITTLE = 1e-3
"""Least interval, over the largest weight, between too small and too large a reward."""


def with_negative_arc(problem: SearchProblem, cycle: bool) -> SearchProblem:
    """The problem with an additional arc, from a node expanded later to one of the path.

    Without a negative cycle the reward is half way between what makes the detour pay and what would
    make it pay to return; with one it is larger than the cost of returning.

    Args:
        problem: a problem without such an arc that has a path.
        cycle: whether the arc closes a negative cycle.

    Raises:
        StageError: there is no path, or no suitable pair of nodes.
    """
    arcs = problem.arcs
    none = StageError(
        "search",
        "no_negative_arc",
        "There is no place for an edge of a negative cost here.",
        "Choose a scene with a path and a finer mesh.",
    )
    cost, parent = _distances(problem, arcs.start)
    if not np.isfinite(cost[arcs.goal]):
        raise none
    path = reconstruct_path(parent, arcs.goal)[1:-1].tolist()
    places = [_place(problem, cost, head) for head in path[:: max(len(path) // _HEADS, 1)]]
    room, tail, head, way_back = max(places, default=(-np.inf, 0, 0, 0.0))
    if room == -np.inf or room <= _TOO_LITTLE * float(arcs.rows.weights.max()):
        raise none
    reward = 1.5 * way_back if cycle else way_back - room / 2
    return replace(problem, arcs=arcs.with_arc(tail, head, -reward))


def _place(problem: SearchProblem, cost: FloatArray, head: int) -> tuple[float, int, int, float]:
    """The best arc to a node of the path that goes through no obstacle.

    Returns:
        Room between the least reward that pays and the way back, the arc's ends, and the cost of
        the way from its head back to its tail.
    """
    way_back, _ = _distances(problem, head)
    reached = np.where(np.isfinite(cost), cost, 0.0)
    least = reached - cost[head]  # a larger reward makes the detour pay
    room = np.where((least > 0) & np.isfinite(way_back), way_back - least, -np.inf)
    for tail in np.argsort(-room, kind="stable")[:_TAILS].tolist():
        if np.isfinite(room[tail]) and _is_clear(problem, tail, head):
            return float(room[tail]), tail, head, float(way_back[tail])
    return -np.inf, head, head, 0.0


def _is_clear(problem: SearchProblem, tail: int, head: int) -> bool:
    """Check whether the straight line between two nodes keeps its distance from the obstacles."""
    ends = problem.arcs.points[[tail, head]]
    parts = np.linspace(0.0, 1.0, _SAMPLES)[:, None]
    line: FloatArray = ends[0] + parts * (ends[1] - ends[0])
    return bool((problem.obstacles.signed_distance(line) >= problem.margin).all())


def _distances(problem: SearchProblem, node: int) -> tuple[FloatArray, IntArray]:
    """Costs from a node, or to it, (n,), and parents."""
    trace = bellman_ford_rounds(replace(problem, arcs=replace(problem.arcs, start=node)))
    return last_labels(trace, trace.steps)
