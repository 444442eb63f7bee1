"""Questions about scenes with boxes: their graphs, searches, edges and distances."""

from __future__ import annotations

import itertools

import numpy as np

from abi.obstacles.obstacle_set import ObstacleSet
from abi.scene.scene import Scene
from abi.search.arcs import Arcs
from abi.search.heap_kernels import best_first_order
from abi.search.replay import SearchState, replay
from abi.search.trace import trace_of
from abi.teach.hidden_scenes import boxes_of, graph_of, hidden_scenes
from abi.teach.numbers import point, text
from abi.teach.quiz.question import QuizQuestion, chosen, fixed, of_number

_POOLS = 4
"""Number of different sets of scenes for questions."""
_SEARCHES = {
    "A*": (1.0, 1.0),
    "Dijkstra's algorithm": (1.0, 0.0),
    "greedy best-first search": (0.0, 1.0),
}
_GAP = 0.02
"""Least difference of priorities in a question, [unit], so that three decimals decide."""
_EDGE_GAP = 0.05
"""Least distance of an edge in a question from the opposite decision, [unit]."""
_CLEAR, _MEETS = "It keeps clear of it.", "It meets it."


def next_node(random: np.random.Generator) -> QuizQuestion:
    """Which of four nodes that wait is expanded next?"""
    while True:
        one = _scene(random)
        name = str(random.choice(list(_SEARCHES)))
        arcs = Arcs.of(graph_of(one), "length")
        state = _stopped(random, arcs, _SEARCHES[name])
        open_nodes = state.open
        if len(open_nodes) < 4:
            continue
        promise = state.promise(open_nodes)
        best = int(promise.argmin())
        others = np.flatnonzero(promise > promise[best] + _GAP)
        if len(others) < 3 or (promise < promise[best] + _GAP).sum() > 1:
            continue
        near = others[np.argsort(promise[others])[:12]]
        picked = [best, *random.choice(near, 3, replace=False).tolist()]
        break
    nodes = [int(open_nodes[k]) for k in picked]
    numbers = {node: (float(state.cost[node]), float(arcs.estimates[node])) for node in nodes}
    rows = [
        f"{_at(arcs, node)}: g = {g:.3f}, h = {h:.3f}" for node, (g, h) in sorted(numbers.items())
    ]
    g, h = numbers[nodes[0]]
    a, b = _SEARCHES[name]
    return chosen(
        random,
        f"Of the nodes that wait in {name}, four are at " + "; ".join(rows) + ". Which of them "
        "is expanded first?",
        _at(arcs, nodes[0]),
        [_at(arcs, node) for node in nodes[1:]],
        f"It takes the least {_sum(a, b)}: here {a * g + b * h:.3f}.",
        {"search": name, "numbers": {_at(arcs, node): numbers[node] for node in nodes}},
        one,
    )


def priority_of_node(random: np.random.Generator) -> QuizQuestion:
    """What is g, h or f of a node that has just been reached?"""
    one = _scene(random)
    graph = graph_of(one)
    arcs = Arcs.of(graph, "length")
    state = _stopped(random, arcs, (1.0, 1.0))
    reached = np.flatnonzero(np.isfinite(state.cost) & (state.parent >= 0))
    node = int(random.choice(reached))
    parent = int(state.parent[node])
    places = graph.points[[node, parent, graph.goal]]
    edge = float(np.linalg.norm(places[0] - places[1]))
    straight = float(np.linalg.norm(places[0] - places[2]))
    before = float(state.cost[parent])
    asked = str(random.choice(["g", "h", "f"]))
    values = {"g": before + edge, "h": straight, "f": before + edge + straight}
    grid = float(np.abs(places[0] - places[2]).sum())
    wrong = {
        "g": [edge, before, straight],
        "h": [grid, float(np.abs(places[0] - places[2]).max()), before + edge],
        "f": [before + straight, edge + straight, before + edge + grid],
    }[asked]
    return of_number(
        random,
        f"A* with the straight distance as h comes to the node at {point(places[0])} from the one "
        f"at {point(places[1])}, whose g is {before:.3f}. The goal is at {point(places[2])}. What "
        f"is {asked} of the node, in cm?",
        values[asked],
        wrong,
        f"g = {text(before)} + {text(edge)} = {text(before + edge)}, the straight distance is "
        f"h = {text(straight)}, and f = g + h = {text(values['f'])}.",
        {"places": places.tolist(), "before": before, "asked": asked},
        scene=one,
    )


