"""Questions about searches in small graphs."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from abi.arrays import read_only
from abi.search.arcs import Arcs
from abi.search.heap_kernels import best_first_order
from abi.search.label_kernels import rounds
from abi.search.trace import SearchTrace, finished_trace, last_labels, trace_of
from abi.teach.quiz.question import QuizQuestion, chosen, of_count
from abi.teach.quiz.small_graph import edges_of, letter, small_graph, told

_FIRST = 4
"""Number of nodes of an order that is asked for."""


def shortest_length(random: np.random.Generator) -> QuizQuestion:
    """How long is the shortest path?"""
    graph = small_graph(random)
    trace = _dijkstra(graph)
    goal = letter(graph.goal)
    few = _fewest(graph).vertices
    lengths = {frozenset((a, b)): length for a, b, length in edges_of(graph)}
    legs = [lengths[frozenset(leg)] for leg in itertools.pairwise(few.tolist())]
    return of_count(
        random,
        f"The edges of a graph and their lengths are {told(graph)}. How long is the shortest path "
        f"from A to {goal}?",
        round(trace.cost),
        [sum(legs)],
        f"The path {_path(trace)} is {trace.cost:.0f} long, and none is shorter.",
        {"edges": edges_of(graph)},
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
    costs_told = ", ".join(f"{letter(node)} at {costs[node]:.0f}" for node in order)
    return chosen(
        random,
        f"The edges of a graph and their lengths are {told(graph)}. Which nodes does Dijkstra's "
        "algorithm, begun at A, expand first, in their order?",
        _chain(order),
        wrong,
        f"It always takes the least cost that waits: {costs_told}.",
        {"edges": edges_of(graph), "count": _FIRST},
    )


def fewest_edges(random: np.random.Generator) -> QuizQuestion:
    """How many edges has the path with the fewest?"""
    graph = small_graph(random)
    short, few = _dijkstra(graph), _fewest(graph)
    return of_count(
        random,
        f"The edges of a graph and their lengths are {told(graph)}. A search counts edges, not "
        f"lengths: how many has its path from A to {letter(graph.goal)}?",
        few.hops,
        [short.hops],
        f"The path {_path(few)} has {few.hops}, and none has fewer; the shortest path, "
        f"{_path(short)}, has {short.hops}.",
        {"edges": edges_of(graph)},
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
        f"The edges of a graph and their lengths are {told(graph)}. Each round of Bellman-Ford "
        "relaxes every edge once, from the costs of the round before. What does "
        f"{letter(node)} cost after {number} round{'s' if number > 1 else ''} from A?",
        round(float(costs[node])),
        [round(float(end[node]))],
        f"After {number} round{'s' if number > 1 else ''} its cost is that of the best walk of at "
        f"most {number} edge{'s' if number > 1 else ''}, {costs[node]:.0f}.",
        {"edges": edges_of(graph), "rounds": number, "node": node},
    )


def _dijkstra(graph: Arcs, whole: bool = False) -> SearchTrace:
    """Dijkstra's algorithm; ``whole`` for the costs of all nodes."""
    if not whole:
        return _best_first(graph)
    orders = (
        best_first_order(graph.rows, graph.estimates, (graph.start, node), (1.0, 0.0))
        for node in range(1, len(graph.points))
    )
    return trace_of(graph, max(orders, key=len), "best_first")


def _fewest(graph: Arcs) -> SearchTrace:
    """Dijkstra's algorithm with a cost of 1 for every edge."""
    ones = read_only(np.ones(len(graph.rows.weights)))
    return _best_first(replace(graph, rows=graph.rows._replace(weights=ones)))


def _best_first(graph: Arcs) -> SearchTrace:
    ends = graph.start, graph.goal
    order = best_first_order(graph.rows, graph.estimates, ends, (1.0, 0.0))
    return trace_of(graph, order, "best_first")


def _rounds(graph: Arcs) -> SearchTrace:
    changes, cycle = rounds(graph.rows, graph.start, False, len(graph.points), graph.little)
    order = np.full(len(changes.ends) - 1, -1, np.int32)
    return finished_trace(graph, "rounds", order, changes, cycle=cycle)


def _path(trace: SearchTrace) -> str:
    return "–".join(map(letter, trace.vertices.tolist()))


def _chain(nodes: list[int]) -> str:
    return ", ".join(map(letter, nodes))
