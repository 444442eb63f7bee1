"""A search that is mended costs what one that begins anew costs, and touches what changed."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from itertools import pairwise

import networkx
import numpy as np
import pytest

from abi.errors import AbiError
from abi.search.arcs import Arcs
from abi.search.graph import Graph
from abi.search.heuristic import Weight
from abi.search.lifelong_a_star import can_repair, lifelong_a_star
from abi.search.search import SEARCHES
from abi.search.search_kernels import reconstruct_path
from abi.search.without_edges import without_edges
from tests.abi.graphs import random_graph, walled
from tests.kernel_forms import compiled, plain

SEEDS = range(12)
WEIGHTS: tuple[Weight, ...] = ("length", "hops")


def _thinned(graph: Graph, seed: int, part: float) -> Graph:
    """The graph without some of its edges."""
    rng = np.random.default_rng(seed)
    gone = rng.random(len(graph.edges)) < part
    return without_edges(graph, [(int(a), int(b)) for a, b in graph.edges[gone]])


def _least(graph: Graph, arcs: Arcs) -> float:
    """The cost by networkx; inf without a path."""
    oracle = networkx.Graph()
    tails = np.repeat(np.arange(len(arcs.rows.indptr) - 1), np.diff(arcs.rows.indptr))
    costs = zip(tails.tolist(), arcs.rows.indices.tolist(), arcs.rows.weights.tolist(), strict=True)
    oracle.add_weighted_edges_from(costs)
    oracle.add_nodes_from((graph.start, graph.goal))
    try:
        return float(networkx.dijkstra_path_length(oracle, graph.start, graph.goal))
    except networkx.NetworkXNoPath:
        return math.inf


def _cost(before: Arcs, now: Arcs) -> float:
    """The cost of the repaired path."""
    (costs, *_), _ = lifelong_a_star(before, now)
    return float(costs[now.goal])


def _check(graph: Graph, before: Arcs, arcs: Arcs) -> None:
    (costs, parents, *_), _ = lifelong_a_star(before, arcs)
    assert costs[graph.goal] == pytest.approx(_least(graph, arcs), abs=1e-9)
    if costs[graph.goal] == math.inf:
        return
    vertices = reconstruct_path(parents, graph.goal).tolist()
    assert (vertices[0], vertices[-1]) == (graph.start, graph.goal)
    indptr, indices, weights = arcs.rows
    total = 0.0
    for tail, head in pairwise(vertices):
        row = slice(indptr[tail], indptr[tail + 1])
        total += weights[row][indices[row] == head].min()
    assert total == pytest.approx(costs[graph.goal], abs=1e-9)


@pytest.mark.parametrize("weight", WEIGHTS)
def test_it_costs_what_a_new_search_costs(weight: Weight) -> None:
    for seed in SEEDS:
        graph = random_graph(seed)
        for part in (0.01, 0.1, 0.5):
            other = _thinned(graph, seed, part)
            for before, now in ((graph, other), (other, graph)):
                _check(now, Arcs.of(before, weight), Arcs.of(now, weight))
            third = _thinned(graph, seed + 100, part)
            _check(third, Arcs.of(other, weight), Arcs.of(third, weight))


def test_what_did_not_change_is_not_searched() -> None:
    for graph in (*map(random_graph, SEEDS), walled()):
        arcs = Arcs.of(graph, "length")
        (_, _, order, relaxed), changed = lifelong_a_star(arcs, arcs)
        assert (len(order), relaxed, changed) == (0, 0, 0)


def test_little_change_is_mended_with_less_work_than_anew() -> None:
    mended = anew = 0
    for seed in SEEDS:
        graph = random_graph(seed)
        other = _thinned(graph, seed, 0.01)
        arcs = Arcs.of(other, "length")
        if not math.isfinite(_least(other, arcs)):
            continue
        (_, _, order, _), _ = lifelong_a_star(Arcs.of(graph, "length"), arcs)
        mended += len(order)
        anew += SEARCHES["a_star"](other, "length").expanded
    assert mended < anew / 2


def test_a_way_that_is_shut_and_opened_again() -> None:
    graph = random_graph(1)
    open_ = Arcs.of(graph, "length")
    row = slice(graph.indptr[graph.goal], graph.indptr[graph.goal + 1])
    edges = [(graph.goal, int(other)) for other in graph.indices[row]]
    shut = Arcs.of(without_edges(graph, edges), "length")
    assert _cost(open_, shut) == math.inf
    assert _cost(shut, open_) == pytest.approx(SEARCHES["a_star"](graph, "length").cost)


def test_python_and_compiled_do_the_same() -> None:
    for seed in SEEDS:
        graph = random_graph(seed)
        pair = Arcs.of(graph, "length"), Arcs.of(_thinned(graph, seed, 0.1), "length")
        work = partial(lifelong_a_star, *pair)
        one, two = plain(work), compiled(work)
        (costs, parents, order, relaxed), changed = one
        (other_costs, other_parents, other_order, examined), differing = two
        assert costs.tolist() == other_costs.tolist()
        assert parents.tolist() == other_parents.tolist()
        assert order.tolist() == other_order.tolist()
        assert (relaxed, changed) == (examined, differing)


def test_other_ends_or_nodes_are_refused() -> None:
    arcs = Arcs.of(random_graph(0), "length")
    assert not can_repair(replace(arcs, goal=arcs.start), arcs)
    assert not can_repair(replace(arcs, points=arcs.points + 1.0), arcs)
    with pytest.raises(AbiError, match="begin anew"):
        lifelong_a_star(replace(arcs, goal=arcs.start), arcs)
    with pytest.raises(AbiError, match="begin anew"):
        lifelong_a_star(arcs, replace(arcs, negative=(0, 1)))
