from __future__ import annotations

import re
import sys
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from abi.arrays import FloatArray
from abi.errors import AbiError, StageError
from abi.obstacles.obstacle_set import NO_OBSTACLES, Obstacles, ObstacleSet
from abi.obstacles.pose import Vec3
from abi.obstacles.primitives import Box, Sphere
from abi.scene.lattices import LATTICES, Lattice
from abi.scene.settings import MeshSettings, Workspace
from abi.search.build_graph import build_graph
from abi.search.graph import Graph
from abi.tet_mesh.exclusion import FreeMesh, exclude
from abi.tet_mesh.tet_mesh import tetrahedralise
from tests.abi.graphs import lattice_of
from tests.random_geometry import random_obstacles
from tests.thorough import examples

SIDE = 3.0
SAMPLES = 40


def free_mesh(
    obstacles: Obstacles = (), margin: float = 0.0, lattice: Lattice = "kuhn", pitch: float = 0.6
) -> FreeMesh:
    workspace = Workspace(max=(SIDE, SIDE, SIDE))
    return exclude(
        tetrahedralise(workspace, MeshSettings(lattice=lattice, pitch=pitch)),
        ObstacleSet(obstacles),
        margin,
    )


def free_point(rng: np.random.Generator, obstacles: Obstacles, clearance: float) -> Vec3:
    points = rng.uniform(0, SIDE, (500, 3))
    clear = points[ObstacleSet(obstacles).nearest(points)[0] >= clearance]
    x, y, z = clear[0].tolist()
    return (x, y, z)


def sampled_distance(graph: Graph, obstacles: Obstacles) -> FloatArray:
    """Least signed distance at points dense on each edge, (e,)."""
    p, q = (graph.points[graph.edges[:, end]] for end in (0, 1))
    along = np.linspace(0, 1, SAMPLES)[None, :, None]
    samples = p[:, None] + along * (q - p)[:, None]
    distance = ObstacleSet(obstacles).nearest(samples.reshape(-1, 3))[0]
    return np.asarray(distance.reshape(-1, SAMPLES).min(axis=1))


@pytest.mark.parametrize("seed", range(30))
def test_no_edge_comes_nearer_than_the_margin(seed: int) -> None:
    rng = np.random.default_rng(seed)
    obstacles = random_obstacles(rng, int(rng.integers(1, 8)), SIDE, 1.5)
    clearance = float(rng.choice([0.0, 0.05, 0.2]))
    margin = clearance + float(rng.choice([0.0, 0.05]))
    free = free_mesh(obstacles, margin, lattice_of(seed))
    start, goal = (free_point(rng, obstacles, clearance) for _ in range(2))
    graph = build_graph(free, ObstacleSet(obstacles), margin, start, goal, clearance)

    distance = sampled_distance(graph, obstacles)
    of_mesh = (graph.edges < len(free.mesh.points)).all(axis=1)
    assert of_mesh.any()
    assert distance[of_mesh].min() >= margin - 1e-9
    for node in (graph.start, graph.goal):
        own = ObstacleSet(obstacles).nearest(graph.points[[node]])[0][0]
        links = (graph.edges == node).any(axis=1)
        assert distance[links].min(initial=np.inf) >= min(margin, own) - 2e-9
    assert distance.min() >= clearance - 2e-9


@pytest.mark.parametrize("seed", range(30))
def test_only_edges_that_come_too_near_are_removed(seed: int) -> None:
    rng = np.random.default_rng(seed)
    obstacles = random_obstacles(rng, 5, SIDE, 1.5)
    margin = 0.1
    free = free_mesh(obstacles, margin, lattice_of(seed))
    start, goal = (free_point(rng, obstacles, margin) for _ in range(2))
    graph = build_graph(free, ObstacleSet(obstacles), margin, start, goal, margin)

    mesh = free.mesh
    kept = {tuple(edge) for edge in graph.edges.tolist()}
    gone = np.array([edge for edge in mesh.edges.tolist() if tuple(edge) not in kept])
    assert graph.removed_edges == len(gone)
    crossing = gone[~free.excluded[gone].any(axis=1)]
    assert np.array_equal(crossing, graph.crossing)
    p, q = (mesh.points[crossing[:, end]] for end in (0, 1))
    along = np.linspace(0, 1, SAMPLES)[None, :, None]
    samples = (p[:, None] + along * (q - p)[:, None]).reshape(-1, 3)
    distance = ObstacleSet(obstacles).nearest(samples)[0].reshape(-1, SAMPLES).min(axis=1)
    # between samples the distance can be lower by half their spacing
    spacing = np.linalg.norm(q - p, axis=1) / (SAMPLES - 1)
    assert (distance < margin + spacing / 2).all()


