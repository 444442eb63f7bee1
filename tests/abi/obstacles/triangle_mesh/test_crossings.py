from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.triangle_mesh import crossings
from abi.obstacles.triangle_mesh.crossings import layers_of
from abi.obstacles.triangle_mesh.repair import clean
from abi.obstacles.triangle_mesh.winding import windings
from abi.verify.exact.mesh import ExactMesh
from abi.verify.exact.solids import vector
from tests.abi import meshes
from tests.abi.mesh_oracles import is_solid
from tests.thorough import examples


def pulled(seed: int) -> meshes.Mesh:
    """A sphere some of whose corners are pulled elsewhere, outward on the whole."""
    rng = np.random.default_rng(seed)
    vertices, faces = meshes.sphere(int(rng.integers(1, 3)))
    vertices *= rng.uniform(0.6, 1.4, (len(vertices), 1))
    count = rng.integers(0, 4)
    vertices[rng.choice(len(vertices), count, replace=False)] = rng.uniform(-1.5, 1.5, (count, 3))
    if rng.random() < 0.3:  # on a lattice, so that triangles touch
        vertices = np.round(vertices * 3) / 3
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    turned = np.einsum("ij,ij->i", np.cross(a, b), c).sum() < 0
    return vertices, faces[:, ::-1] if turned else faces


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=examples(10))
def test_only_shells_that_wind_once_or_not_at_all_are_in_the_first_layer(seed: int) -> None:
    vertices, faces = pulled(seed)
    around = meshes.box((4, 4, 4))
    label = np.repeat([0, 1], [len(faces), 12])
    first, second = layers_of(*meshes.joined((vertices, faces), around), label)
    assert second == 0
    points = np.random.default_rng(seed).uniform(-1.6, 1.6, (1000, 3))
    assert first > 0 or np.isin(windings(vertices, faces, points), [0, 1]).all()


def spiked(end: tuple[float, float, float], at: tuple[float, float, float]) -> meshes.Mesh:
    """A ball with a spike through it, which winds -1 times where it comes out on the far side."""
    vertices, faces = meshes.sphere(1)
    vertices[vertices[:, 2].argmax()] = end
    return vertices + np.array(at), faces


@pytest.mark.parametrize("most", [crossings._MOST_PAIRS, 0])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_spikes_through_their_own_solids_hollow_no_other(
    count: int, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nor where shells are too finely divided to see whether they cross themselves."""
    monkeypatch.setattr(crossings, "_MOST_PAIRS", most)
    monkeypatch.setattr(crossings, "_PAIRS_EACH", 0 if not most else crossings._PAIRS_EACH)
    parts = [spiked((0.03, 0.02 * k, -3), (0.01 * k, 0, 0)) for k in range(count)]
    parts.append(meshes.box((2, 2, 2), (0.2, 0, -2.2)))
    surface = clean(*meshes.joined(*parts, meshes.box((1, 1, 1), (9, 0, 0))))
    points = np.random.default_rng(count).uniform(-3, 2, (400, 3))
    solid = np.any([np.abs(windings(*part, points)) > 0 for part in parts], axis=0)
    assert surface.closed
    assert not surface.notes or "thin shell" not in " ".join(surface.notes)
    np.testing.assert_array_equal(is_solid(surface, points), solid)
    np.testing.assert_array_equal(MeshShape.of(surface).signed_distance(points) < 0, solid)
    origin = vector((0.0, 0.0, 0.0)), (1.0, 0.0, 0.0, 0.0)
    content = surface.vertices, surface.faces, surface.closed
    exact = ExactMesh(*content, 1.0, *origin, surface.layers)
    inside = [exact.inside(vector(point)) for point in points[:50].tolist()]
    np.testing.assert_array_equal(inside, solid[:50])


@pytest.mark.parametrize("most", [1, 1000])
def test_shells_are_in_layers_of_their_own_only_where_they_are_near_each_other(
    most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However many pairs are looked for."""
    monkeypatch.setattr(crossings, "_MOST_NEAR", most)
    apart = [spiked((0.03, 0.02, -3), (8 * k, 0, 0)) for k in range(3)]
    parts = [*apart, spiked((0.03, 0.02, -3), (0.1, 0.1, 0.1)), meshes.box((30, 4, 4))]
    label = np.repeat(np.arange(5, dtype=np.int32), [len(faces) for _, faces in parts])
    assert layers_of(*meshes.joined(*parts), label).tolist() == [1, 1, 1, 2, 0]


@pytest.mark.parametrize("more", [[], [meshes.box((8, 2, 2))]])
def test_shells_that_cross_themselves_are_in_no_layer_where_they_are_too_many(
    more: list[meshes.Mesh], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(crossings, "_MOST_CROSSING", 1)
    parts = [*(spiked((0.03, 0.02, -3), (k, 0, 0)) for k in range(3)), *more]
    surface = clean(*meshes.joined(*parts))
    points = np.random.default_rng(0).uniform((-4, -1, -1), (4, 1, 1), (200, 3))
    assert is_solid(surface, points).all() == surface.closed == (len(more) > 0)
    assert any("thin shell" in note for note in surface.notes)
