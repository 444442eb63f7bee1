"""Pictures of round obstacles against their distance."""

from __future__ import annotations

import numpy as np
import pytest

from abi.obstacles.primitives import Capsule, Cylinder
from app.obstacle_body import _round_body


@pytest.mark.parametrize(
    "obstacle",
    [
        Capsule(radius=0.3, height=2.0),
        Capsule(radius=2.0, height=0.1),
        Cylinder(radius=0.3, height=2.0),
        Cylinder(radius=3.0, height=0.01),
    ],
)
def test_a_round_body_has_its_corners_on_the_surface(obstacle: Capsule | Cylinder) -> None:
    vertices, faces = _round_body(obstacle)

    away = obstacle.signed_distance(vertices.astype(np.float64))
    assert np.abs(away).max() < 1e-6
    low, high = obstacle.bounds()
    np.testing.assert_allclose(vertices.min(axis=0), low, atol=0.02 * (high - low).max())
    np.testing.assert_allclose(vertices.max(axis=0), high, atol=0.02 * (high - low).max())
    assert faces.max() < len(vertices)
