from __future__ import annotations

import math
from itertools import pairwise, product
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from abi.arrays import FloatArray, read_only
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.packing import pack
from abi.obstacles.primitives import Primitive
from abi.scene.lattices import LATTICES
from abi.scene.scene import Scene
from abi.search.build_graph import REACH
from abi.search.taut import theta_star_kernels as kernels
from abi.search.taut.taut_path import _margins
from abi.tet_mesh import tet_mesh as mesh
from abi.tet_mesh.adjacency_kernels import BCC, KUHN, MeshSizes
from abi.tet_mesh.exclusion import exclude
from abi.tet_mesh.lattice import REGULAR
from abi.tet_mesh.tet_mesh import TetMesh
from tests.abi.scene.test_scene import obstacles, points
from tests.abi.search.taut.test_taut_path import CUBE, round_cube, scene_of
from tests.abi.shape_distances import segment_distance
from tests.random_scenes import box_scene
from tests.thorough import of_each_kind

MARGIN = 0.1
DIAGONALS = (((0, 0, 0), (6, 6, 6)), ((6, 0, 0), (0, 6, 6)))


def solids_of(scene: Scene) -> tuple[Primitive, ...]:
    return tuple(solid for solid in scene.obstacles if not isinstance(solid, MeshShape))


def arguments(
    whole: TetMesh, scene: Scene, margins: FloatArray, stride: int = 1, most: float = math.inf
) -> tuple[Any, ...]:
    """Arguments of the kernel; ``margins`` (4, k) are for each kind of segment and solid."""
    free = exclude(whole, ObstacleSet(scene.obstacles), float(margins.max(initial=0)))
    return (
        *(whole.adjacency, free.excluded, stride, stride * REACH * whole.longest_edge),
        *(
            (scene.start, scene.goal),
            (pack(solids_of(scene)), read_only(margins.reshape(-1))),
            most,
        ),
    )


def found(
    whole: TetMesh, scene: Scene, margin: float, stride: int = 1, most: float = math.inf
) -> FloatArray:
    margins = np.full((4, len(solids_of(scene))), margin)
    return searched(arguments(whole, scene, margins, stride, most))


def searched(given: tuple[Any, ...]) -> FloatArray:
    return np.asarray(kernels.any_angle(*given)).reshape(-1, 3)


def length(path: FloatArray) -> float:
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


@pytest.mark.slow
@settings(max_examples=16, suppress_health_check=list(HealthCheck))
@given(
    bodies=st.lists(obstacles, max_size=5),
    start=points,
    goal=points,
    pitch=st.floats(0.4, 1.5),
    lattice=st.sampled_from(list(LATTICES)),
    stride=st.integers(1, 4),
)
def test_it_goes_by_free_nodes_that_see_each_other(
    bodies: list[Any],
    start: list[float],
    goal: list[float],
    pitch: float,
    lattice: str,
    stride: int,
) -> None:
    scene = scene_of(bodies, start=start, goal=goal, pitch=pitch, lattice=lattice)
    whole = mesh.tetrahedralise(scene.workspace, scene.mesh)

    path = found(whole, scene, MARGIN, stride)

    assume(len(path) and start != goal)
    np.testing.assert_array_equal(path[[0, -1]], [start, goal])
    for solid in scene.obstacles:
        kept = segment_distance(solid, path[:-1], path[1:])
        assert (kept >= MARGIN - 1e-9).all()
    free = exclude(whole, ObstacleSet(scene.obstacles), MARGIN)
    nodes = {tuple(node) for node in whole.points[~free.excluded].tolist()}
    assert all(tuple(place) in nodes for place in path[1:-1].tolist())
    for bound in (0.99 * length(path), 1.01 * length(path)):
        shorter = found(whole, scene, MARGIN, stride, bound)
        assert not len(shorter) or length(shorter) < bound


