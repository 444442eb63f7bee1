from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, reject, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from abi.arrays import IntArray
from abi.errors import StageError
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.primitives import Box, Capsule, Cylinder, Sphere
from abi.obstacles.triangle_mesh.repair import clean
from abi.scene.lattices import LATTICES, Lattice
from abi.scene.settings import MeshSettings, Workspace
from abi.search.build_graph import _graph, build_graph
from abi.search.graph import Graph
from abi.search.heuristic import Weight
from abi.search.search import SEARCHES
from abi.tet_mesh import tet_mesh as mesh
from abi.tet_mesh.exclusion import exclude
from abi.tet_mesh.lattice import REGULAR
from abi.tet_mesh.tet_mesh import TetMesh
from tests.abi.meshes import sphere
from tests.abi.scene.test_scene import obstacles
from tests.kernel_forms import kernels_as
from tests.thorough import of_each_kind

TIE = 1e-9
KINDS: dict[str, Any] = {
    "box": Box,
    "sphere": Sphere,
    "cylinder": Cylinder,
    "capsule": Capsule,
}

UNIT = st.floats(0, 1) | st.sampled_from([0.0, 0.25, 0.5, 1.0])
PLACE = st.tuples(UNIT, UNIT, UNIT)
SIDE = st.floats(1.0, 6.0) | st.sampled_from([2.0, 3.0, 6.0])


@st.composite
def plates(draw: st.DrawFn) -> Box:
    """Thin, aligned with the axes, often in a plane of nodes."""
    axis = draw(st.integers(0, 2))
    size = [draw(st.floats(0.5, 8)) for _ in range(3)]
    size[axis] = draw(st.sampled_from([1e-6, 1e-3, 0.05]))
    x, y, z = (draw(st.floats(0, 6) | st.integers(0, 6).map(float)) for _ in range(3))
    return Box(position=(x, y, z), size=(size[0], size[1], size[2]))


@st.composite
def cases(draw: st.DrawFn) -> tuple[TetMesh, ObstacleSet, float, float, Any, Any]:
    """A mesh of cells that are no cubes, obstacles, margin, clearance, start and goal."""
    low = draw(st.sampled_from([0.0, -3.0, 1e3]))
    workspace = Workspace(min=(low, 0.0, 0.0), max=(low + draw(SIDE), draw(SIDE), draw(SIDE)))
    lattice, pitch = draw(st.sampled_from(list(LATTICES))), draw(st.floats(0.6, 3))
    settings_ = MeshSettings(lattice=lattice, pitch=pitch)
    assume(settings_.node_count(workspace) < 500)
    made = mesh.tetrahedralise(workspace, settings_)
    bodies = []
    for body in draw(st.lists(obstacles, max_size=4)):
        if body["shape"] != "mesh":
            bodies.append(KINDS[body["shape"]](**body))
    bodies += draw(st.lists(plates(), max_size=2))
    bodies = [
        body.model_copy(update={"position": (body.position[0] + low, *body.position[1:])})
        for body in bodies
    ]
    clearance = draw(st.sampled_from([0.0, 0.1]))
    margin = clearance + draw(st.sampled_from([0.0, 0.03]))
    ends = []
    for _ in range(2):
        if draw(st.booleans()):
            ends.append(tuple(made.points[draw(st.integers(0, len(made.points) - 1))].tolist()))
        else:
            ends.append(tuple((np.array(draw(PLACE)) * workspace.size + workspace.min).tolist()))
    return made, ObstacleSet(tuple(bodies)), margin, clearance, ends[0], ends[1]


def explicit(made: TetMesh, solids: ObstacleSet, margin: float) -> tuple[IntArray, IntArray]:
    """Edges (n, 2) by the definition, and those (m, 2) that rounding decides."""
    away = solids.nearest(made.points)[0]
    tail, head = made.edges.T
    p, q = made.points[tail], made.points[head]
    nearer_end = np.minimum(away[tail], away[head])
    kept, loose, tight = (
        (nearer_end >= limit) & ~solids.blocked(p, q, limit)
        for limit in (margin, margin - TIE, margin + TIE)
    )
    return made.edges[kept], made.edges[loose & ~tight]


