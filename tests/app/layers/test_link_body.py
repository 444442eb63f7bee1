"""The colours of a link's triangles do not mix where they meet."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from abi.robot.urdf.link import LinkShape
from app.layers.arm.link_body import link_mesh


@given(st.integers(1, 60), st.integers(3, 30), st.integers(0, 2**32 - 1))
def test_each_triangle_has_its_own_place_and_colour(faces: int, points: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    places = random.normal(size=(points, 3))
    corners = random.integers(points, size=(faces, 3)).astype(np.int32)
    colours = random.choice([0, 7, 255], size=(faces, 3)).astype(np.uint8)
    shape = LinkShape("mesh", (1.0, 1.0, 1.0), np.eye(4), places, corners, colours)
    vertices, of_faces, of_vertices = link_mesh([shape, shape], np.eye(4), 2.0)
    placed = np.tile(2 * places[corners], (2, 1, 1))
    np.testing.assert_array_equal(vertices[of_faces], placed)
    of_corners = np.repeat(np.tile(colours, (2, 1))[:, None], 3, axis=1)
    np.testing.assert_array_equal(of_vertices[of_faces], of_corners)
    assert len(vertices) <= 2 * max(points, 3 * faces)