def test_crossings_occur_at_all() -> None:
    obstacles = random_obstacles(np.random.default_rng(0), 5, SIDE, 1.5)
    free = free_mesh(obstacles, 0.0)
    clear = free_point(np.random.default_rng(1), obstacles, 0.0)
    corner = free_point(np.random.default_rng(2), obstacles, 0.0)
    assert len(build_graph(free, ObstacleSet(obstacles), 0.0, clear, corner, 0.0).crossing) > 0


@pytest.mark.parametrize("lattice", LATTICES)
def test_a_plate_between_free_nodes_parts_the_graph(lattice: Lattice) -> None:
    plate = (Box(position=(1.5, 1.5, 1.4567), size=(9.0, 9.0, 1e-4)),)
    free = free_mesh(plate, 1e-5, lattice)
    assert not free.excluded.any()
    graph = build_graph(free, ObstacleSet(plate), 1e-5, (0.1, 0.2, 0.3), (2.9, 2.8, 2.7), 1e-5)
    n = len(graph.points)
    matrix = csr_array((graph.lengths, graph.indices, graph.indptr), shape=(n, n))
    count, label = connected_components(matrix, directed=False)
    assert count == 2
    assert np.array_equal(label == label[graph.start], graph.points[:, 2] < 1.4567)
    assert graph.removed_edges == len(graph.crossing) > 0


UNIT = st.floats(0, 1) | st.sampled_from([0.0, 0.2, 0.5, 1.0])
POINT = st.tuples(UNIT, UNIT, UNIT)


@settings(max_examples=examples(20))
@given(POINT, POINT, st.sampled_from(list(LATTICES)))
def test_start_and_goal_can_be_anywhere_in_the_box(a: Vec3, b: Vec3, lattice: Lattice) -> None:
    start, goal = np.array(a) * SIDE, np.array(b) * SIDE
    free = free_mesh(lattice=lattice, pitch=1.0)
    arguments: Any = (free, NO_OBSTACLES, 0.0, tuple(start), tuple(goal), 0.0)
    if np.linalg.norm(start - goal) <= 1e-9:
        with pytest.raises(StageError, match="same point"):
            build_graph(*arguments)
        return
    graph = build_graph(*arguments)
    assert np.abs(graph.points[[graph.start, graph.goal]] - [start, goal]).max() <= 1e-8
    assert graph.free_nodes == len(graph.points)
    n = len(graph.points)
    matrix = csr_array((graph.lengths, graph.indices, graph.indptr), shape=(n, n))
    assert connected_components(matrix, directed=False)[0] == 1


@pytest.mark.parametrize("seed", range(10))
def test_rows_hold_each_edge_twice_with_its_length(seed: int) -> None:
    rng = np.random.default_rng(seed)
    obstacles = random_obstacles(rng, 3, SIDE, 1.5)
    free = free_mesh(obstacles, 0.05, lattice_of(seed))
    start, goal = (free_point(rng, obstacles, 0.05) for _ in range(2))
    graph = build_graph(free, ObstacleSet(obstacles), 0.05, start, goal, 0.05)

    tail = np.repeat(np.arange(len(graph.points)), np.diff(graph.indptr))
    pairs = np.stack([tail, graph.indices], axis=1)
    expected = np.concatenate([graph.edges, graph.edges[:, ::-1]])
    assert (graph.edges[:, 0] < graph.edges[:, 1]).all()
    assert len(np.unique(graph.edges, axis=0)) == graph.edge_count == len(graph.edges)
    assert np.array_equal(pairs[np.lexsort(pairs.T)], expected[np.lexsort(expected.T)])
    lengths = np.linalg.norm(graph.points[pairs[:, 1]] - graph.points[pairs[:, 0]], axis=1)
    assert np.allclose(graph.lengths, lengths, rtol=1e-12, atol=0)
    some = rng.random(len(graph.points)) < 0.7
    among = graph.edges[some[graph.edges].all(axis=1)]
    np.testing.assert_array_equal(graph.edges_among(some), among)
    assert graph.longest_edge == graph.lengths.max()
    assert graph.indptr.dtype == graph.indices.dtype == np.int32
    arrays = (graph.points, graph.edges, graph.indptr, graph.indices, graph.lengths)
    assert not any(array.flags.writeable for array in arrays)