def pairs(edges: IntArray) -> set[tuple[int, int]]:
    return set(map(tuple, edges.tolist()))


def differing(made: TetMesh, one: IntArray, other: IntArray) -> IntArray:
    """Edges in one table but not in both, a number each."""
    return np.setxor1d(numbered(made, one), numbered(made, other))


def numbered(made: TetMesh, edges: IntArray) -> IntArray:
    return np.asarray(edges[:, 0].astype(np.int64) * len(made.points) + edges[:, 1])


@pytest.mark.slow
@settings(max_examples=28, suppress_health_check=list(HealthCheck))
@given(cases(), st.booleans())
def test_the_graph_is_what_its_definition_says(case: Any, compiled: bool) -> None:
    made, solids, margin, clearance, start, goal = case
    with kernels_as(compiled):
        free = exclude(made, solids, margin)
        try:
            found = build_graph(free, solids, margin, start, goal, clearance)
        except StageError:
            reject()
    ends = np.array([start, goal])
    room = np.minimum(solids.nearest(ends)[0] - TIE, margin)
    expected, ties = map(pairs, explicit(made, solids, margin))
    of_mesh = {(a, b) for a, b in pairs(found.edges) if b < len(made.points)}
    links = set(zip(found.tails.tolist(), found.heads.tolist(), strict=True))
    assert (of_mesh - links) ^ expected <= ties
    for a, b, length in zip(found.tails, found.heads, found.link_lengths, strict=True):
        assert length == pytest.approx(np.linalg.norm(found.points[a] - found.points[b]), abs=1e-9)
        assert {int(a), int(b)} & {found.start, found.goal}
    reach = 1.6 * made.longest_edge
    for node, end, own in zip((found.start, found.goal), ends, room, strict=True):
        if node < len(made.points):
            assert np.abs(made.points[node] - end).max() <= 1e-9 * made.pitch
            continue
        far = np.linalg.norm(made.points - end, axis=1)
        for radius in (reach, 2 * reach, 4 * reach):
            near = np.flatnonzero((far <= radius) & ~free.excluded)
            p = np.broadcast_to(end, (len(near), 3))
            seen = near[~solids.blocked(p, made.points[near], own)]
            surely = near[~solids.blocked(p, made.points[near], own + TIE)]
            if len(seen):
                break
        linked = found.tails[found.heads == node]
        assert set(surely.tolist()) <= set(linked.tolist()) | set(found.heads.tolist())
        assert set(linked[linked < len(made.points)].tolist()) <= set(
            near[far[near] <= radius].tolist()
        )


