from __future__ import annotations

import math
from itertools import pairwise

import networkx
import numpy as np
import pytest

from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.comparison import search_problem
from abi.planner.planner import Planner
from abi.scene.scene import load_scene
from abi.search.arcs import Arcs
from abi.search.compare import COMPARED
from abi.search.graph import Graph
from abi.search.heuristic import Weight
from abi.search.negative_arc import with_negative_arc
from abi.search.replay import SearchState, replay
from abi.search.search import SEARCHES
from abi.search.search_problem import SearchProblem
from abi.search.trace import SearchTrace, last_labels
from tests.abi.graphs import random_graph, walled
from tests.kernel_forms import compiled, plain
from tests.random_scenes import scattered

SEEDS = range(6)
_DISTANT = (0, 1, 3, 4, 5, 6)
"""Seeds of graphs whose path has two edges or more."""
WEIGHTS: tuple[Weight, ...] = ("length", "hops")


def problem_of(graph: Graph, weight: Weight = "length", w: float = 1.5) -> SearchProblem:
    # no obstacles: an any-angle leg then sees everything, edges or not
    return SearchProblem(graph, Arcs.of(graph, weight), weight, w, ObstacleSet(()), 0.0)


def digraph(arcs: Arcs) -> networkx.DiGraph:
    """The arcs for networkx, of two between the same nodes the cheaper one."""
    found = networkx.DiGraph()
    indptr, indices, weights = arcs.rows
    tails = np.repeat(np.arange(len(indptr) - 1), np.diff(indptr))
    for tail, head, weight in zip(tails.tolist(), indices.tolist(), weights.tolist(), strict=True):
        known = found.get_edge_data(tail, head, {"weight": math.inf})["weight"]
        found.add_edge(tail, head, weight=min(weight, known))
    return found


@pytest.mark.parametrize("weight", WEIGHTS)
@pytest.mark.parametrize("name", [name for name, one in COMPARED.items() if one.exact])
def test_exact_searches_cost_what_networkx_says(name: str, weight: Weight) -> None:
    for seed in SEEDS:
        problem = problem_of(random_graph(seed), weight)
        oracle = digraph(problem.arcs)
        trace = COMPARED[name].find(problem)
        try:
            least = networkx.dijkstra_path_length(oracle, problem.arcs.start, problem.arcs.goal)
        except networkx.NetworkXNoPath:
            assert trace.hops == -1
            assert trace.length == math.inf
            continue
        assert trace.cost == pytest.approx(least, abs=1e-9)
        legs = [oracle.edges[leg]["weight"] for leg in pairwise(trace.vertices.tolist())]
        assert sum(legs) == pytest.approx(least, abs=1e-9)
        assert (trace.vertices[0], trace.vertices[-1]) == (problem.arcs.start, problem.arcs.goal)


@pytest.mark.parametrize("w", [0.0, 0.5, 1.0, 1.2, 1.5, 1.8, 1.95])
def test_weighted_a_star_is_within_its_bound(w: float) -> None:
    worse, bound = 0, max(w / (2 - w), 1.0)
    for seed in SEEDS:
        problem = problem_of(random_graph(seed), w=w)
        trace, best = (COMPARED[name].find(problem) for name in ("weighted_a_star", "dijkstra"))
        assert best.cost - 1e-9 <= trace.cost <= bound * best.cost + 1e-9
        assert len(np.unique(trace.order)) == trace.steps
        worse += trace.cost > best.cost + 1e-9
    assert worse == 0 or w > 1


def test_weights_of_the_heuristic_reach_from_dijkstra_by_a_star_to_greedy() -> None:
    for seed in SEEDS:
        graph = random_graph(seed)
        ends = {0.0: "dijkstra", 2.0: "greedy_best_first"}
        for w, name in ends.items():
            problem = problem_of(graph, w=w)
            one, other = COMPARED["weighted_a_star"].find(problem), COMPARED[name].find(problem)
            assert one.cost == pytest.approx(other.cost)
            assert name == "dijkstra" or np.array_equal(one.order, other.order)
        steps = [COMPARED["weighted_a_star"].find(problem_of(graph, w=w)).steps for w in (0.0, 1.0)]
        assert steps[1] <= steps[0]


def test_greedy_goes_to_what_seems_nearest() -> None:
    for seed in SEEDS:
        trace = COMPARED["greedy_best_first"].find(problem_of(random_graph(seed)))
        left = trace.arcs.estimates
        for step in range(trace.steps):
            state = replay(trace, step)
            assert left[trace.order[step]] == pytest.approx(left[state.open].min())


def test_both_ends_expand_no_more_than_twice_what_they_must() -> None:
    for seed in SEEDS:
        problem = problem_of(random_graph(seed))
        trace, n = COMPARED["bidirectional_dijkstra"].find(problem), len(problem.arcs.points)
        if trace.hops < 0:
            continue
        cost, _ = last_labels(trace, trace.steps)
        of_start = cost[trace.order[trace.order < n]]
        of_goal = cost[trace.order[trace.order >= n]]
        assert of_start.max(initial=0) + of_goal.max(initial=0) <= trace.cost + 1e-9
        assert (np.diff(of_start) >= -1e-9).all()
        assert (np.diff(of_goal) >= -1e-9).all()


