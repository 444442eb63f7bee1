from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from abi.arrays import FloatArray
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.triangle_mesh.repair import clean
from abi.obstacles.triangle_mesh.signed_distance import error_of_distances
from abi.obstacles.triangle_mesh.surface import Surface
from tests.abi import mesh_oracles, meshes
from tests.abi.meshes import Mesh

Vector = list[int]

seeds = st.integers(0, 2**32 - 1)
MESHES = {
    "box": meshes.box((2, 1, 3)),
    "blob": meshes.bumpy(3),
    "soup": meshes.soup(100),
    "tiny": (meshes.bumpy(2)[0] * 1e-9, meshes.bumpy(2)[1]),
    "huge": (meshes.bumpy(2)[0] * 1e9, meshes.bumpy(2)[1]),
    "triangle": (np.eye(3), np.array([[0, 1, 2]], dtype=np.int32)),
}


def minus(a: Vector, b: Vector) -> Vector:
    return [x - y for x, y in zip(a, b, strict=True)]


def dot(a: Vector, b: Vector) -> int:
    return sum(x * y for x, y in zip(a, b, strict=True))


def cross(a: Vector, b: Vector) -> Vector:
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


def exactly(point: FloatArray, triangle: FloatArray) -> float:
    """Distance of a point to a triangle, in whole multiples of a power of two up to the root."""
    rows = [[v.as_integer_ratio() for v in row] for row in [point.tolist(), *triangle.tolist()]]
    unit = max(denominator for row in rows for _, denominator in row)
    x, *corners = ([v * (unit // denominator) for v, denominator in row] for row in rows)
    sides = [(corners[k - 1], minus(corners[k], corners[k - 1])) for k in range(3)]
    normal = cross(sides[1][1], sides[2][1])
    if any(normal) and all(dot(cross(d, minus(x, a)), normal) >= 0 for a, d in sides):
        height = dot(minus(x, corners[0]), normal)
        return math.sqrt(Fraction(height**2, unit**2 * dot(normal, normal)))
    squares = []
    for a, d in sides:
        way, length = minus(x, a), dot(d, d)
        along = min(max(dot(way, d), 0), length)
        square = dot(way, way) * length - 2 * along * dot(way, d) + along**2
        squares.append(Fraction(square, unit**2 * length))
    return math.sqrt(min(squares))


def exact_each(points: FloatArray, triangles: FloatArray) -> list[float]:
    return [exactly(x, triangle) for x, triangle in zip(points, triangles, strict=True)]


def errors_at(mesh: Mesh, distances: FloatArray) -> FloatArray:
    """Bounds of the errors of distances."""
    vertices, faces = mesh
    constant, slope = error_of_distances(vertices[faces] - vertices.mean(axis=0))
    return np.asarray(constant + slope * distances)


def opened(mesh: Mesh) -> MeshShape:
    """A mesh as a surface without an inside, as it stands."""
    return MeshShape.of(Surface(*mesh, closed=False))


@pytest.mark.slow
@settings(max_examples=8)
@given(st.sampled_from(sorted(MESHES)), seeds)
def test_distances_are_those_of_rational_numbers(name: str, seed: int) -> None:
    mesh = vertices, faces = MESHES[name]
    rng = np.random.default_rng(seed)
    low, size = vertices.min(axis=0), np.ptp(vertices, axis=0)
    on = vertices[faces[rng.integers(len(faces), size=4)]].mean(axis=1)
    points = np.concatenate([low + rng.uniform(-0.3, 1.3, (4, 3)) * size, on, vertices[:1]])
    found, gradients = opened(mesh).signed_distance_gradient(points)
    expected = mesh_oracles.nearest(vertices[faces], points, exact_each)
    errors = errors_at(mesh, expected)
    assert errors.max() < 1e-11 * size.max()
    # exact or less
    assert (found <= expected * (1 + 1e-14) + 1e-16 * size.max()).all()
    assert (found >= expected - 3 * errors).all()
    np.testing.assert_allclose(np.linalg.norm(gradients, axis=1), 1, rtol=1e-6)
    feet = points - expected[:, None] * gradients
    assert mesh_oracles.nearest(vertices[faces], feet, exact_each).max() <= 1e-9 * size.max()


@pytest.mark.slow
@settings(max_examples=48)
@given(st.floats(-17, 0), st.sampled_from(["needle", "cap", "lattice"]), seeds)
def test_no_triangle_is_too_thin(power: float, kind: str, seed: int) -> None:
    """The area of some is lost to rounding."""
    rng = np.random.default_rng(seed)
    triangle = rng.uniform(-1, 1, (3, 3))
    shift = 10.0**power * rng.normal(size=3)
    if kind == "needle":
        triangle[2] = triangle[0] + rng.random() * (triangle[1] - triangle[0]) + shift
    elif kind == "cap":
        triangle[2] = triangle[0] + shift
    else:
        triangle[:2] = np.round(4 * triangle[:2]) / 4
        triangle[2] = triangle[:2].mean(axis=0)
        triangle[2, rng.integers(3)] += 10.0**power
    triangle = rng.permutation(triangle)
    a, b, c = triangle
    assume(np.linalg.norm(np.cross(b - a, c - b)) and (a != b).any() and (c != a).any())
    near = 0.3 * a + 0.7 * b + 10.0 ** rng.uniform(-14, -1) * rng.normal(size=3)
    far = 10.0 ** rng.uniform(0, 3) * rng.normal(size=3)
    points = np.stack([rng.uniform(-1.5, 1.5, 3), near, far, triangle[rng.integers(3)]])
    mesh = triangle, np.array([[0, 1, 2]], dtype=np.int32)
    found = opened(mesh).signed_distance(points)
    expected = np.array([exactly(x, triangle) for x in points])
    errors = errors_at(mesh, expected)
    assert (errors < 1e-7 * (1 + expected)).all()
    assert (found <= expected * (1 + 1e-14) + 1e-15).all()
    assert (found >= expected - 3 * errors).all()


@pytest.mark.slow
@settings(max_examples=16)
@given(st.sampled_from(sorted(MESHES)), seeds)
def test_distances_are_those_of_another_library(name: str, seed: int) -> None:
    mesh = vertices, _ = MESHES[name]
    size = float(np.ptp(vertices, axis=0).max())
    rng = np.random.default_rng(seed)
    points = vertices.mean(axis=0) + rng.uniform(-1, 1, (40, 3)) * size
    expected = size * mesh_oracles.distances((vertices / size, mesh[1]), points / size)
    np.testing.assert_allclose(opened(mesh).signed_distance(points), expected, atol=1e-10 * size)


@pytest.mark.slow
@settings(max_examples=10)
@given(st.floats(-17, -2), seeds)
def test_slivers_shorten_a_distance_but_never_lengthen_it(power: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    corners = rng.uniform(-1, 1, (8, 3, 3))
    corners[:, 2] = corners[:, 0] + 10.0**power * rng.normal(size=(8, 3))
    faces = np.arange(24, dtype=np.int32).reshape(8, 3)
    assume(np.linalg.norm(np.cross(*np.diff(corners, axis=1).transpose(1, 0, 2)), axis=1).all())
    surface = clean(corners.reshape(-1, 3), faces)
    points = np.concatenate([rng.uniform(-1.5, 1.5, (6, 3)), corners[:2, 0]])
    found = MeshShape.of(surface).signed_distance(points)
    expected = mesh_oracles.nearest(surface.vertices[surface.faces], points, exact_each)
    assert (found <= expected + 1e-14).all()
    assert (found >= expected - 1e-6).all()


@pytest.mark.parametrize("mesh", [meshes.sphere(4), meshes.knot(4_000), meshes.soup(2_000)])
def test_a_long_segment_is_as_near_as_the_nearest_of_its_parts(mesh: Mesh) -> None:
    shape = MeshShape.of(clean(*mesh))
    rng = np.random.default_rng(5)
    p, q = rng.uniform(-3, 3, (2, 200, 3))
    outside = ~shape.blocks(p, q, np.zeros(200))
    p, q = p[outside], q[outside]
    share = np.linspace(0, 1, 41)[:, None, None]
    places = p + share * (q - p)
    parts = shape.segment_distance(places[:-1].reshape(-1, 3), places[1:].reshape(-1, 3))
    nearest = parts.reshape(40, -1).min(axis=0)
    assert len(p) > 20
    assert np.allclose(shape.segment_distance(p, q), nearest, rtol=0, atol=1e-9)
    # a segment is nearer than a margin where its nearest part is
    assert shape.blocks(p, q, nearest + 1e-6).all()
    assert not shape.blocks(p, q, nearest - 1e-6).any()


@pytest.mark.slow
@settings(max_examples=8)
@given(st.sampled_from(["ball", "knot", "soup"]), seeds)
def test_an_answer_does_not_depend_on_what_was_asked_before(name: str, seed: int) -> None:
    mesh = {"ball": meshes.sphere(3), "knot": meshes.knot(800), "soup": meshes.soup(200)}[name]
    shape = MeshShape.of(clean(*mesh))
    rng = np.random.default_rng(seed)
    p = rng.uniform(-1.5, 1.5, (80, 3))
    q = p + rng.normal(0, 0.3, (80, 3))
    # margins about as large as the distances, so that both answers come, and change
    away = shape.segment_distance(p, q)
    margins = np.maximum(away + rng.normal(0, 0.02, 80), 0)
    blocked = shape.blocks(p, q, margins)
    assert blocked.any()
    assert not blocked.all()
    # of a set the wall that shut the last leg is tried first
    for order in (rng.permutation(80), np.argsort(p[:, 0])):
        assert (shape.blocks(p[order], q[order], margins[order]) == blocked[order]).all()
    alone = [shape.blocks(p[[i]], q[[i]], margins[[i]])[0] for i in range(80)]
    assert (blocked == alone).all()
    # with a distance that is enough: that one, or the same as without
    most = away + rng.normal(0, 0.05, 80)
    found = shape.segment_distance(p, q, most)
    assert np.allclose(found, np.minimum(away, most), rtol=0, atol=1e-12)
