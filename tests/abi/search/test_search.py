from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import pairwise, permutations
from typing import Any, get_args

import networkx
import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.csgraph import dijkstra as scipy_dijkstra

from abi.arrays import FloatArray, read_only
from abi.errors import NO_PATH, StageError
from abi.obstacles.obstacle_set import NO_OBSTACLES
from abi.obstacles.primitives import Box
from abi.scene.lattices import LATTICES, Lattice
from abi.scene.settings import Algorithm, MeshSettings, Workspace
from abi.search import best_first_kernels, heuristic, label_kernels
from abi.search.build_graph import build_graph
from abi.search.graph import Graph
from abi.search.heuristic import Weight
from abi.search.search import SEARCHES, search
from abi.search.search_kernels import INSIDE, NO_METRIC, ON_A_FACE, Problem, to_go
from abi.tet_mesh.adjacency import NO_IDS, NO_NUMBERS, of_rows
from abi.tet_mesh.adjacency_kernels import BCC, KUHN, MeshSizes, cell, node_at
from abi.tet_mesh.exclusion import exclude
from abi.tet_mesh.lattice import REGULAR
from abi.tet_mesh.tet_mesh import tetrahedralise
from tests.abi.graphs import graph_of, random_graph, walled
from tests.kernel_forms import compiled, kernels_as, plain
from tests.thorough import of_each_kind

WEIGHTS: tuple[Weight, ...] = ("length", "hops")


def matrix(graph: Graph, weight: Weight) -> csr_array:
    data = graph.lengths if weight == "length" else np.ones(len(graph.lengths))
    n = len(graph.points)
    return csr_array((data, graph.indices, graph.indptr), shape=(n, n))


def costs_from(graph: Graph, weight: Weight, node: int) -> FloatArray:
    return np.asarray(scipy_dijkstra(matrix(graph, weight), indices=node))


def promises(graph: Graph, weight: Weight) -> FloatArray:
    """A*'s heuristic (n,), 0 at start and goal where they are nodes of their own."""
    metric = heuristic.metric(graph, weight)
    shape = graph.mesh.adjacency.shape
    left = np.zeros(len(graph.points))
    for node in range(len(graph.mesh.points)):
        lattice = graph.mesh.stencil is not None
        at = cell(shape, node) if lattice else graph.points[node].tolist()
        left[node] = to_go(shape, metric, at)
    slack = 0.0
    for a, b, length in zip(graph.tails, graph.heads, graph.link_lengths, strict=True):
        if graph.goal in (a, b) and (end := a if b == graph.goal else b) < len(graph.mesh.points):
            slack = max(slack, left[end] - (length if weight == "length" else 1))
    return np.maximum(left - slack, 0)


def degrees(graph: Graph) -> Any:
    return np.diff(graph.indptr)


@pytest.fixture(params=["plain", "compiled"])
def way(request: pytest.FixtureRequest) -> Iterator[str]:
    """Run the test's searches as plain Python and compiled."""
    with kernels_as(compiled=request.param == "compiled"):
        yield request.param


def test_a_search_that_there_is_not_is_refused() -> None:
    with pytest.raises(ValueError, match=f"'astar'; expected one of {', '.join(SEARCHES)}"):
        search("astar", random_graph(0), "length")


@pytest.mark.slow
@pytest.mark.parametrize("block", of_each_kind(range(10), *range(4)))
def test_the_three_tie_and_equal_networkx_and_scipy(block: int) -> None:
    solved = 0
    for seed in range(30 * block, 30 * (block + 1)):
        graph = random_graph(seed)
        length = costs_from(graph, "length", graph.start)[graph.goal]
        if not np.isfinite(length):
            for find in SEARCHES.values():
                with pytest.raises(StageError):
                    find(graph, "length")
            continue
        solved += 1
        oracle = graph.to_networkx()
        ends = (graph.start, graph.goal)
        hops = networkx.shortest_path_length(oracle, *ends)
        assert abs(networkx.dijkstra_path_length(oracle, *ends, weight="length") - length) < 1e-9
        for find in SEARCHES.values():
            assert abs(find(graph, "length").length - length) < 1e-9
            by_hops = find(graph, "hops")
            assert by_hops.hops == by_hops.cost == hops
            assert by_hops.length >= length - 1e-9
    assert solved > 20