@pytest.mark.parametrize("seed", range(0, 30, 3))
def test_after_k_rounds_walks_of_k_arcs_are_the_best(seed: int) -> None:
    problem = problem_of(random_graph(seed))
    trace = COMPARED["bellman_ford_rounds"].find(problem)
    indptr, indices, weights = problem.arcs.rows
    tails = np.repeat(np.arange(len(indptr) - 1), np.diff(indptr))
    expected = np.full(len(problem.arcs.points), np.inf)
    expected[problem.arcs.start] = 0.0
    for k in range(trace.steps + 2):
        state = replay(trace, min(k, trace.steps))
        assert state.cost == pytest.approx(expected, abs=1e-9)
        assert state.examined == len(indices) * state.step
        through = expected[tails] + weights
        expected = expected.copy()
        np.minimum.at(expected, indices, through)


def test_lazy_theta_star_in_the_open_goes_straight() -> None:
    for seed in SEEDS:
        graph = random_graph(seed)
        trace = COMPARED["lazy_theta_star"].find(problem_of(graph))
        if trace.hops >= 0:
            straight = float(np.linalg.norm(np.subtract(*graph.points[[graph.start, graph.goal]])))
            assert trace.length == pytest.approx(straight)


@pytest.mark.slow
def test_lazy_theta_star_is_clear_and_no_longer_than_the_graphs_path() -> None:
    shorter = 0
    for seed in range(6):
        plan = Planner(compile=False)(scattered(np.random.default_rng(seed)), chosen_only=True)
        if plan.path is None:
            continue
        problem = search_problem(plan)
        trace = COMPARED["lazy_theta_star"].find(problem)
        edges = set(map(tuple, np.sort(problem.graph.edges, axis=1).tolist()))
        for a, b in pairwise(trace.vertices.tolist()):
            ends = problem.arcs.points[[a]], problem.arcs.points[[b]]
            blocked = problem.obstacles.blocked(*ends, problem.margin - 1e-9)[0]
            assert not blocked or (min(a, b), max(a, b)) in edges
        assert trace.cost == pytest.approx(trace.length)
        assert trace.length <= 1.02 * plan.path.length
        shorter += trace.length < plan.path.length - 1e-9
    assert shorter > 2


@pytest.mark.parametrize("seed", _DISTANT)
def test_a_negative_arc_deceives_dijkstra_and_not_bellman_ford(seed: int) -> None:
    problem = problem_of(random_graph(seed))
    assert COMPARED["dijkstra"].find(problem).hops >= 2
    changed = with_negative_arc(problem, cycle=False)
    assert changed.arcs.negative is not None
    oracle = digraph(changed.arcs)
    least = networkx.bellman_ford_path_length(oracle, problem.arcs.start, problem.arcs.goal)
    right, wrong = (COMPARED[name].find(changed) for name in ("bellman_ford_rounds", "dijkstra"))
    assert right.cost == pytest.approx(least, abs=1e-9)
    assert changed.arcs.negative in set(pairwise(right.vertices.tolist()))
    assert not len(right.cycle)
    assert wrong.cost > right.cost + 1e-9


@pytest.mark.parametrize("name", ["paper", "two-boxes", "forest"])
@pytest.mark.parametrize("cycle", [False, True])
def test_a_negative_arc_goes_through_no_obstacle(name: str, cycle: bool) -> None:
    scene = load_scene(name).replace(arm={"avoid": False})
    problem = with_negative_arc(search_problem(Planner()(scene)), cycle)
    tail, head = problem.arcs.points[list(problem.arcs.negative or ())]
    line = tail + np.linspace(0, 1, 1000)[:, None] * (head - tail)
    assert ObstacleSet(scene.obstacles).signed_distance(line).min() > 0


@pytest.mark.parametrize("seed", _DISTANT)
def test_a_negative_cycle_is_found(seed: int) -> None:
    problem = problem_of(random_graph(seed))
    assert COMPARED["dijkstra"].find(problem).hops >= 2
    changed = with_negative_arc(problem, cycle=True)
    trace = COMPARED["bellman_ford_rounds"].find(changed)
    cycle = trace.cycle.tolist()
    oracle = digraph(changed.arcs)
    around = [oracle.edges[leg]["weight"] for leg in pairwise([*cycle, cycle[0]])]
    assert sum(around) < 0
    assert trace.hops == -1
    assert networkx.negative_edge_cycle(oracle)


