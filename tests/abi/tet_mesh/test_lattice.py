from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.arrays import IntArray
from abi.tet_mesh.delaunay import volumes
from abi.tet_mesh.lattice import REGULAR
from abi.tet_mesh.regular_lattice import Cells
from abi.tet_mesh.tet_mesh import edges_of
from tests.thorough import examples

LATTICES = st.sampled_from(list(REGULAR))
CELLS = st.tuples(*[st.integers(1, 5)] * 3)


def table(name: str, points: int, cells: Cells) -> IntArray:
    families = REGULAR[name].tetrahedra(np.arange(points, dtype=np.int32), cells)
    return np.concatenate([np.stack([c.ravel() for c in four], axis=1) for four in families])


@settings(max_examples=examples(20))
@given(LATTICES, CELLS)
def test_edges_are_the_edges_of_the_tetrahedra(name: str, cells: Cells) -> None:
    points = REGULAR[name].points((0, 0, 0), cells, cells)
    families = list(REGULAR[name].edges(np.arange(len(points)), cells))
    edges = np.concatenate([np.stack([a.ravel(), b.ravel()], axis=1) for a, b, _ in families])
    expected = edges_of(table(name, len(points), cells), len(points))
    assert (edges[:, 0] < edges[:, 1]).all()
    assert np.array_equal(edges[np.lexsort(edges.T[::-1])], expected)


@settings(max_examples=examples(20))
@given(LATTICES, CELLS)
def test_the_step_leads_from_one_end_of_an_edge_to_the_other(name: str, cells: Cells) -> None:
    points = REGULAR[name].points((0, 0, 0), cells, cells)
    for a, b, step in REGULAR[name].edges(np.arange(len(points)), cells):
        assert np.allclose(points[b] - points[a], step, rtol=0, atol=1e-14)


@settings(max_examples=examples(20))
@given(LATTICES, CELLS, st.integers(0, 2**32 - 1))
def test_a_family_of_flags_counts_what_a_table_counts(name: str, cells: Cells, seed: int) -> None:
    points = len(REGULAR[name].points((0, 0, 0), cells, cells))
    free = np.random.default_rng(seed).random(points) < 0.8
    counted = sum(
        np.count_nonzero(np.logical_and.reduce(four))
        for four in REGULAR[name].tetrahedra(free, cells)
    )
    assert counted == np.count_nonzero(free[table(name, points, cells)].all(axis=1))


@pytest.mark.parametrize(("name", "kinds"), [("bcc", 1), ("kuhn", 1)])
def test_tetrahedra_of_cubes_are_congruent(name: str, kinds: int) -> None:
    # between the faces of the box and the nearest centres, bcc has halves of pyramids instead
    cells = (3, 4, 2)
    points = REGULAR[name].points((0, 0, 0), cells, cells)
    tetrahedra = table(name, len(points), cells)
    if name == "bcc":
        centre = tetrahedra >= (4 * 5 * 3)
        tetrahedra = tetrahedra[centre.sum(axis=1) == 2]
        nx, ny, nz = cells
        faces = (nx - 1) * ny * nz + nx * (ny - 1) * nz + nx * ny * (nz - 1)
        assert len(tetrahedra) == 4 * faces
    corners = points[tetrahedra]
    sides = np.linalg.norm(corners[:, :, None] - corners[:, None], axis=3).reshape(-1, 16)
    assert len(np.unique(np.sort(sides, axis=1).round(9), axis=0)) == kinds
    if name == "bcc":
        assert np.allclose(np.unique(sides.round(9)), [0, np.sqrt(0.75), 1])


@settings(max_examples=40)
@given(LATTICES, CELLS)
def test_all_tetrahedra_have_the_same_volume(name: str, cells: Cells) -> None:
    points = REGULAR[name].points((0, 0, 0), cells, cells)
    volume = volumes(points, table(name, len(points), cells))
    assert np.allclose(volume, 1 / 12 if name == "bcc" else 1 / 6, rtol=1e-12)
