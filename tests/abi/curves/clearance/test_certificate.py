from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from abi.arrays import FloatArray
from abi.curves.bspline import BSpline, clamped
from abi.curves.clearance.certificate import Certificate, Refutation, certify
from abi.curves.clearance.curve_clearance import ROUNDING, curve_clearance, proven_clearance
from abi.curves.quadratic import Quadratic
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import NO_OBSTACLES, Obstacles, ObstacleSet
from abi.obstacles.primitives import Box, Capsule, Cylinder, Sphere
from abi.obstacles.triangle_mesh.repair import clean
from abi.obstacles.triangle_mesh.surface import Surface
from benchmarks.certificates import campaign, true_clearance
from tests.abi import meshes
from tests.abi.bezier import polyline
from tests.abi.solids import support
from tests.kernel_forms import kernels_as
from tests.random_geometry import SIZE, random_curve, random_obstacle
from tests.thorough import examples

seeds = st.integers(0, 2**32 - 1)


def case(seed: int) -> tuple[BSpline | Quadratic, Obstacles]:
    random = np.random.default_rng(seed)
    curve = random_curve(random)
    return curve, tuple(random_obstacle(random) for _ in range(random.integers(1, 7)))


def mesh(surface: meshes.Mesh, **fields: Any) -> MeshShape:
    return MeshShape.of(clean(*surface), **fields)


def covered(result: Certificate, obstacle: int) -> list[tuple[float, float]]:
    """Pieces that an obstacle is separated from, joined where they touch."""
    rows = result.pieces[result.obstacle == obstacle]
    joined: list[tuple[float, float]] = []
    for start, end in sorted(map(tuple, rows.tolist())):
        if joined and start <= joined[-1][1]:
            joined[-1] = (joined[-1][0], max(joined[-1][1], end))
        else:
            joined.append((start, end))
    return joined


@pytest.mark.slow
def test_no_certified_curve_is_refuted_and_no_clear_one_rejected() -> None:
    found = campaign(800, seed=10**6)
    assert found.false_accepts == []
    assert found.false_rejects == []
    assert found.wrong_witnesses == []
    assert found.wrongly_refused == []
    # Otherwise the campaign would have shown nothing.
    assert found.certified > 160
    assert found.refuted > 160
    assert found.checked > 3


@settings(max_examples=examples(20))
@given(seeds)
def test_planes_separate_their_pieces_and_cover_the_curve(seed: int) -> None:
    curve, obstacles = case(seed)
    margin = 0.9 * true_clearance(curve, obstacles)
    assume(margin > 0)
    result = certify(curve, ObstacleSet(obstacles), margin)
    assert isinstance(result, Certificate)
    assert np.linalg.norm(result.directions, axis=1) == pytest.approx(1, abs=1e-14)
    for (start, end), k, normal in zip(
        result.pieces, result.obstacle, result.directions, strict=True
    ):
        level = (curve(np.linspace(start, end, 40)) @ normal).min()
        assert level - support(obstacles[k], normal[None])[0] > margin
    assert all(covered(result, k) == [(0.0, 1.0)] for k in range(len(obstacles)))


