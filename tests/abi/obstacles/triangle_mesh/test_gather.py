"""Triangles gathered around a segment, against all triangles."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.obstacles.triangle_mesh.bvh import build_tree
from abi.obstacles.triangle_mesh.gather_kernels import comes_near_gathered, gather, no_triangles
from abi.obstacles.triangle_mesh.triangle_kernels import DEPTH, segment_to_triangle
from abi.obstacles.vector_kernels import triangle_at
from tests.abi import meshes

REACH = 0.4
DOUBT = 1e-9


@pytest.mark.slow
@settings(max_examples=16)
@given(st.integers(0, 2**32 - 1), st.sampled_from(["loose", "flat", "slivers"]))
def test_a_segment_comes_near_what_is_gathered_as_it_does_to_all(seed: int, kind: str) -> None:
    rng = np.random.default_rng(seed)
    vertices, faces = meshes.soup(40, seed)
    if kind == "flat":
        vertices[:, 2] = 0.0
    corners = vertices[faces]
    if kind == "slivers":
        corners[:, 2] = corners[:, 1] + rng.choice([1e-12, 1e-9, 1e-6]) * corners[:, 0]
    tree = build_tree(corners)
    p, q = map(tuple, rng.uniform(-1, 1, (2, 3)).tolist())
    gathered = no_triangles()
    waiting = np.empty(DEPTH, np.int32)
    count = gather(tree, (p, q), REACH, DOUBT, gathered, waiting)
    assert count >= 0

    # short segments from places on the long one that end within reach
    for share, size in rng.uniform(0, 1, (20, 2)):
        start = np.array(p) + share * (np.array(q) - p)
        step = rng.normal(size=3)
        end = start + size * REACH / 2 * step / np.linalg.norm(step)
        short = tuple(start.tolist()), tuple(end.tolist())
        nearest = min(
            segment_to_triangle(*short, triangle_at(tree.corners, k)) for k in range(len(corners))
        )
        for limit in (0.0, REACH / 4, REACH / 2):
            found = comes_near_gathered(tree, gathered, count, short, limit, DOUBT)
            assert found == (nearest <= limit * limit)


def test_too_many_triangles_are_not_gathered() -> None:
    vertices, faces = meshes.sphere(3)
    tree = build_tree(vertices[faces])
    here = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    waiting = np.empty(DEPTH, np.int32)
    assert gather(tree, here, 0.5, DOUBT, no_triangles(), waiting) == 0
    assert gather(tree, here, 1.5, DOUBT, no_triangles(), waiting) == -1
