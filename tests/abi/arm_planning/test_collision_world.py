"""The boxes that an arm takes a triangle mesh for."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from abi.arm_planning.world.mesh_boxes import boxes_of
from abi.obstacles.triangle_mesh.repair import clean
from abi.obstacles.triangle_mesh.shells import areas_of
from tests.abi import meshes

_SIGNS = np.array(list(itertools.product((-1, 1), repeat=3)))


@pytest.mark.parametrize(
    "mesh", [meshes.soup(40), meshes.knot(800), meshes.sphere(2, 0.8)], ids=["soup", "knot", "ball"]
)
def test_each_box_holds_those_inside_it_and_those_of_triangles_are_the_smallest(
    mesh: meshes.Mesh,
) -> None:
    surface = clean(*mesh)
    middles, halves, axes, inside = boxes_of(surface)
    corners = middles[:, None] + np.einsum("nij,ncj->nci", axes, _SIGNS * halves[:, None])
    assert (inside[:, 1] > 0).any()
    for k, (first, last) in enumerate(inside):
        away = np.einsum("ji,ncj->nci", axes[k], corners[first:last] - middles[k])
        assert (np.abs(away) <= halves[k] + 1e-12).all()
    flat = corners[inside[:, 1] == 0].reshape(-1, 3)
    used = surface.vertices[surface.faces].reshape(-1, 3)
    assert flat.min() <= used.min() + 1e-9
    assert flat.max() >= used.max() - 1e-9
    areas = np.sort(4 * halves[inside[:, 1] == 0][:, :2].prod(axis=1))
    np.testing.assert_allclose(areas, 2 * np.sort(areas_of(surface.vertices, surface.faces)))
