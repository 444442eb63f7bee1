"""Memories of shapes and surfaces."""

from __future__ import annotations

import gc
import weakref
from unittest.mock import Mock

import numpy as np

from abi.arrays import FloatArray
from abi.obstacles.per_shape import CROWD, per_shape
from abi.obstacles.primitives import Sphere
from abi.obstacles.triangle_mesh.per_surface import per_surface
from abi.obstacles.triangle_mesh.repair import clean
from abi.obstacles.triangle_mesh.surface import Surface
from tests.abi import meshes


def test_of_a_crowd_only_what_has_moved_is_asked_again() -> None:
    radius = Mock(side_effect=lambda one: one.radius)
    radii = per_shape(radius)
    crowd = [Sphere(radius=1.0 + k) for k in range(CROWD)]
    assert radii(crowd) == [1.0 + k for k in range(CROWD)]
    crowd[3] = Sphere(radius=0.5)
    radius.reset_mock()
    assert radii(crowd)[3] == 0.5
    radius.assert_called_once_with(crowd[3])
    assert radii(crowd[:2]) == [1.0, 2.0]
    del crowd[5]
    radius.reset_mock()
    assert len(radii([*crowd, crowd[0]])) == CROWD
    radius.assert_not_called()


def test_results_are_kept_as_long_as_their_surfaces() -> None:
    results: list[weakref.ref[FloatArray]] = []

    @per_surface
    def extent(surface: Surface) -> FloatArray:
        found = np.array([surface.extent])
        results.append(weakref.ref(found))
        return found

    surfaces = [clean(*meshes.sphere(1, 0.5 + 0.01 * k)) for k in range(40)]
    for _ in range(2):
        assert [extent(one)[0] for one in surfaces] == [one.extent for one in surfaces]
    same = Surface(surfaces[0].vertices, surfaces[0].faces, surfaces[0].closed)
    assert extent(same) is extent(surfaces[0])
    assert len(results) == 40
    del surfaces
    gc.collect()
    assert 0 < sum(one() is not None for one in results) < 40