@pytest.mark.parametrize("seed", range(10))
def test_a_point_is_joined_to_all_near_nodes_it_sees(seed: int) -> None:
    rng = np.random.default_rng(seed)
    obstacles = random_obstacles(rng, 6, SIDE, 1.5)
    free = free_mesh(obstacles, 0.05, lattice_of(seed))
    start, goal = (free_point(rng, obstacles, 0.05) for _ in range(2))
    graph = build_graph(free, ObstacleSet(obstacles), 0.05, start, goal, 0.05)
    for node, point in ((graph.start, start), (graph.goal, goal)):
        assert node >= len(free.mesh.points)
        away = np.linalg.norm(free.mesh.points - point, axis=1)
        near = np.flatnonzero((away <= 1.6 * free.mesh.lengths.max()) & ~free.excluded)
        q = free.mesh.points[near]
        p = np.broadcast_to(point, q.shape)
        seen = near[~ObstacleSet(obstacles).blocked(p, q, 0.05 - 1e-9)]
        linked = graph.indices[graph.indptr[node] : graph.indptr[node + 1]]
        assert np.array_equal(np.sort(linked[linked < len(free.mesh.points)]), seen)


def test_a_point_on_a_free_node_is_that_node() -> None:
    free = free_mesh()
    x, y, z = free.mesh.points[40].tolist()
    graph = build_graph(free, NO_OBSTACLES, 0.0, (x + 1e-10, y, z), (SIDE, SIDE, SIDE), 0.0)
    assert graph.start == 40
    assert graph.goal == len(free.mesh.points) - 1
    assert len(graph.points) == len(free.mesh.points)
    assert graph.edge_count == len(free.mesh.edges)


def test_a_point_between_clearance_and_margin_is_a_node_of_its_own() -> None:
    ball = (Sphere(position=(0.0, 0.0, 0.0), radius=1.0),)
    free = free_mesh(ball, 0.3)
    near = int(np.flatnonzero(free.excluded & (free.mesh.points[:, 0] > 1.1))[0])
    x, y, z = free.mesh.points[near].tolist()
    graph = build_graph(free, ObstacleSet(ball), 0.3, (x, y, z), (SIDE, SIDE, SIDE), 0.1)
    assert graph.start == len(free.mesh.points)
    assert graph.free_nodes == free.nodes + 1
    assert graph.indptr[graph.start + 1] > graph.indptr[graph.start]
    own = ball[0].signed_distance(np.array([[x, y, z]]))[0]
    assert 0.1 < own < 0.3


def test_near_start_and_goal_are_joined_directly_unless_a_plate_hides_them() -> None:
    start, goal = (1.51, 1.52, 1.4), (1.53, 1.54, 1.6)
    plate = (Box(position=(1.5, 1.5, 1.5), size=(3.0, 3.0, 0.01)),)
    for obstacles, expected in (((), True), (plate, False)):
        free = free_mesh(obstacles)
        graph = build_graph(free, ObstacleSet(obstacles), 0.0, start, goal, 0.0)
        linked = graph.indices[graph.indptr[graph.start] : graph.indptr[graph.start + 1]]
        assert (graph.goal in linked) == expected


def test_nodes_two_steps_apart_are_joined_once() -> None:
    free = free_mesh(pitch=1.0)
    graph = build_graph(free, NO_OBSTACLES, 0.0, (0, 0, 0), (0, 0, 1), 0.0)
    assert graph.edge_count == len(free.mesh.edges)
    graph = build_graph(free, NO_OBSTACLES, 0.0, (0, 0, 0), (0, 0, 2), 0.0)
    assert graph.edge_count == len(free.mesh.edges) + 1


@pytest.mark.parametrize("factor", [2, 4])
def test_a_lonely_point_looks_farther(factor: int) -> None:
    reach = 1.6 * np.sqrt(3) * 0.25
    speck = (Sphere(position=(0.0, 0.0, 0.0), radius=1e-3),)
    margin = 0.75 * factor * reach
    free = free_mesh(speck, margin, pitch=0.25)
    graph = build_graph(
        free, ObstacleSet(speck), margin, (0.01, 0.01, 0.01), (SIDE, SIDE, SIDE), 0.0
    )
    links = slice(graph.indptr[graph.start], graph.indptr[graph.start + 1])
    assert reach * factor / 2 < graph.lengths[links].min()
    assert graph.lengths[links].max() <= reach * factor