class Reference:
    """Best-first search on dictionaries, one expansion at a time."""

    def __init__(self, arcs: Arcs, reopens: bool, in_turn: bool) -> None:
        self.cost, self.parent = {arcs.start: 0.0}, {arcs.start: -1}
        self.open, self.closed = {arcs.start}, set[int]()
        self.relaxed = 0
        self._arcs, self._reopens, self._in_turn = arcs, reopens, in_turn

    def step(self, node: int) -> None:
        arcs, (indptr, indices, weights) = self._arcs, self._arcs.rows
        self.open.remove(node)
        self.closed.add(node)
        if node == arcs.goal and not self._in_turn:
            return
        for k in range(indptr[node], indptr[node + 1]):
            head, through = int(indices[k]), self.cost[node] + float(weights[k])
            self.relaxed += 1
            if head in self.closed and not self._reopens:
                continue
            if through < self.cost.get(head, math.inf) - 1e-10:
                self.cost[head], self.parent[head] = through, node
                self.open.add(head)
                self.closed.discard(head)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("name", ["a_star", "dijkstra", "bellman_ford", "greedy_best_first"])
def test_a_replay_is_what_a_plain_search_has_then(name: str, seed: int) -> None:
    problem = problem_of(random_graph(seed))
    trace = COMPARED[name].find(problem)
    if name in SEARCHES and trace.hops >= 0:
        result = SEARCHES[name](problem.graph, "length")
        assert np.array_equal(trace.order, result.order)
        assert (trace.relaxed, trace.hops) == (result.relaxed, result.hops)
        assert trace.length == pytest.approx(result.length)
    reference = Reference(problem.arcs, name in SEARCHES, in_turn=name == "bellman_ford")
    for step in range(trace.steps + 1):
        state = replay(trace, step)
        check(state, reference)
        if step < trace.steps:
            node = int(trace.order[step])
            assert state.following == node
            assert state.may_follow(node)
            assert state.queue(4)[0] == node
            reference.step(node)


def check(state: SearchState, reference: Reference) -> None:
    assert set(state.open.tolist()) == reference.open
    assert set(state.closed.tolist()) == reference.closed
    assert state.examined == reference.relaxed
    for node, cost in reference.cost.items():
        assert state.cost[node] == pytest.approx(cost, abs=1e-9)
        assert state.parent[node] == reference.parent[node]
    assert np.isfinite(state.cost).sum() == len(reference.cost)


@pytest.mark.parametrize("name", COMPARED)
def test_stepping_back_shows_what_was_there(name: str) -> None:
    trace = COMPARED[name].find(problem_of(random_graph(3)))
    first = [replay(trace, step) for step in range(trace.steps + 1)]
    for step in reversed(range(trace.steps + 1)):
        again = replay(trace, step)
        for field in ("cost", "parent", "closed", "open"):
            assert np.array_equal(getattr(again, field), getattr(first[step], field))
        assert np.array_equal(again.queue(6), first[step].queue(6))
    assert first[-1].done
    assert np.array_equal(first[-1].path(), trace.vertices)


@pytest.mark.parametrize("name", ["a_star", "dijkstra", "weighted_a_star", "lazy_theta_star"])
def test_what_promises_most_comes_next_and_what_does_not_is_refused(name: str) -> None:
    trace = COMPARED[name].find(problem_of(random_graph(4)))
    refused = 0
    for step in range(trace.steps):
        state = replay(trace, step)
        queue = state.queue(len(state.open))
        assert sorted(queue.tolist()) == sorted(state.open.tolist())
        assert (np.diff(state.promise(queue)[1:]) >= 0).all()
        refused += not state.may_follow(int(queue[-1]))
        assert not any(state.may_follow(int(node)) for node in state.closed)
    assert refused > 0


def test_who_waits_longest_is_next_in_a_first_in_queue() -> None:
    for seed in SEEDS:
        trace = COMPARED["bellman_ford"].find(problem_of(random_graph(seed)))
        for step in range(0, trace.steps, 7):
            state = replay(trace, step)
            queue = state.queue(len(state.open)).tolist()
            assert sorted(queue) == sorted(state.open.tolist())
            assert queue == trace.order[step : step + len(queue)].tolist()


@pytest.mark.parametrize("name", COMPARED)
def test_no_path_is_no_error(name: str) -> None:
    trace = COMPARED[name].find(problem_of(walled()))
    assert (trace.hops, trace.length) == (-1, math.inf)
    assert replay(trace, trace.steps).done


@pytest.mark.parametrize("name", COMPARED)
def test_compiled_and_plain_do_the_same(name: str) -> None:
    for seed in range(4):
        graph = random_graph(seed)
        one, other = (
            form(lambda graph=graph: COMPARED[name].find(problem_of(graph)))  # type: ignore[misc]
            for form in (compiled, plain)
        )
        assert same(one, other)


def same(one: SearchTrace, other: SearchTrace) -> bool:
    fields = ("order", "examined", "vertices", "cycle")
    pairs = [(getattr(one, field), getattr(other, field)) for field in fields]
    (ends, nodes, costs, parents), changes = one.changes, other.changes
    pairs += [(ends, changes.ends), (nodes, changes.nodes), (parents, changes.parents)]
    equal = all(np.array_equal(*pair) for pair in pairs)
    return equal and bool(np.allclose(costs, changes.costs, rtol=1e-12))