@pytest.mark.slow
@pytest.mark.parametrize("weight", WEIGHTS)
@pytest.mark.parametrize("lattice", LATTICES)
def test_between_near_points_of_a_fine_mesh_all_cost_the_same(
    lattice: Lattice, weight: Weight
) -> None:
    """Links count as one hop however far they go, so estimates jump."""
    rng = np.random.default_rng(5)
    workspace, settings = Workspace(max=(6, 6, 6)), MeshSettings(lattice=lattice, pitch=0.75)
    free = exclude(tetrahedralise(workspace, settings), NO_OBSTACLES, 0.05)
    for start in rng.uniform(0.1, 5.9, (60, 3)):
        goal = np.clip(start + rng.uniform(-4, 4, 3), 0, 6)
        graph = build_graph(
            free, NO_OBSTACLES, 0.05, tuple(start.tolist()), tuple(goal.tolist()), 0.02
        )
        least = costs_from(graph, weight, graph.start)[graph.goal]
        for find in SEARCHES.values():
            assert find(graph, weight).cost == pytest.approx(least, abs=1e-9)


@pytest.mark.parametrize("weight", WEIGHTS)
@pytest.mark.parametrize("algorithm", SEARCHES)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_result_is_a_walk_from_start_to_goal(
    seed: int, algorithm: str, weight: Weight, way: str
) -> None:
    graph = random_graph(seed)
    result = SEARCHES[algorithm](graph, weight)
    edges = set(map(tuple, graph.edges.tolist()))
    steps = list(zip(result.vertices[:-1].tolist(), result.vertices[1:].tolist(), strict=True))
    assert (result.algorithm, result.weight) == (algorithm, weight)
    assert (result.vertices[0], result.vertices[-1]) == (graph.start, graph.goal)
    assert len(set(result.vertices.tolist())) == len(result.vertices) == result.hops + 1
    assert {(min(step), max(step)) for step in steps} <= edges
    assert np.array_equal(result.points, graph.points[result.vertices])
    lengths = matrix(graph, "length").toarray()
    assert abs(result.length - sum(lengths[step] for step in steps)) < 1e-12
    assert result.cost == pytest.approx(result.length if weight == "length" else result.hops)
    assert not any(a.flags.writeable for a in (result.vertices, result.points, result.order))


@pytest.mark.parametrize("weight", WEIGHTS)
@pytest.mark.parametrize("seed", range(20))
def test_work_is_counted(seed: int, weight: Weight) -> None:
    graph = random_graph(seed)
    if not np.isfinite(costs_from(graph, weight, graph.start)[graph.goal]):
        pytest.fail("choose seeds that have a path")
    found = {name: find(graph, weight) for name, find in SEARCHES.items()}
    for name, result in found.items():
        assert result.expanded == len(result.order)
        assert result.order[0] == graph.start
        examined = result.order if name == "bellman_ford" else result.order[:-1]
        assert result.relaxed == degrees(graph)[examined].sum()
    for name in ("a_star", "dijkstra"):
        order = found[name].order
        assert order[-1] == graph.goal
        assert len(np.unique(order)) == len(order) or name == "a_star"
    reached = np.flatnonzero(np.isfinite(costs_from(graph, weight, graph.start)))
    assert np.array_equal(np.unique(found["bellman_ford"].order), reached)


@pytest.mark.parametrize("weight", WEIGHTS)
@pytest.mark.parametrize("seed", range(30))
def test_best_first_expands_in_the_order_of_estimates(seed: int, weight: Weight) -> None:
    graph = random_graph(seed)
    cost = costs_from(graph, weight, graph.start)
    if not np.isfinite(cost[graph.goal]):
        pytest.fail("choose seeds that have a path")
    to_goal = promises(graph, weight)
    bucket = best_first_kernels.WIDTH * (graph.longest_edge if weight == "length" else 1) + 1e-9
    for name, left in (("a_star", to_goal), ("dijkstra", np.zeros_like(cost))):
        found = SEARCHES[name](graph, weight)
        estimates = (cost + left)[found.order[1:]]
        assert np.diff(estimates).min(initial=0) >= -bucket
        assert estimates.max() <= found.cost + bucket
        # what must be expanded is: nothing that promises less than the path's cost is left out
        promising = np.flatnonzero(cost + left < found.cost - 1e-9)
        assert set(promising.tolist()) <= {graph.start, *found.order.tolist()}


