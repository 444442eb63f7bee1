from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from abi.obstacles.obstacle_set import NO_OBSTACLES, ObstacleSet
from abi.obstacles.primitives import Sphere
from abi.scene.lattices import LATTICES, Lattice
from abi.scene.settings import MeshSettings, Workspace
from abi.tet_mesh.delaunay import volumes
from abi.tet_mesh.exclusion import exclude, within
from abi.tet_mesh.lattice import REGULAR
from abi.tet_mesh.tet_mesh import TetMesh, edges_of, tetrahedralise
from tests.random_geometry import random_obstacles
from tests.thorough import examples

FACES = ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3))


@st.composite
def boxes(draw: st.DrawFn) -> Workspace:
    low = [draw(st.floats(-50, 50) | st.just(1e5)) for _ in range(3)]
    high = [a + draw(st.floats(0.3, 4)) for a in low]
    return Workspace(min=(low[0], low[1], low[2]), max=(high[0], high[1], high[2]))


@st.composite
def meshes(draw: st.DrawFn) -> tuple[Workspace, TetMesh]:
    workspace = draw(boxes())
    lattice = draw(st.sampled_from(list(LATTICES)))
    pitch = draw(st.floats(0.9, 5))
    seed = draw(st.integers(0, 2**32 - 1))
    return workspace, tetrahedralise(
        workspace, MeshSettings(lattice=lattice, pitch=pitch, seed=seed)
    )


@pytest.mark.slow
@settings(max_examples=examples(20))
@given(meshes())
def test_tetrahedra_tile_the_box(case: tuple[Workspace, TetMesh]) -> None:
    workspace, mesh = case
    volume = volumes(mesh.points, mesh.tetrahedra)
    assert volume.min() > 0
    assert math.isclose(volume.sum(), math.prod(workspace.size), rel_tol=1e-9)
    faces = np.sort(mesh.tetrahedra[:, FACES].reshape(-1, 3), axis=1)
    faces, shared = np.unique(faces, axis=0, return_counts=True)
    corners = mesh.points[faces]
    low = (corners == workspace.min).all(axis=1).any(axis=1)
    high = (corners == workspace.max).all(axis=1).any(axis=1)
    assert np.array_equal(shared, np.where(low | high, 1, 2))


@pytest.mark.slow
@settings(max_examples=examples(20))
@given(meshes())
def test_edges_belong_to_tetrahedra_and_have_their_lengths(
    case: tuple[Workspace, TetMesh],
) -> None:
    _, mesh = case
    edges = mesh.edges[np.lexsort(mesh.edges.T[::-1])]
    assert np.array_equal(edges, edges_of(mesh.tetrahedra, len(mesh.points)))
    tail, head = mesh.edges.T
    lengths = np.linalg.norm(mesh.points[head] - mesh.points[tail], axis=1)
    assert np.allclose(mesh.lengths, lengths, rtol=1e-9, atol=0)
    if mesh.lattice in REGULAR:
        assert mesh.pitch == mesh.lengths.min()


@pytest.mark.slow
@settings(max_examples=40)
@given(boxes(), st.sampled_from(list(LATTICES)), st.floats(0.3, 5), st.integers(0, 99))
def test_nodes_are_as_many_as_counted_and_reach_the_corners(
    workspace: Workspace, lattice: Lattice, pitch: float, seed: int
) -> None:
    asked = MeshSettings(lattice=lattice, pitch=pitch, seed=seed)
    mesh = tetrahedralise(workspace, asked)
    assert len(mesh.points) == asked.node_count(workspace)
    assert np.array_equal(mesh.points.min(axis=0), workspace.min)
    assert np.array_equal(mesh.points.max(axis=0), workspace.max)
    corners = np.stack(np.meshgrid(*zip(workspace.min, workspace.max, strict=True)), axis=-1)
    assert cKDTree(mesh.points).query(corners.reshape(-1, 3))[0].max() == 0


@pytest.mark.parametrize("lattice", REGULAR)
def test_pitch_is_what_was_asked_where_the_box_allows_it(lattice: Lattice) -> None:
    cube = LATTICES[lattice].cube
    workspace = Workspace(min=(-1, 0, 2), max=(-1 + 3 * cube, 2 * cube, 2 + 4 * cube))
    mesh = tetrahedralise(workspace, MeshSettings(lattice=lattice, pitch=1.0))
    assert mesh.cells == (3, 2, 4)
    assert math.isclose(mesh.pitch, 1.0)


def test_delaunay_repeats_by_its_seed() -> None:
    first, again, other = (
        tetrahedralise(Workspace(), MeshSettings(lattice="delaunay", pitch=1.5, seed=seed))
        for seed in (7, 7, 8)
    )
    assert np.array_equal(first.points, again.points)
    assert np.array_equal(first.tetrahedra, again.tetrahedra)
    assert not np.array_equal(first.points, other.points)