@settings(max_examples=examples(20))
@given(seeds)
def test_distances_from_far_away_are_those_to_the_support(seed: int) -> None:
    random = np.random.default_rng(seed)
    solid = random_obstacle(random)
    normals = random.normal(size=(20, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    reach = support(solid, normals) - normals @ np.array(solid.position)
    far = 1e7
    found = solid.signed_distance(np.array(solid.position) + far * normals)
    assert far - found == pytest.approx(reach, abs=1e-6)
    points = random.uniform(-SIZE, 2 * SIZE, (400, 3))
    inside = points[solid.signed_distance(points) <= 0]
    assert (inside @ normals.T <= support(solid, normals) + 1e-12).all()


@settings(max_examples=examples(20))
@given(seeds)
def test_bezier_pieces_are_the_curve(seed: int) -> None:
    curve, _ = case(seed)
    pieces = curve.bezier()
    share = np.linspace(0, 1, 7)
    for start, end, points in zip(
        pieces.breaks[:-1], pieces.breaks[1:], pieces.points, strict=True
    ):
        found = np.array([_casteljau(points, t) for t in share])
        expected = curve(start + share * (end - start))
        assert np.abs(found - expected).max() <= 1e-12 * SIZE


@settings(max_examples=examples(20))
@given(seeds)
def test_a_curve_is_as_near_to_its_chords_as_is_said(seed: int) -> None:
    pieces = case(seed)[0].bezier()
    count, fine = int(seed % 7) + 1, 12
    ends, away = pieces.chords(count)
    largest = 0.0
    for points, corners in zip(pieces.points, ends, strict=True):
        for k in range(count):
            inside = np.arange(fine + 1) / fine
            curve = np.array([_casteljau(points, (k + part) / count) for part in inside])
            chord = corners[k] + inside[:, None] * (corners[k + 1] - corners[k])
            largest = max(largest, float(np.linalg.norm(curve - chord, axis=1).max()))
    assert largest <= away + 1e-12 * SIZE


def _casteljau(points: FloatArray, share: float) -> FloatArray:
    while len(points) > 1:
        points = (1 - share) * points[:-1] + share * points[1:]
    return np.asarray(points[0])


def test_quadratics_in_pieces_are_bezier_pieces() -> None:
    random = np.random.default_rng(0)
    breaks = np.array([0.0, 0.2, 0.55, 1.0])
    curve = Quadratic.from_control_points(random.uniform(0, 6, (5, 3)), breaks)
    pieces = curve.bezier()
    assert np.array_equal(pieces.breaks, breaks)
    for start, end, points in zip(breaks[:-1], breaks[1:], pieces.points, strict=True):
        inside = np.linspace(0.01, 0.99, 5)
        found = np.array([_casteljau(points, t) for t in inside])
        assert np.abs(found - curve(start + inside * (end - start))).max() <= 1e-13
    ball = (Sphere(radius=0.5, position=(9, 9, 9)),)
    assert isinstance(certify(curve, ObstacleSet(ball), 0.1), Certificate)


@pytest.mark.slow
@settings(max_examples=10)
@given(seeds, st.booleans())
def test_compiled_and_plain_agree(seed: int, solid: bool) -> None:
    curve, obstacles = case(seed)
    if not solid:
        obstacles = (mesh(meshes.sphere(2), position=(3, 3, 3)),)
    margin = max(0.0, 0.99 * true_clearance(curve, obstacles))
    with kernels_as(compiled=False):
        plain = certify(curve, ObstacleSet(obstacles), margin)
    with kernels_as(compiled=True):
        compiled = certify(curve, ObstacleSet(obstacles), margin)
    if isinstance(plain, Refutation):
        assert isinstance(compiled, Refutation)
        assert plain.decided == compiled.decided
        assert plain.parameter == compiled.parameter
        return
    assert isinstance(compiled, Certificate)
    assert np.array_equal(plain.pieces, compiled.pieces)
    assert np.array_equal(plain.obstacle, compiled.obstacle)
    assert np.allclose(plain.directions, compiled.directions, rtol=0, atol=1e-15)


@settings(max_examples=examples(20))
@given(seeds, st.sampled_from([1e-4, 1e-6]))
def test_a_polyline_is_decided_by_its_exact_distance(seed: int, part: float) -> None:
    random = np.random.default_rng(seed)
    points = random.uniform(0, SIZE, (random.integers(1, 6), 3))
    obstacles = tuple(random_obstacle(random) for _ in range(random.integers(1, 5)))
    exact = ObstacleSet(obstacles).polyline_clearance(points)
    if exact > 0:
        assert isinstance(
            certify(polyline(points), ObstacleSet(obstacles), exact * (1 - part)), Certificate
        )
        refuted = certify(polyline(points), ObstacleSet(obstacles), exact * (1 + part))
        assert isinstance(refuted, Refutation)
    else:
        assert isinstance(certify(polyline(points), ObstacleSet(obstacles), 0.0), Refutation)


def test_a_far_obstacle_takes_one_plane() -> None:
    curve = clamped(np.random.default_rng(0).uniform(0, 1, (200, 3)), 3)
    far = tuple(Sphere(radius=1, position=(9.0, k, 0.0)) for k in range(4))
    result = certify(curve, ObstacleSet(far), 1.0)
    assert isinstance(result, Certificate)
    assert result.pieces.tolist() == [[0, 1]] * 4


def test_without_obstacles_any_curve_is_certified() -> None:
    curve = clamped(np.eye(3), 2)
    result = certify(curve, NO_OBSTACLES, 0.3)
    assert isinstance(result, Certificate)
    assert result.margin == math.inf
    assert len(result.pieces) == 0
    found = proven_clearance(curve, NO_OBSTACLES, 0.3)
    assert found.certified
    assert found.distance == math.inf


def test_a_witness_names_the_obstacle_and_the_place() -> None:
    curve = clamped(np.array([[-3.0, 1.5, 0], [3.0, 1.5, 0]]), 1)
    obstacles = (Sphere(radius=1, position=(0, -9, 0)), Sphere(radius=1))
    assert isinstance(certify(curve, ObstacleSet(obstacles), 0.499999), Certificate)
    result = certify(curve, ObstacleSet(obstacles), 0.6)
    assert isinstance(result, Refutation)
    assert result.decided
    assert result.obstacle == 1
    there = obstacles[1].signed_distance(curve(np.array([result.parameter])))[0]
    assert result.distance == pytest.approx(there, abs=1e-12)
    assert there < 0.6


@pytest.mark.parametrize(
    "solid",
    [
        Box(size=(1, 2, 3), position=(0, 0, 0), wxyz=(0.8, 0.1, 0.5, 0.2)),
        Sphere(radius=1),
        Cylinder(radius=1, height=1, wxyz=(0.3, 0.9, 0.2, 0.1)),
        Capsule(radius=0.5, height=2, wxyz=(0.3, 0.9, 0.2, 0.1)),
    ],
    ids=lambda solid: str(solid.shape),
)
def test_a_negative_margin_proves_how_deep_a_curve_goes(solid: Box) -> None:
    for seed in range(20):
        points = np.random.default_rng(seed).uniform([-0.5, -0.8, -0.8], [1.1, 0.8, 0.8], (5, 3))
        curve = clamped(points, 3)
        deepest = true_clearance(curve, (solid,))
        if deepest >= 0:
            continue
        assert isinstance(certify(curve, ObstacleSet((solid,)), deepest - 1e-3), Certificate)
        assert isinstance(certify(curve, ObstacleSet((solid,)), deepest + 1e-6), Refutation)


def test_a_curve_that_stays_at_one_point_is_decided() -> None:
    point = clamped(np.full((5, 3), 2.0), 3)
    ball = (Sphere(radius=1),)
    distance = math.sqrt(12) - 1
    assert isinstance(certify(point, ObstacleSet(ball), distance - 1e-9), Certificate)
    assert isinstance(certify(point, ObstacleSet(ball), distance + 1e-9), Refutation)


@settings(max_examples=40)
@given(seeds, st.sampled_from([0.0, 0.05, 0.5]), st.sampled_from([1e-3, 1e-6]))
def test_proven_distance_is_as_large_as_measured(
    seed: int, required: float, tolerance: float
) -> None:
    curve, obstacles = case(seed)
    found = proven_clearance(curve, ObstacleSet(obstacles), required, tolerance)
    measured = curve_clearance(curve, ObstacleSet(obstacles), required, tolerance)
    clearance = true_clearance(curve, obstacles)
    assert found.violations == measured.violations
    if clearance < -tolerance:
        assert not found.certified
        assert found.distance == measured.distance
    if clearance > 2 * tolerance:
        assert found.certified
    if found.certificate is not None:
        assert found.distance == found.certificate.margin
        assert clearance - 2 * tolerance <= found.distance <= clearance + 1e-12
    assert found.keeps(required) == (found.certified and found.distance >= required - ROUNDING)


def test_a_curve_may_touch_a_solid_when_no_clearance_is_asked_for() -> None:
    line = clamped(np.array([[0.0, 0, 1], [0, 0, 3]]), 1)
    assert proven_clearance(line, ObstacleSet((Box(size=(2, 2, 2)),)), 0.0).keeps(0.0)
    assert not proven_clearance(line, ObstacleSet((Box(size=(2, 2, 2)),)), 1e-6).keeps(1e-6)
    through = clamped(np.array([[0.0, 0, -1], [0, 0, 1]]), 1)
    assert not proven_clearance(through, ObstacleSet((Box(size=(2, 2, 2e-9)),)), 0.0).certified


def test_a_mesh_box_is_decided_like_the_box() -> None:
    box = Box(size=(1, 2, 1.5), position=(3, 3, 3), wxyz=(0.8, -0.3, 0.4, 0.2))
    like = mesh(meshes.box((1, 2, 1.5)), position=(3, 3, 3), wxyz=(0.8, -0.3, 0.4, 0.2))
    certified = 0
    for seed in range(150):
        curve, _ = case(seed)
        clearance = true_clearance(curve, (box,))
        for part in (1 - 1e-5, 1 + 1e-5):
            margin = max(clearance * part, 0.0)
            results = [certify(curve, ObstacleSet((one,)), margin) for one in (box, like)]
            kinds = {isinstance(result, Certificate) for result in results}
            assert kinds == {clearance > margin}
            certified += clearance > margin
    assert certified >= 40


@pytest.mark.slow
@settings(max_examples=12)
@given(seeds)
def test_among_many_meshes_a_curve_is_decided_as_by_each_alone(seed: int) -> None:
    random = np.random.default_rng(seed)
    curve, _ = case(seed)
    ball = clean(*meshes.sphere(1))
    crowd = tuple(
        MeshShape.of(
            ball,
            position=tuple(random.uniform(-SIZE, 2 * SIZE, 3).tolist()),
            scale=float(random.uniform(0.01, 0.15) * SIZE),
        )
        for _ in range(24)
    )
    alone = min(true_clearance(curve, (one,)) for one in crowd)
    margin = max(alone * float(random.choice([0.3, 1 - 1e-5, 1 + 1e-4])), 0.0)
    result = certify(curve, ObstacleSet(crowd), margin)
    assert isinstance(result, Certificate) == (alone > margin)
    if isinstance(result, Refutation):
        assert true_clearance(curve, (crowd[result.obstacle],)) <= margin + 1e-9
        return
    times = np.linspace(0, 1, 33)
    for number, one in enumerate(crowd):
        rows = result.obstacle == number
        starts, ends = result.pieces[rows].T
        normals = result.directions[rows]
        towards = np.einsum("tvx,nx->tvn", one.triangles(), normals).max(axis=1)
        gaps = (curve(times) @ normals.T)[:, None] - towards
        covers = (starts <= times[:, None]) & (times[:, None] <= ends)
        assert (np.where(covers[:, None], gaps, -np.inf).max(axis=2) > margin).all()


@pytest.mark.slow
def test_a_scaled_mesh_of_many_triangles_is_certified_up_to_its_distance() -> None:
    vertices, faces = meshes.bumpy(4)
    blob = MeshShape.of(Surface(vertices, faces, True), position=(3, 3, 3), scale=0.7)
    certified = 0
    for seed in range(60):
        curve, _ = case(seed)
        clearance = true_clearance(curve, (blob,))
        if clearance > 0:
            assert isinstance(
                certify(curve, ObstacleSet((blob,)), clearance * (1 - 1e-4)), Certificate
            )
            certified += 1
        refuted = certify(curve, ObstacleSet((blob,)), max(clearance, 0) * (1 + 1e-4) + 1e-6)
        assert isinstance(refuted, Refutation)
    assert certified > 10


def test_inside_a_closed_mesh_is_not_clear_but_beyond_an_open_one_is() -> None:
    line = clamped(np.array([[-0.2, 0, 0], [0.2, 0, 0]]), 1)
    vertices, faces = meshes.sphere(2)
    ball = mesh((vertices, faces))
    refuted = certify(line, ObstacleSet((ball,)), 0.0)
    assert isinstance(refuted, Refutation)
    assert refuted.decided
    assert refuted.distance < 0
    bowl = mesh((vertices, faces[1:]))
    assert not bowl.closed
    assert isinstance(certify(line, ObstacleSet((bowl,)), 0.5), Certificate)
    out = clamped(np.array([[-0.2, 0, 0], [2.0, 0.1, 0.2]]), 1)
    assert isinstance(certify(out, ObstacleSet((bowl,)), 0.0), Refutation)


def test_a_mesh_needs_a_margin_that_is_not_negative() -> None:
    line = clamped(np.array([[9.0, 0, 0], [9, 9, 0]]), 1)
    assert isinstance(certify(line, ObstacleSet((mesh(meshes.box()),)), -1e-9), Refutation)
    assert isinstance(certify(line, ObstacleSet((mesh(meshes.box()),)), 0.0), Certificate)


@pytest.mark.slow
def test_a_soup_is_kept_clear_of() -> None:
    soup = mesh(meshes.soup(400, seed=3, size=0.3), position=(3, 3, 3), scale=3.0)
    certified = 0
    for seed in range(120):
        random = np.random.default_rng(seed)
        start = random.uniform(0, SIZE, 3)
        curve = clamped(start + random.uniform(-0.4, 0.4, (4, 3)), 3)
        distance = np.abs(ObstacleSet((soup,)).nearest(curve(np.linspace(0, 1, 3001)))[0]).min()
        result = certify(curve, ObstacleSet((soup,)), 0.02)
        if isinstance(result, Certificate):
            certified += 1
            assert distance > 0.02
        else:
            assert distance < 0.02 + 1e-3
    assert 10 < certified < 110


def test_results_cannot_change() -> None:
    result = certify(
        clamped(np.eye(3), 2), ObstacleSet((Sphere(radius=0.1, position=(5, 5, 5)),)), 0.1
    )
    assert isinstance(result, Certificate)
    arrays = (result.pieces, result.obstacle, result.directions)
    assert not any(array.flags.writeable for array in arrays)