@pytest.mark.parametrize("lattice", REGULAR)
@pytest.mark.parametrize("stride", [2, 3, 4])
def test_every_few_nodes_are_a_coarser_lattice(lattice: str, stride: int) -> None:
    scene = scene_of([CUBE], pitch=0.5, lattice=lattice)
    whole = mesh.tetrahedralise(scene.workspace, scene.mesh)
    assert whole.stencil is not None
    apart = stride * np.array(whole.stencil.cell)

    path = found(whole, scene, MARGIN, stride)

    assert len(path) > 2
    # corners of the coarse lattice differ by whole cells, its centres by a half along each axis
    for p, q in pairwise(path[1:-1]):
        halves = 2 * (q - p) / apart
        np.testing.assert_allclose(halves, halves.round(), atol=1e-9)
        assert len({*(halves.round() % 2).tolist()}) == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("lattice", "ends"),
    of_each_kind(
        product(LATTICES, DIAGONALS),
        ("bcc", DIAGONALS[0]),
        ("kuhn", DIAGONALS[1]),
        ("delaunay", DIAGONALS[0]),
    ),
)
def test_on_finer_meshes_it_nears_the_optimum(
    lattice: str, ends: tuple[tuple[int, ...], tuple[int, ...]]
) -> None:
    lengths = []
    for pitch in (1.0, 0.5, 0.25):
        start, goal = map(list, ends)
        scene = scene_of([CUBE], start=start, goal=goal, pitch=pitch, lattice=lattice)
        whole = mesh.tetrahedralise(scene.workspace, scene.mesh)
        lengths.append(length(found(whole, scene, 0.2)))

    optimum = round_cube(0.2)
    # edges alone leave more than a tenth, however fine the mesh
    assert optimum <= min(lengths)
    assert lengths[-1] <= 1.015 * optimum


def test_with_nothing_in_the_way_it_is_straight() -> None:
    scene = scene_of([], start=[0.3, 0.4, 0.5], goal=[5, 4, 3])
    whole = mesh.tetrahedralise(scene.workspace, scene.mesh)

    np.testing.assert_array_equal(found(whole, scene, MARGIN), [scene.start, scene.goal])


def test_behind_a_wall_there_is_none() -> None:
    wall = {"shape": "box", "size": [0.5, 8, 8], "position": [3, 3, 3]}
    scene = scene_of([wall], start=[1, 3, 3], goal=[5, 3, 3], pitch=0.8)
    whole = mesh.tetrahedralise(scene.workspace, scene.mesh)

    assert not len(found(whole, scene, MARGIN))


@pytest.mark.slow
@settings(max_examples=16)
@given(
    bodies=st.lists(obstacles, min_size=1, max_size=5),
    start=points,
    goal=points,
    pitch=st.floats(0.6, 1.5),
    lattice=st.sampled_from(list(LATTICES)),
    stride=st.integers(1, 3),
)
def test_compiled_and_plain_find_the_same(
    bodies: list[Any],
    start: list[float],
    goal: list[float],
    pitch: float,
    lattice: str,
    stride: int,
) -> None:
    scene = scene_of(bodies, start=start, goal=goal, pitch=pitch, lattice=lattice)
    whole = mesh.tetrahedralise(scene.workspace, scene.mesh)
    given = arguments(whole, scene, own_margins(scene, MARGIN), stride)

    plain = kernels.any_angle.interpret(*given)

    np.testing.assert_allclose(plain.reshape(-1, 3), searched(given), rtol=0, atol=1e-12)


def own_margins(scene: Scene, margin: float) -> FloatArray:
    """A segment from the start or to the goal keeps that end's own distance where it is less."""
    ends = np.array([scene.start, scene.goal])
    distances = [solid.signed_distance(ends) for solid in solids_of(scene)]
    return _margins(np.array(distances).reshape(-1, 2).T, margin)


def test_segments_from_and_to_ends_that_stand_near_keep_less() -> None:
    far, start_near, goal_near = [0.8, 2.4, 2.6], [1.45, 2.0, 3.0], [4.55, 4.0, 3.2]
    for start, goal in ((start_near, goal_near), (start_near, [5.2, 4, 3]), (far, goal_near)):
        scene = scene_of([CUBE], start=start, goal=goal, pitch=0.5)
        (cube,) = scene.obstacles
        whole = mesh.tetrahedralise(scene.workspace, scene.mesh)
        margins = own_margins(scene, 0.2)

        path = searched(arguments(whole, scene, margins))

        # round an edge of the cube, which is no shorter for what the ends are spared
        assert len(path) >= 4
        np.testing.assert_array_equal(path[[0, -1]], [start, goal])
        kept = segment_distance(cube, path[:-1], path[1:])
        assert (kept[1:-1] >= 0.2 - 1e-9).all()
        assert kept[0] >= margins[1, 0] - 1e-9
        assert kept[-1] >= margins[2, 0] - 1e-9
        assert min(kept[0], kept[-1]) == pytest.approx(0.05, abs=1e-6)
        assert not len(found(whole, scene, 0.2))


