from __future__ import annotations

from typing import Any

import numba
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.arrays import FloatArray
from abi.compilation.helpers import declare_helpers
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.triangle_mesh import triangle_kernels
from abi.obstacles.triangle_mesh.bvh import Dipoles, TriangleTree, build_tree, dipoles
from abi.obstacles.triangle_mesh.repair import clean
from tests.abi import mesh_oracles, meshes
from tests.abi.meshes import Mesh

seeds = st.integers(0, 2**32 - 1)

BLOB = meshes.bumpy(4)
BALL = meshes.sphere(3)
NESTED = meshes.joined(BALL, meshes.sphere(2, 0.5))
HOLLOW = meshes.joined(BALL, meshes.inverted(meshes.sphere(2, 0.5)))
SLAB = (BALL[0] * (1, 1, 1e-4), BALL[1])
CLOSED = {
    "box": meshes.box((2, 1, 3)),
    "blob": BLOB,
    "nested": NESTED,
    "hollow": HOLLOW,
    "inverted": meshes.inverted(BALL),
    "apart": meshes.joined(meshes.bumpy(3), meshes.box(at=(30, 0, 0))),
    "slab": SLAB,
}
OPEN = {
    "soup": meshes.soup(500),
    "open-box": (meshes.box()[0], meshes.box()[1][:-2]),
    "half-blob": (BLOB[0], BLOB[1][: len(BLOB[1]) // 2]),
    "triangle": (np.eye(3), np.array([[0, 1, 2]], dtype=np.int32)),
}

declare_helpers()
_number: Any = numba.njit(triangle_kernels.winding_number)
_is_inside: Any = numba.njit(triangle_kernels.is_inside)
names = st.sampled_from(sorted({**CLOSED, **OPEN}))


def corners(mesh: Mesh) -> FloatArray:
    vertices, faces = mesh
    return vertices[faces]


def numbers(mesh: Mesh, points: FloatArray, opening: float) -> FloatArray:
    _, far = _far(mesh)
    stack = np.empty(128, np.int32)
    found = [_number(tuple(x), far, 0, opening, stack)[0] for x in points.tolist()]
    return np.array(found)


def inside(mesh: Mesh, points: FloatArray) -> np.ndarray:
    tree, far = _far(mesh)
    stack = np.empty(128, np.int32)
    return np.array([_is_inside(tree, far, tuple(x), stack) for x in points.tolist()])


def _far(mesh: Mesh) -> tuple[TriangleTree, Dipoles]:
    tree = build_tree(corners(mesh))
    return tree, dipoles(tree)


def somewhere(mesh: Mesh, rng: np.random.Generator, count: int) -> FloatArray:
    """Points in and around the bounding box."""
    low, high = mesh[0].min(axis=0), mesh[0].max(axis=0)
    return rng.uniform(low - 0.2 * (high - low), high + 0.2 * (high - low), (count, 3))


def beside(
    mesh: Mesh, rng: np.random.Generator, count: int, gap: float
) -> tuple[FloatArray, FloatArray]:
    """Points on triangles, many near sides and corners of them, and normals of length ``gap``."""
    triangles = corners(mesh)[rng.integers(0, len(mesh[1]), count)]
    weights = rng.dirichlet(np.ones(3), count) ** rng.choice([1.0, 4.0, 12.0], (count, 1))
    weights /= weights.sum(axis=1, keepdims=True)
    on = np.einsum("ij,ijk->ik", weights, triangles)
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return on, gap * normal / np.linalg.norm(normal, axis=1, keepdims=True)


@pytest.mark.slow
@settings(max_examples=10)
@given(names, seeds)
def test_the_numbers_are_the_sums_of_all_solid_angles(name: str, seed: int) -> None:
    mesh = {**CLOSED, **OPEN}[name]
    rng = np.random.default_rng(seed)
    points = somewhere(mesh, rng, 10)
    expected = mesh_oracles.winding_numbers(corners(mesh), points)
    # the oracle takes roots of what rounds to 0 where a triangle is seen as a line
    np.testing.assert_allclose(numbers(mesh, points, np.inf), expected, atol=1e-5)
    np.testing.assert_allclose(numbers(mesh, points, triangle_kernels.OPENING), expected, atol=0.06)
    finer = np.abs(numbers(mesh, points, 40.0) - expected).max()
    assert finer < 1e-3


@pytest.mark.slow
def test_a_far_group_is_one_dipole() -> None:
    """Also around open surfaces the error falls faster than the opening grows."""
    rng = np.random.default_rng(0)
    for mesh in (OPEN["half-blob"], OPEN["soup"], BLOB):
        points = somewhere(mesh, rng, 200)
        exact = numbers(mesh, points, np.inf)
        off = [np.abs(numbers(mesh, points, k) - exact).max() for k in (2.0, 4.0, 8.0, 16.0)]
        assert off[0] > 1e-5
        assert off[3] < off[0] / 16
        assert off[1] < off[0]


@pytest.mark.slow
@pytest.mark.parametrize("gap", [1e-10, 1e-8, 1e-5, 1e-3])
@pytest.mark.parametrize("name", ["box", "blob", "nested", "hollow", "inverted", "apart"])
def test_sides_are_right_next_to_the_surface(name: str, gap: float) -> None:
    mesh = CLOSED[name]
    rng = np.random.default_rng(7)
    on, outward = beside(mesh, rng, 200, gap * np.ptp(mesh[0], axis=0).max())
    triangles = corners(mesh)
    # next to an edge or a corner the way along a normal may leave by another triangle
    above, below = on + outward, on - outward
    sure = mesh_oracles.nearest(triangles, np.concatenate([above, below]), _distances)
    sure = (sure > 0.99 * np.linalg.norm(outward, axis=1).mean()).reshape(2, -1).all(axis=0)
    assert sure.mean() > 0.4
    above, below = above[sure], below[sure]
    exact = numbers(mesh, np.concatenate([above, below]), np.inf)
    np.testing.assert_allclose(exact, np.round(exact), atol=1e-4)
    top, bottom = exact[: len(above)], exact[len(above) :]
    np.testing.assert_allclose(bottom - top, 1, atol=1e-4)
    np.testing.assert_array_equal(inside(mesh, above), np.abs(np.round(top)) > 0.5)
    np.testing.assert_array_equal(inside(mesh, below), np.abs(np.round(bottom)) > 0.5)


def _distances(points: FloatArray, triangles: FloatArray) -> FloatArray:
    """Distance of each point to its triangle, a small convex problem over the corners."""
    x = points
    a, ab, ac = triangles[:, 0] - x, *(triangles[:, k] - triangles[:, 0] for k in (1, 2))
    d00, d01, d11 = (np.einsum("ij,ij->i", p, q) for p, q in ((ab, ab), (ab, ac), (ac, ac)))
    r0, r1 = -np.einsum("ij,ij->i", ab, a), -np.einsum("ij,ij->i", ac, a)
    u, v = np.stack([d11 * r0 - d01 * r1, d00 * r1 - d01 * r0]) / (d00 * d11 - d01**2)
    on = (u >= 0) & (v >= 0) & (u + v <= 1)
    normal = np.cross(ab, ac)
    height = np.abs(np.einsum("ij,ij->i", normal, a)) / np.linalg.norm(normal, axis=1)
    best = np.where(on, height, np.inf)
    for start, end in ((0, 1), (1, 2), (2, 0)):
        p, d = triangles[:, start] - x, triangles[:, end] - triangles[:, start]
        t = np.clip(-np.einsum("ij,ij->i", p, d) / np.einsum("ij,ij->i", d, d), 0, 1)
        best = np.minimum(best, np.linalg.norm(p + t[:, None] * d, axis=1))
    return best


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(CLOSED))
def test_numbers_round_to_the_sides(name: str) -> None:
    mesh = CLOSED[name]
    rng = np.random.default_rng(3)
    points = somewhere(mesh, rng, 400)
    exact = numbers(mesh, points, np.inf)
    np.testing.assert_allclose(exact, np.round(exact), atol=1e-6)
    np.testing.assert_array_equal(inside(mesh, points), np.abs(exact) > 0.5)
    radius = np.linalg.norm(points, axis=1)
    sure = (np.abs(radius - 1) > 0.02) & (np.abs(radius - 0.5) > 0.02)
    expected = {
        "nested": 1.0 * (radius < 1) + (radius < 0.5),
        "hollow": 1.0 * (radius < 1) - (radius < 0.5),
        "inverted": -1.0 * (radius < 1),
    }
    if name in expected:
        np.testing.assert_allclose(exact[sure], expected[name][sure], atol=1e-6)


@pytest.mark.slow
def test_a_number_that_is_not_whole_counts_as_inside() -> None:
    mesh = OPEN["half-blob"]
    points = somewhere(mesh, np.random.default_rng(5), 2000)
    exact = np.abs(numbers(mesh, points, np.inf))
    used = corners(mesh)
    low, high = used.min(axis=(0, 1)), used.max(axis=(0, 1))
    in_box = ((points >= low) & (points <= high)).all(axis=1)
    open_ = in_box & (exact > 0.15) & (exact < 0.45)
    assert open_.sum() > 20
    assert inside(mesh, points[open_]).all()


@pytest.mark.slow
@pytest.mark.parametrize("count", [100, 160])
def test_where_dipoles_are_too_coarse_triangles_decide(count: int) -> None:
    """The errors of many balls in one add up, with 160 of them even to about a whole number."""
    mesh = meshes.joined(*(meshes.sphere(2, 1 - k / count / 50) for k in range(count)))
    rng = np.random.default_rng(0)
    points = rng.normal(size=(100, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True) / rng.uniform(0.97, 1.1, (100, 1))
    exact = numbers(mesh, points, np.inf)
    coarse = numbers(mesh, points, triangle_kernels.OPENING)
    assert ((np.abs(coarse) > 0.5) != (np.abs(exact) > 0.5)).any()
    np.testing.assert_array_equal(inside(mesh, points), np.abs(exact) > 0.5)


def test_the_dipoles_hold_their_triangles() -> None:
    tree, far = _far(BLOB)
    total = np.linalg.norm(far.normals.reshape(-1, 3)[0])
    assert total < 1e-12  # a closed surface has none from far
    leaves = len(tree.leaves) - 1
    centres = far.centres.reshape(-1, 3)
    triangles = tree.corners.reshape(-1, 3, 3)
    for leaf in range(leaves):
        own = triangles[tree.leaves[leaf] : tree.leaves[leaf + 1]]
        normals = np.cross(own[:, 1] - own[:, 0], own[:, 2] - own[:, 0]) / 2
        node = leaves - 1 + leaf
        np.testing.assert_allclose(far.normals[3 * node : 3 * node + 3], normals.sum(axis=0))
        while True:
            assert np.linalg.norm(own - centres[node], axis=2).max() <= far.radii[node] + 1e-12
            if node == 0:
                break
            node = (node - 1) // 2


def test_a_shifted_and_scaled_surface_has_the_same_sides() -> None:
    rng = np.random.default_rng(1)
    points = somewhere(BLOB, rng, 300)
    expected = inside(BLOB, points)
    for scale in (1e-6, 1.0, 1e6):
        moved = (BLOB[0] * scale, BLOB[1])
        np.testing.assert_array_equal(inside(moved, points * scale), expected)
    away = np.array([1000.0, 0.0, 0.0])
    far = MeshShape.of(clean(BLOB[0] + away, BLOB[1]))
    np.testing.assert_array_equal(far.signed_distance(points + away) < 0, expected)