@pytest.mark.parametrize("seed", range(5))
def test_no_node_lies_in_the_circumsphere_of_a_delaunay_tetrahedron(seed: int) -> None:
    workspace = Workspace(max=(4, 3, 5))
    mesh = tetrahedralise(workspace, MeshSettings(lattice="delaunay", pitch=1, seed=seed))
    first, *rest = (mesh.points[mesh.tetrahedra[:, corner]] for corner in range(4))
    sides = np.stack(rest, axis=1) - first[:, None]
    centre = np.linalg.solve(2 * sides, (sides**2).sum(axis=2)[..., None])[..., 0]
    radius = np.linalg.norm(centre, axis=1)
    nearest, _ = cKDTree(mesh.points).query(first + centre)
    assert (nearest >= radius * (1 - 1e-7)).all()


def test_delaunay_tiles_a_box_far_from_the_origin() -> None:
    workspace = Workspace(min=(9e5, 9e5, 9e5), max=(9e5 + 3, 9e5 + 4, 9e5 + 3))
    for seed in range(60):
        mesh = tetrahedralise(workspace, MeshSettings(lattice="delaunay", pitch=1, seed=seed))
        volume = volumes(mesh.points, mesh.tetrahedra)
        assert math.isclose(volume.sum(), 36, rel_tol=1e-8)


def test_flat_tetrahedra_are_dropped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "abi.tet_mesh.delaunay._JITTER", 0.0
    )  # eight nodes of each cube lie on one sphere
    workspace = Workspace(max=(3, 3, 3))
    mesh = tetrahedralise(workspace, MeshSettings(lattice="delaunay", pitch=1))
    volume = volumes(mesh.points, mesh.tetrahedra)
    assert volume.min() > 0.01
    assert math.isclose(volume.sum(), 27)


def test_delaunay_keeps_each_node_in_its_cell_and_on_its_face() -> None:
    workspace = Workspace(min=(-2, 1, 0), max=(2, 7, 3))
    mesh = tetrahedralise(workspace, MeshSettings(lattice="delaunay", pitch=1, seed=3))
    grid = tetrahedralise(workspace, MeshSettings(lattice="kuhn", pitch=1))
    assert np.abs(mesh.points - grid.points).max() < 0.5
    for wall in (workspace.min, workspace.max):
        assert np.array_equal(mesh.points == wall, grid.points == wall)
    assert (mesh.points != grid.points).any(axis=0).all()


@pytest.mark.parametrize("lattice", REGULAR)
def test_a_large_mesh_makes_no_table_until_asked(lattice: Lattice) -> None:
    mesh = tetrahedralise(Workspace(), MeshSettings(lattice=lattice, pitch=0.3))
    free = exclude(mesh, ObstacleSet((Sphere(position=(3, 3, 3), radius=1.0),)), 0.1)
    assert free.tetrahedra_kept > 0
    assert "tetrahedra" not in vars(mesh)
    assert mesh.tetrahedra is mesh.tetrahedra


@pytest.mark.parametrize("lattice", LATTICES)
@pytest.mark.parametrize("seed", range(8))
def test_exactly_the_nodes_nearer_than_the_margin_are_excluded(lattice: Lattice, seed: int) -> None:
    rng = np.random.default_rng(seed)
    mesh = tetrahedralise(Workspace(max=(3, 3, 3)), MeshSettings(lattice=lattice, pitch=0.4))
    obstacles = random_obstacles(rng, int(rng.integers(0, 5)), 3.0, 2.0)
    margin = float(rng.choice([0.0, 0.1, 0.5]))
    free = exclude(mesh, ObstacleSet(obstacles), margin)
    distances = [obstacle.signed_distance(mesh.points) for obstacle in obstacles]
    near = np.min([np.full(len(mesh.points), np.inf), *distances], axis=0) < margin
    assert np.array_equal(free.excluded, near)
    assert free.nodes == np.count_nonzero(~near)
    assert free.tetrahedra_kept == np.count_nonzero(~near[mesh.tetrahedra].any(axis=1))


@pytest.mark.parametrize("lattice", LATTICES)
def test_results_cannot_be_written(lattice: Lattice) -> None:
    mesh = tetrahedralise(Workspace(), MeshSettings(lattice=lattice, pitch=3))
    free = exclude(mesh, NO_OBSTACLES, 0.1)
    arrays = (mesh.points, mesh.edges, mesh.lengths, mesh.tetrahedra, free.excluded)
    assert not any(array.flags.writeable for array in arrays)


def test_within_holds_the_points_of_the_closed_box() -> None:
    points = np.random.default_rng(0).integers(0, 4, (200, 3)).astype(float)
    low, high = np.array([1.0, 0, 2]), np.array([2.0, 3, 2])
    expected = np.flatnonzero(((points >= low) & (points <= high)).all(axis=1))
    assert np.array_equal(within(points, low, high), expected)
