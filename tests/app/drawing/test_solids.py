"""Solids that are drawn are closed, face outwards, and are as large as geometry says."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
import trimesh

from app.drawing.solids import Triangles, box, cylinder, sphere


@pytest.mark.parametrize(
    ("solid", "volume", "bounds"),
    [
        (box, 1.0, (0.5, 0.5, 0.5)),
        (cylinder, math.pi, (1.0, 1.0, 0.5)),
        (sphere, 4 / 3 * math.pi, (1.0, 1.0, 1.0)),
    ],
)
def test_a_solid_is_closed_and_has_its_size(
    solid: Callable[[], Triangles], volume: float, bounds: tuple[float, float, float]
) -> None:
    mesh = trimesh.Trimesh(*solid(), process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert 0.97 * volume < mesh.volume <= volume * (1 + 1e-12)  # its corners are on the solid
    np.testing.assert_allclose(mesh.bounds, np.array([[-1.0], [1.0]]) * bounds)
