from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from abi import mesh
from abi.arrays import FloatArray, read_only
from abi.graph import REACH
from abi.kernels import any_angle as kernels
from abi.mesh import TetMesh
from abi.scene import Scene
from abi.shapes import MeshShape
from abi.solids import Solid, packed
from tests.abi.test_scene import obstacles, points
from tests.abi.test_taut import CUBE, round_cube, scene_of

MARGIN = 0.1


def solids_of(scene: Scene) -> tuple[Solid, ...]:
    return tuple(solid for solid in scene.obstacles if not isinstance(solid, MeshShape))


def found(
    whole: TetMesh, scene: Scene, margin: float, stride: int = 1, most: float = math.inf
) -> FloatArray:
    free = mesh.exclude(whole, scene.obstacles, margin)
    shape, _, steps, places, indptr, indices = whole.net
    solids = solids_of(scene)
    kernels.warm()
    path: Any = kernels.any_angle(
        *(shape, steps, places, indptr, indices, free.excluded),
        *(stride, stride * REACH * whole.longest_edge, scene.start, scene.goal),
        *(packed(solids), read_only(np.full(4 * len(solids), margin)), most),
    )
    return np.asarray(path).reshape(-1, 3)


def length(path: FloatArray) -> float:
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


@settings(max_examples=80, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    bodies=st.lists(obstacles, max_size=5),
    start=points,
    goal=points,
    pitch=st.floats(0.4, 1.5),
    lattice=st.sampled_from(["bcc", "kuhn", "delaunay"]),
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

    if not len(path) or start == goal:
        return
    np.testing.assert_array_equal(path[[0, -1]], [start, goal])
    for solid in scene.obstacles:
        kept = solid.segment_distance(path[:-1], path[1:])
        assert (kept >= MARGIN - 1e-9).all()
    free = mesh.exclude(whole, scene.obstacles, MARGIN)
    nodes = {tuple(node) for node in whole.points[~free.excluded].tolist()}
    assert all(tuple(place) in nodes for place in path[1:-1].tolist())
    for bound in (0.99 * length(path), 1.01 * length(path)):
        shorter = found(whole, scene, MARGIN, stride, bound)
        assert not len(shorter) or length(shorter) < bound


@pytest.mark.parametrize("lattice", ["bcc", "kuhn"])
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


@pytest.mark.parametrize("ends", [([0, 0, 0], [6, 6, 6]), ([6, 0, 0], [0, 6, 6])])
@pytest.mark.parametrize("lattice", ["bcc", "kuhn", "delaunay"])
def test_on_finer_meshes_it_nears_the_optimum(
    lattice: str, ends: tuple[list[float], list[float]]
) -> None:
    lengths = []
    for pitch in (1.0, 0.5, 0.25):
        scene = scene_of([CUBE], start=ends[0], goal=ends[1], pitch=pitch, lattice=lattice)
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