@pytest.mark.parametrize("weight", WEIGHTS)
@pytest.mark.parametrize("seed", range(60))
def test_the_heuristic_never_falls_by_more_than_an_edge_costs(seed: int, weight: Weight) -> None:
    graph = random_graph(seed)
    left = promises(graph, weight)
    tail = np.repeat(np.arange(len(graph.points)), degrees(graph))
    weights = graph.lengths if weight == "length" else np.ones(len(graph.lengths))
    # the start comes first and is not come back to: its own promise does not count
    onward = (tail != graph.start) & (graph.indices != graph.start)
    fall = (left[tail] - left[graph.indices] - weights)[onward]
    assert fall.max(initial=0.0) <= 1e-9


@pytest.mark.parametrize("seed", range(20))
def test_with_all_diagonals_the_cost_is_the_greatest_of_six_linear_forms(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y, z = rng.uniform(0.1, 2, 3)
    shape = MeshSizes(KUHN, 9, 9, 9, 1000, 1000, 14, 0, 14)
    costs = {axes: np.linalg.norm([(x, y, z)[k] for k in axes]) for axes in subsets(range(3))}
    for way in rng.integers(0, 5, (30, 3)).tolist():
        forms = []
        for order in permutations(range(3)):
            before = [frozenset(order[:k]) for k in range(4)]
            rises = [costs[b] - costs[a] for a, b in pairwise(before)]
            forms.append(sum(way[axis] * rise for axis, rise in zip(order, rises, strict=True)))
        metric = heuristic.by_length((x, y, z))
        left = to_go(shape, metric, tuple(2.0 * n for n in way))
        assert left == pytest.approx(max(forms), abs=1e-12)


def subsets(items: Iterable[int]) -> list[frozenset[int]]:
    found = [frozenset[int]()]
    for item in items:
        found += [one | {item} for one in found]
    return found


@pytest.mark.parametrize("weight", WEIGHTS)
def test_towards_a_goal_on_a_face_one_way_is_the_shortest_of_four(weight: Weight) -> None:
    workspace = Workspace(max=(4.0, 3.3, 4.7))
    settings = MeshSettings(lattice="bcc", pitch=0.8)
    for goal in ((4.0, 3.3, 4.7), (0.0, 1.1, 1.3), (2.1, 1.2, 4.7)):
        graph = graph_of(workspace, settings, (), (1.0, 1.0, 1.0), goal)
        metric = heuristic.metric(graph, weight)
        assert metric.kind == ON_A_FACE
        shape = graph.mesh.adjacency.shape
        for node in range(len(graph.mesh.points)):
            place = cell(shape, node)
            left = to_go(shape, metric._replace(kind=INSIDE), place)
            assert to_go(shape, metric, place) == pytest.approx(left, abs=1e-12)


@pytest.mark.parametrize("seed", range(10))
def test_a_node_is_found_at_its_place_however_many_there_are(seed: int) -> None:
    rng = np.random.default_rng(seed)
    cells = [int(10 ** rng.uniform(0, 3.1)) for _ in range(3)]
    nx, ny, nz = cells
    corners = (nx + 1) * (ny + 1) * (nz + 1)
    shape = MeshSizes(BCC, nx, ny, nz, corners, corners + nx * ny * nz, 14, 8, 14)
    for node in rng.integers(0, shape.nodes, 3000).tolist():
        a, b, c = cell(shape, node)
        assert 0 <= a <= 2 * nx
        assert 0 <= b <= 2 * ny
        assert 0 <= c <= 2 * nz
        assert node_at(shape, a, b, c) == node


@pytest.mark.parametrize("cells", [(7, 6, 8), (3, 9, 5), (1, 4, 6), (2, 1, 9)])
@pytest.mark.parametrize("lattice", REGULAR)
def test_with_nothing_in_the_way_the_heuristic_is_almost_the_cost(
    lattice: Lattice, cells: tuple[int, int, int]
) -> None:
    nx, ny, nz = cells
    side = LATTICES[lattice].cube
    workspace = Workspace(max=(side * nx, side * 0.9 * ny, side * 1.1 * nz))
    settings = MeshSettings(lattice=lattice, pitch=1.0)
    for goal in ((0.0, 0.0, 0.0), workspace.max, (side * (nx // 2), 0.0, 0.0)):
        start = tuple(np.subtract(workspace.max, goal) if any(goal) else np.array(workspace.max))
        if np.linalg.norm(np.subtract(start, goal)) < 1e-6:
            continue
        graph = graph_of(workspace, settings, (), start, goal)
        cost = costs_from(graph, "length", graph.goal)
        # what remains is what whole steps cost more than parts of them
        over = cost - promises(graph, "length")
        assert -1e-9 <= over.min() <= over.max() <= 1.2 * graph.longest_edge


@pytest.mark.slow
@pytest.mark.parametrize("weight", WEIGHTS)
@pytest.mark.parametrize("algorithm", SEARCHES)
def test_compiled_and_plain_give_the_same(algorithm: str, weight: Weight) -> None:
    for seed in range(10):
        graph = random_graph(seed)
        one = compiled(lambda graph=graph: SEARCHES[algorithm](graph, weight))  # type: ignore[misc]
        other = plain(lambda graph=graph: SEARCHES[algorithm](graph, weight))  # type: ignore[misc]
        assert np.array_equal(one.order, other.order)
        assert np.array_equal(one.vertices, other.vertices)
        assert (one.cost, one.relaxed) == (other.cost, other.relaxed)


@pytest.mark.parametrize("algorithm", SEARCHES)
@pytest.mark.parametrize("weight", WEIGHTS)
def test_no_path_names_all_that_the_start_reaches(algorithm: str, weight: Weight, way: str) -> None:
    graph = walled()
    with pytest.raises(StageError) as caught:
        SEARCHES[algorithm](graph, weight)
    _, label = connected_components(matrix(graph, "length"), directed=False)
    component = np.flatnonzero(label == label[graph.start])
    assert np.array_equal(caught.value.reached, component)
    assert caught.value.kind == NO_PATH
    assert graph.free_nodes < len(graph.points)
    assert f"{len(component)} of the graph's {graph.free_nodes} nodes" in caught.value.message


@pytest.mark.parametrize("algorithm", SEARCHES)
def test_a_start_without_edges_reaches_itself(algorithm: str) -> None:
    cage = (
        Box(position=(2, 2, 2.1), size=(9, 9, 0.01)),
        Box(position=(2, 2, 1.9), size=(9, 9, 0.01)),
    )
    graph = graph_of(
        Workspace(max=(4, 4, 4)),
        MeshSettings(lattice="kuhn", pitch=1.5),
        cage,
        (2, 2, 2),
        (0, 0, 0),
    )
    with pytest.raises(StageError) as caught:
        SEARCHES[algorithm](graph, "length")
    assert caught.value.reached.tolist() == [graph.start]


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("plain", [True, False])
def test_bellman_ford_finds_all_costs_however_often_nodes_return(seed: int, plain: bool) -> None:
    # unlike lengths, squares make many short steps cheaper than one long one: nodes return often
    rng = np.random.default_rng(seed)
    n = 40
    place = rng.permutation(n)
    weights = np.subtract.outer(place, place) ** 2.0
    weights *= rng.uniform(0.5, 1.5, (n, n))
    rows = csr_array(np.minimum(weights, weights.T))
    indptr, indices = (read_only(a.astype(np.int32)) for a in (rows.indptr, rows.indices))
    table = of_rows(np.zeros((n, 3)), indptr, indices)
    open_directions = read_only(np.zeros(n, dtype=np.int32))
    weights, links = read_only(rows.data), (NO_IDS, NO_IDS, NO_NUMBERS)
    problem = Problem(table, open_directions, weights, *links, 0, 1, 0, 1.0, NO_METRIC)
    with kernels_as(compiled=not plain):
        cost, parent, order, relaxed = label_kernels.bellman_ford(problem)
    assert np.allclose(cost, scipy_dijkstra(rows, indices=0), rtol=1e-12)
    assert len(order) > 4 * n
    assert relaxed == np.diff(indptr)[order].sum()
    child = np.flatnonzero(parent >= 0)
    assert np.array_equal(child, np.arange(1, n))
    assert np.allclose(cost[child], cost[parent[child]] + rows.toarray()[parent[child], child])


def test_every_search_of_the_settings_is_in_the_table() -> None:
    missing = "a search is missing in SEARCHES, or in Algorithm of settings.py"
    assert set(SEARCHES) == set(get_args(Algorithm)), missing
    graph = random_graph(1)
    assert [find(graph, "length").algorithm for find in SEARCHES.values()] == list(SEARCHES)
