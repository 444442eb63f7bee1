"""Exclusions by triangle meshes, against distances that are sampled along every edge."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.pose import rotation
from abi.obstacles.triangle_mesh.repair import clean
from abi.obstacles.triangle_mesh.surface import Surface
from abi.scene.lattices import LATTICES, Lattice
from abi.scene.settings import MeshSettings, Workspace
from abi.search.build_graph import _graph
from abi.tet_mesh import tet_mesh
from abi.tet_mesh.exclusion import exclude
from tests.abi import mesh_oracles, meshes

_SAMPLES = 17
CASES = {
    "box": meshes.box((1.0, 0.4, 1.4)),
    "blob": meshes.bumpy(2),
    "knot": meshes.knot(300),
    "room": meshes.room(),
    "soup": meshes.soup(30),
    "plate": (np.eye(3), np.array([[0, 1, 2]], dtype=np.int32)),
}


@pytest.mark.slow
@settings(max_examples=8)
@given(
    st.sampled_from(sorted(CASES)),
    st.sampled_from(list(LATTICES)),
    st.sampled_from([0.0, 0.006, 0.1, 0.3]),
    st.integers(0, 2**32 - 1),
)
def test_an_edge_is_open_where_samples_of_it_are_clear(
    name: str, lattice: Lattice, margin: float, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    pose: dict[str, Any] = {
        "position": tuple(rng.uniform(0.5, 2.5, 3).tolist()),
        "wxyz": tuple(rng.normal(size=4).tolist()),
        "scale": float(rng.uniform(0.4, 1.6)),
    }
    surface = clean(*CASES[name])
    solid = MeshShape.of(surface, **pose).in_unit("m")
    chosen = MeshSettings(lattice=lattice, pitch=float(rng.uniform(0.4, 0.7)), seed=seed)
    made = tet_mesh.tetrahedralise(Workspace(max=(3.0, 2.6, 3.3)), chosen)
    free = exclude(made, ObstacleSet((solid,)), margin)
    found = _graph(free, free.open_directions, [], [], [0, 1])
    is_open = {(a, b) for a, b in found.edges.tolist()}

    ends = made.points[made.edges]
    share = np.linspace(0, 1, _SAMPLES)[:, None]
    points = (ends[:, :1] + share * (ends[:, 1:] - ends[:, :1])).reshape(-1, 3)
    in_file = (points - solid.position) @ rotation(solid.wxyz) / solid.factor
    mesh = surface.vertices, surface.faces
    away = mesh_oracles.distances(mesh, in_file).reshape(-1, _SAMPLES) * solid.factor
    nodes = mesh_oracles.signed_distances(
        mesh, surface.closed, (made.points - solid.position) @ rotation(solid.wxyz) / solid.factor
    )
    nodes *= solid.factor
    gap = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / (_SAMPLES - 1)
    free_ends = (nodes[made.edges] >= margin - 1e-9).all(axis=1)
    # between samples a distance falls by no more than half the way
    surely = (nodes[made.edges] >= margin + 1e-9).all(axis=1)
    surely &= away.min(axis=1) - gap / 2 >= margin + 1e-7
    never = ~free_ends | (away.min(axis=1) < margin - 1e-9)
    for edge, sure, no in zip(map(tuple, made.edges.tolist()), surely, never, strict=True):
        assert edge in is_open or not sure
        assert edge not in is_open or not no
    excluded = nodes < margin
    assert (free.excluded == excluded)[np.abs(nodes - margin) > 1e-9].all()


def test_the_lattice_far_from_a_mesh_is_untouched() -> None:
    made = tet_mesh.tetrahedralise(Workspace(max=(2, 2, 2)), MeshSettings(pitch=0.5))
    solid = MeshShape.of(clean(*meshes.box()), position=(9.0, 1.0, 1.0))
    free = exclude(made, ObstacleSet((solid,)), 0.1)
    assert free.nodes == len(made.points)
    assert np.array_equal(free.open_directions, made.open_directions)


@pytest.mark.parametrize("solid", [True, False])
def test_a_solid_around_the_lattice_takes_all_of_it(solid: bool) -> None:
    made = tet_mesh.tetrahedralise(Workspace(max=(2, 2, 2)), MeshSettings(pitch=0.5))
    outer, hollow = meshes.box((4.0, 4.0, 4.0)), meshes.inverted(meshes.box((3.0, 3.0, 3.0)))
    surface = Surface(*(outer if solid else meshes.joined(outer, hollow)), closed=True)
    free = exclude(made, ObstacleSet((MeshShape.of(surface, position=(1.0, 1.0, 1.0)),)), 0.1)
    assert free.nodes == (0 if solid else len(made.points))
