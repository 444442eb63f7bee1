"""Uploaded meshes without a browser: where and how large they land, and how they are drawn."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.obstacles.triangle_mesh.repair import clean
from abi.scene.scene import Scene
from app.drawing.mesh_picture import MOST_DRAWN, drawn_triangles
from app.panels.files.mesh_uploads import safe_name
from app.panels.obstacles.free_place import free_place
from app.panels.obstacles.mesh_note import fitted_scale
from tests.abi import meshes

SCENE = Scene.from_dict({"version": 1})


@pytest.mark.parametrize("extent", [1e-4, 0.49, 0.6, 2.0, 4.4, 4.6, 1e5])
def test_a_mesh_lands_at_a_size_that_can_be_seen(extent: float) -> None:
    surface = clean(*meshes.box((extent, extent / 2, extent / 3)))
    scale = fitted_scale(surface, SCENE)

    assert 6 / 12 <= scale * extent <= 6 * 3 / 4
    if scale != 1:
        assert scale * extent == pytest.approx(2, rel=5e-3)


@pytest.mark.slow
@settings(max_examples=8)
@given(st.integers(0, 2**32 - 1))
def test_each_new_obstacle_finds_a_place_of_its_own(seed: int) -> None:
    random = np.random.default_rng(seed)
    half = random.uniform(0.1, 0.45, 3)
    middle = np.array([3.0, 3.0, 4.5])
    taken: list[tuple[np.ndarray, np.ndarray]] = []
    for _ in range(20):
        place = free_place(half, middle, SCENE, taken)
        low, high = place - half, place + half
        for below, above in taken:
            assert ((low >= above) | (high <= below)).any()
        assert (low >= -1e-9).all()
        assert (high <= 6 + 1e-9).all()
        taken.append((low, high))


def test_where_nothing_is_free_the_least_overlap_is_found() -> None:
    full = [(np.zeros(3), np.full(3, 6.0))]
    place = free_place(np.ones(3), np.full(3, 3.0), SCENE, full)
    assert np.isfinite(place).all()


@pytest.mark.slow
def test_a_picture_has_few_triangles_and_is_near_the_surface() -> None:
    surface = clean(*meshes.bumpy(7))
    assert len(surface.faces) > MOST_DRAWN
    vertices, faces = drawn_triangles(surface)

    assert MOST_DRAWN / 8 < len(faces) <= MOST_DRAWN
    assert faces.max() < len(vertices)
    np.testing.assert_allclose(vertices.min(axis=0), surface.vertices.min(axis=0), atol=0.01)
    np.testing.assert_allclose(vertices.max(axis=0), surface.vertices.max(axis=0), atol=0.01)
    few = clean(*meshes.box())
    assert len(drawn_triangles(few)[1]) == len(few.faces)


@pytest.mark.parametrize("name", ["../../etc/passwd.STL", "a b.stl", ".obj", "x" * 300 + ".ply"])
def test_a_name_from_outside_becomes_a_plain_one(name: str) -> None:
    plain = safe_name(name)
    assert "/" not in plain
    assert len(plain) <= 70
    assert plain.rpartition(".")[2] == name.rpartition(".")[2].lower()