def test_from_the_start_straight_to_the_goal_counts_the_nearer_one() -> None:
    for start, goal in (([1.46, 2, 3], [1.48, 4, 3]), ([1.48, 2, 3], [1.46, 4, 3])):
        scene = scene_of([CUBE], start=start, goal=goal, pitch=0.5)
        whole = mesh.tetrahedralise(scene.workspace, scene.mesh)
        margins = own_margins(scene, 0.2)

        np.testing.assert_array_equal(
            searched(arguments(whole, scene, margins)), [scene.start, scene.goal]
        )
        for kind in (0, 1, 2):
            straight = margins.copy()
            straight[3] = margins[kind]
            if straight[3, 0] > margins[3, 0]:
                assert len(searched(arguments(whole, scene, straight))) != 2


@pytest.mark.parametrize(("kind", "cross"), [(BCC, 8), (KUHN, 0)])
@pytest.mark.parametrize("stride", [1, 2, 3, 4, 5])
def test_the_coarse_lattice_lies_in_the_middle(kind: int, cross: int, stride: int) -> None:
    for cells in ((7, 9, 11), (8, 5, 6), (12, 13, 14)):
        x, y, z = cells
        corners = (x + 1) * (y + 1) * (z + 1)
        nodes = corners + (x * y * z if cross else 0)
        fine = MeshSizes(kind, x, y, z, corners, nodes, 0, cross, 0)
        coarse = kernels._coarse(fine, stride)
        halves = np.array([kernels._fine(fine, coarse, stride, k) for k in range(coarse.nodes)])
        low, high = halves.min(axis=0), 2 * np.array(cells) - halves.max(axis=0)

        # as near to one side as to the other, up to a cell, and no more could have a place
        assert (low >= 0).all()
        assert (np.abs(high - low) <= 2).all()
        assert (low + high < 2 * stride).all()
        assert len(np.unique(halves, axis=0)) == coarse.nodes
        even = (halves % 2 == 0).all(axis=1)
        # a node of the coarse lattice is one of the fine lattice
        assert (even | ((halves % 2 == 1).all(axis=1) & (cross > 0))).all()


@pytest.mark.parametrize("own", [(0.02, 0.05), (0.05, 0.02)])
def test_only_the_first_and_the_last_segment_keep_less(own: tuple[float, float]) -> None:
    inner = []
    walls = [
        {"shape": "box", "size": [0.4, 4, 6], "position": [x, y, 3]} for x, y in ((2, 2), (4, 4))
    ]
    for pitch in np.linspace(0.4, 0.7, 9):
        scene = scene_of(walls, start=[0.5, 1, 3], goal=[5.5, 5, 3.5], pitch=float(pitch))
        whole = mesh.tetrahedralise(scene.workspace, scene.mesh)
        kinds = np.array([0.2, *own, min(own)])
        margins = np.repeat(kinds[:, None], len(scene.obstacles), axis=1)

        path = searched(arguments(whole, scene, margins))

        kept = np.min(
            [segment_distance(solid, path[:-1], path[1:]) for solid in scene.obstacles], 0
        )
        assert kept[0] >= own[0] - 1e-9
        assert kept[-1] >= own[1] - 1e-9
        inner.extend(kept[1:-1])
    assert len(inner) > 10
    assert min(inner) >= 0.2 - 1e-9


@pytest.mark.parametrize(("lattice", "pitches"), [("bcc", (0.26, 0.5)), ("kuhn", (0.25, 0.5))])
@pytest.mark.parametrize("seed", range(3))
def test_every_second_node_is_the_lattice_of_twice_the_cell(
    lattice: str, pitches: tuple[float, float], seed: int
) -> None:
    paths, cells = [], []
    for pitch, stride in zip(pitches, (2, 1), strict=True):
        scene = box_scene(seed, pitch).replace(mesh={"lattice": lattice, "pitch": pitch})
        whole = mesh.tetrahedralise(scene.workspace, scene.mesh)
        cells.append(whole.adjacency.shape[1:4])
        paths.append(found(whole, scene, 0.2, stride))

    np.testing.assert_array_equal(cells[0], 2 * np.array(cells[1]))
    assert len(paths[0]) > 2
    np.testing.assert_allclose(paths[0], paths[1], rtol=0, atol=1e-12)