def edge_passes(random: np.random.Generator) -> QuizQuestion:
    """Does a segment meet a box?"""
    while True:
        one = _scene(random)
        low, high = (np.array(corner) for corner in boxes_of(one)[0])
        middle = random.uniform(low - 0.5, high + 0.5)
        half = random.uniform(-1.2, 1.2, 3)
        ends = np.stack([middle - half, middle + half]).round(1)
        box = ObstacleSet(one.obstacles[:1])
        distance = box.polyline_clearance(ends)
        if abs(distance) > _EDGE_GAP and np.linalg.norm(ends[1] - ends[0]) > 0.5:
            break
    meets = distance < 0
    why = (
        "Points of it lie inside, though one need not see that at its ends."
        if meets
        else f"Its least distance to the box is {text(distance)} cm."
    )
    return fixed(
        f"A segment goes straight from {point(ends[0])} to {point(ends[1])}, past a box from "
        f"{point(low)} to {point(high)}. Does it meet the box?",
        (_MEETS, _CLEAR),
        0 if meets else 1,
        why,
        {"ends": ends.tolist(), "box": [low.tolist(), high.tolist()]},
        one.replace(obstacles=[one.obstacles[0].model_dump()]),
    )


def box_distance(random: np.random.Generator) -> QuizQuestion:
    """How far is a point from a box?"""
    while True:
        one = _scene(random)
        low, high = (np.array(corner) for corner in boxes_of(one)[0])
        place = random.uniform(low - 2.0, high + 2.0).round(1)
        box = ObstacleSet(one.obstacles[:1])
        distance = float(box.signed_distance(place[None])[0])
        if distance > 0.1:
            break
    out = np.maximum(np.maximum(low - place, place - high), 0.0)
    return of_number(
        random,
        f"How far is the point {point(place)} from the box between {point(low)} and "
        f"{point(high)}, in cm?",
        distance,
        [
            float(out.sum()),
            float(out.max()),
            float(np.linalg.norm(place - (low + high) / 2)),
            float(np.linalg.norm(np.minimum(abs(place - low), abs(place - high)))),
        ],
        f"It is {point(out)} outside along x, y and z, and √(x² + y² + z²) of these is "
        f"{text(distance)}.",
        {"place": place.tolist(), "box": [low.tolist(), high.tolist()]},
        scene=one.replace(obstacles=[one.obstacles[0].model_dump()]),
    )


def consistent(random: np.random.Generator) -> QuizQuestion:
    """Along which edge does an estimate fall too much?"""
    one = _scene(random)
    graph = graph_of(one)
    edges = graph.edges[random.choice(len(graph.edges), 3, replace=False)]
    lengths = np.linalg.norm(np.diff(graph.points[edges], axis=1)[:, 0], axis=1)
    bad = int(random.integers(-1, 3))
    falls = lengths * random.uniform(0.2, 0.9, 3)
    if bad >= 0:
        falls[bad] = lengths[bad] * random.uniform(1.1, 1.6)
    first = random.uniform(4.0, 8.0, 3)
    h = np.stack([first, first - falls], axis=1).round(2)
    lengths = lengths.round(3)
    found = [k for k in range(3) if h[k, 0] - h[k, 1] > lengths[k]]
    names = ("P", "Q"), ("R", "S"), ("T", "U")
    rows = "; ".join(
        f"{a}{b} is {text(length)} long, h({a}) = {before:.2f}, h({b}) = {after:.2f}"
        for (a, b), length, (before, after) in zip(names, lengths, h, strict=True)
    )
    choices = (*(f"Not along {a}{b}" for a, b in names), "Along all three it is.")
    right = found[0] if found else 3
    why = "Along none does h fall by more than the edge is long."
    if found:
        fall, length = text(h[right, 0] - h[right, 1]), text(lengths[right])
        edge = "".join(names[right])
        why = f"Along {edge} h falls by {fall}, and it is only {length} long."
    return fixed(
        f"Three edges of a graph: {rows}. Is h consistent along them?",
        choices,
        right,
        why,
        {"lengths": lengths.tolist(), "h": h.tolist()},
        one,
    )


def _scene(random: np.random.Generator) -> Scene:
    scenes = hidden_scenes(int(random.integers(_POOLS)))
    return scenes[int(random.integers(len(scenes)))]


def _stopped(random: np.random.Generator, arcs: Arcs, factors: tuple[float, float]) -> SearchState:
    """A search stopped after some steps."""
    order = best_first_order(arcs.rows, arcs.estimates, (arcs.start, arcs.goal), factors)
    trace = trace_of(arcs, order, "best_first", factors)
    return replay(trace, int(random.integers(1, max(trace.steps, 2))))


def _at(arcs: Arcs, node: int) -> str:
    return point(arcs.points[node])


def _sum(a: float, b: float) -> str:
    return " + ".join(itertools.compress("gh", (a, b)))
