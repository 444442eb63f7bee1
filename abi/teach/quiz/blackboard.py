"""Questions about searches in small graphs."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from abi.arrays import read_only
from abi.search.heap_kernels import best_first_order
from abi.search.label_kernels import rounds
from abi.search.trace import SearchTrace, finished_trace, last_labels, trace_of
from abi.teach.quiz.question import QuizQuestion, chosen, of_count
from abi.teach.quiz.small_graph import SmallGraph, letter, small_graph

_FIRST = 4
"""Number of nodes of an order that is asked for."""


def shortest_length(random: np.random.Generator) -> QuizQuestion:
    """How long is the shortest path?"""
    graph = small_graph(random)
    trace = _dijkstra(graph)
    goal = letter(graph.arcs.goal)
    few = _fewest(graph).vertices
    legs = [graph.length(a, b) for a, b in itertools.pairwise(few.tolist())]
    return of_count(
        random,
        f"The edges of a graph and their lengths are {graph.told}. How long is the shortest path "
        f"from A to {goal}?",
        round(trace.cost),
        [sum(legs)],
        f"The path {_path(trace)} is {trace.cost:.0f} long, and none is shorter.",
        {"edges": graph.edges},
    )


def expansion_order(random: np.random.Generator) -> QuizQuestion:
    """In which order does Dijkstra's algorithm expand nodes?"""
    while True:
        graph = small_graph(random)
        trace = _dijkstra(graph, whole=True)
        costs = last_labels(trace, trace.steps)[0]
        if len(set(costs.tolist())) == len(costs):
            break
    order = trace.order[:_FIRST].tolist()
    others = [[0, *rest] for rest in itertools.permutations(range(1, len(costs)), _FIRST - 1)]
    random.shuffle(others)
    alphabet = list(range(_FIRST))
    wrong = [_chain(one) for one in [alphabet, *others] if one != order]
    told = ", ".join(f"{letter(node)} at {costs[node]:.0f}" for node in order)
    return chosen(
        random,
        f"The edges of a graph and their lengths are {graph.told}. Which nodes does Dijkstra's "
        "algorithm, begun at A, expand first, in their order?",
        _chain(order),
        wrong,
        f"It always takes the least cost that waits: {told}.",
        {"edges": graph.edges, "count": _FIRST},
    )


def fewest_edges(random: np.random.Generator) -> QuizQuestion:
    """How many edges has the path with the fewest?"""
    graph = small_graph(random)
    short, few = _dijkstra(graph), _fewest(graph)
    return of_count(
        random,
        f"The edges of a graph and their lengths are {graph.told}. A search counts edges, not "
        f"lengths: how many has its path from A to {letter(graph.arcs.goal)}?",
        few.hops,
        [short.hops],
        f"The path {_path(few)} has {few.hops}, and none has fewer; the shortest path, "
        f"{_path(short)}, has {short.hops}.",
        {"edges": graph.edges},
    )


def bellman_ford_round(random: np.random.Generator) -> QuizQuestion:
    """What does a node cost after some rounds?"""
    while True:
        graph = small_graph(random)
        trace = _rounds(graph)
        number = int(random.integers(1, 4))
        if number > trace.steps:
            continue
        costs = last_labels(trace, number)[0]
        reached = [k for k in range(1, len(costs)) if np.isfinite(costs[k])]
        late = [k for k in reached if costs[k] > last_labels(trace, trace.steps)[0][k]]
        node = int(random.choice(late or reached))
        break
    end = last_labels(trace, trace.steps)[0]
    return of_count(
        random,
        f"The edges of a graph and their lengths are {graph.told}. Each round of Bellman-Ford "
        "relaxes every edge once, from the costs of the round before. What does "
        f"{letter(node)} cost after {number} round{'s' if number > 1 else ''} from A?",
        round(float(costs[node])),
        [round(float(end[node]))],
        f"After {number} round{'s' if number > 1 else ''} its cost is that of the best walk of at "
        f"most {number} edge{'s' if number > 1 else ''}, {costs[node]:.0f}.",
        {"edges": graph.edges, "rounds": number, "node": node},
    )


def _ends(graph: SmallGraph) -> tuple[int, int]:
    return graph.arcs.start, graph.arcs.goal


def _dijkstra(graph: SmallGraph, whole: bool = False) -> SearchTrace:
    """Dijkstra's algorithm; ``whole`` for the costs of all nodes."""
    arcs = graph.arcs
    if not whole:
        order = best_first_order(arcs.rows, arcs.estimates, _ends(graph), (1.0, 0.0))
        return trace_of(arcs, order, "best_first")
    orders = (
        best_first_order(arcs.rows, arcs.estimates, (arcs.start, node), (1.0, 0.0))
        for node in range(1, len(arcs.points))
    )
    return trace_of(arcs, max(orders, key=len), "best_first")


def _fewest(graph: SmallGraph) -> SearchTrace:
    """Dijkstra's algorithm with a cost of 1 for every edge."""
    rows = graph.arcs.rows
    arcs = replace(graph.arcs, rows=rows._replace(weights=read_only(np.ones(len(rows.weights)))))
    order = best_first_order(arcs.rows, arcs.estimates, _ends(graph), (1.0, 0.0))
    return trace_of(arcs, order, "best_first")


def _rounds(graph: SmallGraph) -> SearchTrace:
    arcs = graph.arcs
    changes, cycle = rounds(arcs.rows, arcs.start, False, len(arcs.points), arcs.little)
    order = np.full(len(changes.ends) - 1, -1, np.int32)
    return finished_trace(arcs, "rounds", order, changes, cycle=cycle)


def _path(trace: SearchTrace) -> str:
    return "–".join(map(letter, trace.vertices.tolist()))


def _chain(nodes: list[int]) -> str:
    return ", ".join(map(letter, nodes))