def test_start_is_goal() -> None:
    with pytest.raises(StageError) as caught:
        build_graph(free_mesh(), NO_OBSTACLES, 0.0, (1, 2, 1), (1, 2, 1 + 1e-10), 0.0)
    assert (caught.value.stage, caught.value.kind) == ("graph", "start_is_goal")


@pytest.mark.parametrize("which", ["start", "goal"])
@pytest.mark.parametrize("clearance", [0.0, 0.2])
def test_a_blocked_point_is_named_with_the_nearest_free_node(which: str, clearance: float) -> None:
    obstacles = (
        Sphere(position=(0.2, 0.2, 0.2), radius=0.1),
        Box(position=(2.0, 2.0, 2.0), size=(1.0, 1.0, 1.0)),
    )
    free = free_mesh(obstacles, clearance)
    x = 2.5 + clearance - 1e-6
    blocked, clear = (x, 2.0, 2.0), (x + 2e-6, 1.0, 1.0)
    ends = (blocked, clear) if which == "start" else (clear, blocked)
    with pytest.raises(StageError) as caught:
        build_graph(free, ObstacleSet(obstacles), clearance, *ends, clearance)
    error = caught.value
    assert (error.kind, error.obstacle) == (f"{which}_blocked", 1)
    assert "obstacle 2" in error.message
    away = np.linalg.norm(free.mesh.points - blocked, axis=1)
    [named] = re.findall(r"nearest free point is \(([^)]*)\)", error.hint)
    nearest = np.array(named.replace("−", "-").split(","), dtype=float)  # of two digits
    assert abs(np.linalg.norm(nearest - blocked) - away[~free.excluded].min()) < 0.01


def test_a_point_at_exactly_the_clearance_is_not_blocked() -> None:
    obstacles = (Box(position=(2.0, 2.0, 2.0), size=(1.0, 1.0, 1.0)),)
    graph = build_graph(
        free_mesh(obstacles, 0.2), ObstacleSet(obstacles), 0.2, (2.7, 2.0, 2.0), (0, 0, 0), 0.2
    )
    assert graph.indptr[graph.start + 1] > graph.indptr[graph.start]


def test_without_a_free_node_no_nearest_is_named() -> None:
    obstacles = (Sphere(position=(1.5, 1.5, 1.5), radius=9.0),)
    with pytest.raises(StageError) as caught:
        build_graph(free_mesh(obstacles), ObstacleSet(obstacles), 0.0, (1, 1, 1), (2, 2, 2), 0.0)
    assert "nearest" not in caught.value.hint


@pytest.mark.parametrize("seed", range(5))
def test_networkx_graph_is_the_same_graph(seed: int) -> None:
    rng = np.random.default_rng(seed)
    obstacles = random_obstacles(rng, 4, SIDE, 1.5)
    free = free_mesh(obstacles, 0.1)
    start, goal = (free_point(rng, obstacles, 0.1) for _ in range(2))
    graph = build_graph(free, ObstacleSet(obstacles), 0.1, start, goal, 0.1)
    other = graph.to_networkx()
    assert {tuple(sorted(edge)) for edge in other.edges} == set(map(tuple, graph.edges.tolist()))
    assert set(other) == {*graph.edges.ravel().tolist(), graph.start, graph.goal}
    for node, position in other.nodes(data="pos"):
        assert position == tuple(graph.points[node])
    for a, b, length in other.edges(data="length"):
        assert abs(length - np.linalg.norm(graph.points[a] - graph.points[b])) < 1e-12


def test_without_networkx_its_graph_says_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    graph = build_graph(free_mesh(), NO_OBSTACLES, 0.0, (0.0, 0.0, 0.0), (SIDE, SIDE, SIDE), 0.0)
    monkeypatch.setitem(sys.modules, "networkx", None)
    with pytest.raises(AbiError, match="not installed") as caught:
        graph.to_networkx()
    assert caught.value.hint == "pip install networkx brings it."


def test_networkx_graph_holds_a_start_without_edges() -> None:
    lid, floor = (Box(position=(1.5, 1.5, z), size=(9.0, 9.0, 0.01)) for z in (1.51, 1.59))
    free = free_mesh((lid, floor))
    graph = build_graph(free, ObstacleSet((lid, floor)), 0.0, (1.5, 1.5, 1.55), (0, 0, 0), 0.0)
    assert graph.indptr[graph.start] == graph.indptr[graph.start + 1]
    assert list(graph.to_networkx()[graph.start]) == []