@pytest.mark.slow
@pytest.mark.parametrize("lattice", REGULAR)
@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("seed", of_each_kind(range(3), 0))
def test_what_is_passed_over_in_a_fine_lattice_is_clear(
    lattice: Lattice, turned: bool, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    workspace = Workspace(max=(3.0, 2.9, 3.3))
    made = mesh.tetrahedralise(workspace, MeshSettings(lattice=lattice, pitch=0.19))
    for _ in range(2):
        pose: Any = {"position": tuple(rng.uniform(0, 3, 3))}
        if turned:
            pose["wxyz"] = (1.0, *(rng.normal(size=3) * rng.choice([1.0, 1e-7])).tolist())
        size = rng.uniform(0.5, 3.0, 3)
        if seed == 0:  # an edge may lead through
            size[rng.integers(3)] = rng.uniform(0.001, 0.2)
        radius, height = rng.uniform(0.2, 1.2, 2)
        shapes = (
            Box(size=tuple(size), **pose),
            Cylinder(radius=radius, height=height, **pose),
            Capsule(radius=radius, height=height, **pose),
        )
        for solid in shapes:
            with kernels_as(compiled=True):
                free = exclude(made, ObstacleSet((solid,)), 0.05)
            away = solid.signed_distance(made.points)
            assert np.array_equal(free.excluded, away < 0.05) or np.abs(away - 0.05).min() < TIE
            found = _graph(free, free.open_directions, [], [], [0, 1])
            expected, ties = explicit(made, ObstacleSet((solid,)), 0.05)
            assert np.isin(differing(made, found.edges, expected), numbered(made, ties)).all()


@pytest.mark.slow
@settings(max_examples=14)
@given(cases(), st.sampled_from(["length", "hops"]), st.booleans())
def test_the_searches_find_what_scipy_finds_in_the_table(
    case: Any, weight: Weight, compiled: bool
) -> None:
    made, solids, margin, clearance, start, goal = case
    with kernels_as(compiled):
        free = exclude(made, solids, margin)
        try:
            found = build_graph(free, solids, margin, start, goal, clearance)
        except StageError:
            reject()
        expected = shortest(found, weight)
        edges = pairs(found.edges)
        for search_ in SEARCHES.values():
            if not np.isfinite(expected):
                with pytest.raises(StageError, match="No path"):
                    search_(found, weight)
                continue
            result = search_(found, weight)
            assert result.cost == pytest.approx(expected, rel=1e-9)
            assert edges_of_path(result.vertices) <= edges


def edges_of_path(vertices: IntArray) -> set[tuple[int, int]]:
    steps = zip(vertices[:-1].tolist(), vertices[1:].tolist(), strict=True)
    return {(min(step), max(step)) for step in steps}


def shortest(found: Graph, weight: Weight) -> float:
    tail, head = found.edges.T
    lengths = np.linalg.norm(found.points[head] - found.points[tail], axis=1)
    weights = lengths if weight == "length" else np.ones(len(tail))
    n = len(found.points)
    table = coo_array((weights, (tail, head)), shape=(n, n)).tocsr()
    return float(dijkstra(table, directed=False, indices=found.start)[found.goal])


@pytest.mark.parametrize("lattice", LATTICES)
def test_a_ball_of_triangles_takes_what_lies_between_the_balls_around_it(lattice: Lattice) -> None:
    made = mesh.tetrahedralise(Workspace(max=(3, 3, 3)), MeshSettings(lattice=lattice, pitch=0.4))
    shape = MeshShape.of(clean(*sphere(3, 0.9)), position=(1.5, 1.5, 1.5))
    kept = []
    for solid in (Sphere(radius=0.9, position=(1.5, 1.5, 1.5)), shape):
        free = exclude(made, ObstacleSet((solid,)), 0.1)
        found = build_graph(free, ObstacleSet((solid,)), 0.1, (0.0, 0.0, 0.0), (3.0, 3.0, 3.0), 0.1)
        kept.append(pairs(found.edges))
        assert found.removed_edges > found.mesh.edge_count // 20
        assert found.edge_count == len(found.edges)
    # the ball of triangles lies inside the round one, and takes almost as much
    assert kept[0] <= kept[1]
    assert len(kept[1] - kept[0]) < 0.1 * len(kept[1])


def test_an_edge_is_shut_at_both_its_ends() -> None:
    rng = np.random.default_rng(5)
    for lattice in REGULAR:
        settings_ = MeshSettings(lattice=lattice, pitch=0.5)
        made = mesh.tetrahedralise(Workspace(max=(3, 2.6, 3.2)), settings_)
        assert made.stencil is not None
        for _ in range(20):
            solid = Box(
                size=tuple(rng.uniform(0.1, 1.5, 3)),
                position=tuple(rng.uniform(0, 3, 3)),
                wxyz=tuple(rng.normal(size=4)),
            )
            free = exclude(made, ObstacleSet((solid,)), 0.05)
            open_directions = np.where(free.excluded, 0, free.open_directions)
            heads = made.stencil.heads(np.arange(len(open_directions), dtype=np.int32))
            for k in range(heads.shape[1]):
                back = k if k < made.stencil.cross else k ^ 1
                here = np.flatnonzero(open_directions >> k & 1)
                assert (open_directions[heads[here, k]] >> back & 1 == 1).all()
