from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation
from trimesh import creation, triangles

from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import Obstacle, Obstacles, ObstacleSet
from abi.obstacles.pose import rotation
from abi.obstacles.primitives import Box, Capsule, Cylinder, Sphere
from tests.abi.shape_distances import segment_distance
from tests.abi.solids import world_from_body
from tests.thorough import examples

ADAPTER: TypeAdapter[Any] = TypeAdapter(Obstacle)
POSE = {"position": (0.4, -0.3, 0.2), "wxyz": (0.8, -0.3, 0.4, 0.2)}
SOLIDS: Obstacles = (
    Box(size=(1.0, 2.0, 0.6), **POSE),
    Sphere(radius=0.9, **POSE),
    Cylinder(radius=0.5, height=1.6, **POSE),
    Cylinder(radius=1.3, height=0.4, **POSE),
    Capsule(radius=0.4, height=1.2, **POSE),
)
every_solid = pytest.mark.parametrize("solid", SOLIDS, ids=lambda s: f"{s.shape}")

lengths = st.floats(0.01, 4)
triples = st.tuples(*[st.floats(-4, 4)] * 3)
quaternions = st.tuples(*[st.floats(-1, 1)] * 4).filter(any)
poses = st.fixed_dictionaries({"position": triples, "wxyz": quaternions})
solids = st.one_of(
    st.builds(lambda pose, size: Box(size=size, **pose), poses, st.tuples(*[lengths] * 3)),
    st.builds(lambda pose, r: Sphere(radius=r, **pose), poses, lengths),
    st.builds(lambda pose, r, h: Cylinder(radius=r, height=h, **pose), poses, lengths, lengths),
    st.builds(lambda pose, r, h: Capsule(radius=r, height=h, **pose), poses, lengths, lengths),
)
# Multiples of 1/2 hit faces, edges, axes and centres exactly.
lattice = st.tuples(*[st.integers(-6, 6).map(lambda k: k / 2)] * 3)
aligned = st.one_of(
    st.builds(
        lambda c, s: Box(size=s, position=c), lattice, st.sampled_from([(1, 1, 1), (1, 2, 3)])
    ),
    st.builds(lambda c: Sphere(radius=1.0, position=c), lattice),
    st.builds(lambda c: Cylinder(radius=1.0, height=2.0, position=c), lattice),
    st.builds(lambda c: Capsule(radius=0.5, height=2.0, position=c), lattice),
)
ends = st.one_of(triples, lattice)


def body(solid: Obstacle, points: FloatArray) -> FloatArray:
    """Body coordinates by scipy's rotations, not ours."""
    w, x, y, z = solid.wxyz
    return np.asarray(Rotation.from_quat([x, y, z, w]).inv().apply(points - solid.position))


def level(solid: Obstacle, points: FloatArray) -> FloatArray:
    """A function that is zero on the surface and negative inside; no distance elsewhere."""
    return level_in_body(solid, body(solid, points))


def level_in_body(solid: Obstacle, x: FloatArray) -> FloatArray:
    """``level`` of points in body coordinates."""
    if isinstance(solid, Box):
        return np.asarray((2 * np.abs(x) / solid.size).max(axis=1) - 1)
    if isinstance(solid, Sphere):
        return np.asarray((x**2).sum(axis=1) - solid.radius**2)
    if isinstance(solid, Cylinder):
        around = (x[:, :2] ** 2).sum(axis=1) / solid.radius**2
        return np.asarray(np.maximum(around, np.abs(2 * x[:, 2] / solid.height)) - 1)
    assert isinstance(solid, Capsule)
    beyond = np.maximum(np.abs(x[:, 2]) - solid.height / 2, 0)
    return np.asarray((x[:, :2] ** 2).sum(axis=1) + beyond**2 - solid.radius**2)


@cache
def surface(solid: Obstacle, n: int = 30_000) -> FloatArray:
    """Points of the surface, found by shooting rays from the centre at ``level``."""
    rng = np.random.default_rng(1)
    rays = rng.normal(size=(n, 3))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    directions = body(solid, solid.position + rays)
    near, far = np.zeros(n), np.full(n, 4.0)
    for _ in range(55):
        t = (near + far) / 2
        outside = level_in_body(solid, t[:, None] * directions) > 0
        near, far = np.where(outside, near, t), np.where(outside, t, far)
    return np.asarray(solid.position + near[:, None] * rays)


def gradient(solid: Obstacle, points: FloatArray) -> FloatArray:
    """Gradients (n, 3) of the signed distance."""
    return solid.signed_distance_gradient(points)[1]


def least_along(solid: Obstacle, p: FloatArray, q: FloatArray) -> FloatArray:
    """Least signed distance along segments: dense samples, then denser around the least."""
    low, high = np.zeros(len(p)), np.ones(len(p))
    rows = np.arange(len(p))
    for _ in range(11):
        t = np.linspace(low, high, 41, axis=1)
        points = p[:, None] + t[..., None] * (q - p)[:, None]
        d = solid.signed_distance(points.reshape(-1, 3)).reshape(t.shape)
        k = d.argmin(axis=1)
        low, high = t[rows, np.maximum(k - 1, 0)], t[rows, np.minimum(k + 1, 40)]
    return np.asarray(d.min(axis=1))


@pytest.mark.slow
@every_solid
def test_distance_is_the_distance_to_the_surface(solid: Obstacle) -> None:
    points = np.random.default_rng(2).uniform(-3, 3, (1500, 3))
    d = solid.signed_distance(points)
    assert ((d < 0) == (level(solid, points) < 0)).all()
    assert (d < 0).any()
    # The step of that length along the gradient ends on the surface …
    foot = points - d[:, None] * gradient(solid, points)
    np.testing.assert_allclose(level(solid, foot), 0, atol=1e-12)
    # … and no point of the surface is nearer.
    least, _ = cKDTree(surface(solid)).query(points)
    assert (least >= np.abs(d) - 1e-12).all()
    assert (least <= np.abs(d) + 0.1).all()


def test_box_agrees_with_its_triangles() -> None:
    solid = SOLIDS[0]
    assert isinstance(solid, Box)
    mesh = creation.box(extents=solid.size, transform=world_from_body(solid))
    points = np.random.default_rng(3).uniform(-2, 2, (800, 3))
    pairs = np.repeat(mesh.triangles[None], len(points), axis=0).reshape(-1, 3, 3)
    closest = triangles.closest_point(pairs, np.repeat(points, 12, axis=0))  # type: ignore[no-untyped-call]
    feet = closest.reshape(-1, 12, 3)
    least = np.linalg.norm(feet - points[:, None], axis=2).min(axis=1)
    np.testing.assert_allclose(np.abs(solid.signed_distance(points)), least, atol=1e-12)


@every_solid
def test_pose_agrees_with_body_coordinates(solid: Obstacle) -> None:
    points = np.random.default_rng(4).normal(size=(50, 3))
    turn = rotation(solid.wxyz)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(turn) > 0
    world = body(solid, points) @ turn.T + np.array(solid.position)
    np.testing.assert_allclose(world, points, atol=1e-13)


@pytest.mark.slow
@every_solid
def test_bounds_are_tight(solid: Obstacle) -> None:
    low, high = solid.bounds()
    points = surface(solid)
    assert (points >= low - 1e-12).all()
    assert (points <= high + 1e-12).all()
    # A wall at each bound touches the solid: a long segment in it, through the touching point.
    for axis, wall in [(a, b) for a in range(3) for b in (low, high)]:
        touching = points[np.abs(points[:, axis] - wall[axis]).argmin()].copy()
        touching[axis] = wall[axis]
        assert abs(solid.signed_distance(touching[None])[0]) < 0.02


@given(solids, st.lists(triples, min_size=2, max_size=8))
@settings(max_examples=examples(26))
def test_distance_is_1_lipschitz_and_convex(
    solid: Obstacle, places: list[tuple[float, float, float]]
) -> None:
    points = np.array(places)
    p, q = points[:-1], points[1:]
    at_p, at_q = solid.signed_distance(p), solid.signed_distance(q)
    assert (np.abs(at_p - at_q) <= np.linalg.norm(p - q, axis=1) + 1e-12).all()
    assert (solid.signed_distance(0.3 * p + 0.7 * q) <= 0.3 * at_p + 0.7 * at_q + 1e-12).all()


@pytest.mark.slow
@given(solids, quaternions, triples, st.lists(triples, min_size=2, max_size=6))
@settings(max_examples=20)
def test_a_rigid_motion_of_everything_changes_nothing(
    solid: Obstacle,
    turn: tuple[float, float, float, float],
    shift: tuple[float, float, float],
    places: list[tuple[float, float, float]],
) -> None:
    # Our normalisation first: scipy's squares of the smallest parts vanish.
    rotation = Rotation.from_quat(Sphere(radius=1, wxyz=turn).wxyz)
    x, y, z, w = (rotation * Rotation.from_quat(np.roll(solid.wxyz, -1))).as_quat()
    position = rotation.apply(solid.position) + shift
    moved = solid.model_copy(
        update={"position": tuple(position.tolist()), "wxyz": (w, x, y, z)},
    )
    points = np.array(places)
    there = rotation.apply(points) + shift
    np.testing.assert_allclose(
        moved.signed_distance(there), solid.signed_distance(points), atol=1e-11
    )
    np.testing.assert_allclose(
        segment_distance(moved, there[:-1], there[1:]),
        segment_distance(solid, points[:-1], points[1:]),
        atol=1e-11,
    )


@every_solid
def test_gradient_agrees_with_central_differences(solid: Obstacle) -> None:
    points = np.random.default_rng(5).uniform(-3, 3, (3000, 3))
    step = 1e-5
    differences = np.stack(
        [
            solid.signed_distance(points + step * e) - solid.signed_distance(points - step * e)
            for e in np.eye(3)
        ],
        axis=1,
    ) / (2 * step)
    # Where the gradient jumps between the stencil's points the quotient is shorter than one.
    smooth = np.abs(np.linalg.norm(differences, axis=1) - 1) < 1e-6
    assert smooth.mean() > 0.99
    np.testing.assert_allclose(gradient(solid, points)[smooth], differences[smooth], atol=1e-4)


@pytest.mark.slow
@given(aligned, ends, st.lists(ends, min_size=1, max_size=8))
@settings(max_examples=48)
def test_gradient_is_a_unit_subgradient_everywhere(
    solid: Obstacle,
    place: tuple[float, float, float],
    others: list[tuple[float, float, float]],
) -> None:
    p, x = np.array([place]), np.array(others)
    g = gradient(solid, p)
    assert abs(np.linalg.norm(g) - 1) < 1e-12
    assert (solid.signed_distance(x) >= solid.signed_distance(p) + (x - p) @ g[0] - 1e-12).all()


@pytest.mark.parametrize("offset", [0.0, 5e-324, 1e-300, 1e-170, -1e-170, 1e-20])
@pytest.mark.parametrize("solid", [s.model_copy(update={"position": (0, 0, 0)}) for s in SOLIDS])
def test_gradient_has_length_one_next_to_the_centre(solid: Obstacle, offset: float) -> None:
    points = np.array([[offset, 0, 0], [0, offset, 0], [offset, 0, offset], [0, 0, offset]])
    np.testing.assert_allclose(np.linalg.norm(gradient(solid, points), axis=1), 1, atol=1e-12)


@pytest.mark.slow
@every_solid
def test_segment_distance_is_the_least_distance_along_the_segment(solid: Obstacle) -> None:
    rng = np.random.default_rng(8)
    p = solid.position + rng.uniform(-1.2, 1.2, (2000, 3))
    q = solid.position + rng.uniform(-1.2, 1.2, (2000, 3)) * rng.choice([0.2, 1, 3], (2000, 1))
    found = segment_distance(solid, p, q)
    assert 200 < (found < 0).sum() < 2000
    np.testing.assert_allclose(found, least_along(solid, p, q), atol=1e-12)
    np.testing.assert_allclose(found, segment_distance(solid, q, p), atol=1e-12)


@pytest.mark.slow
@given(st.one_of(solids, aligned), st.lists(st.tuples(ends, ends), min_size=1, max_size=10))
@settings(max_examples=32)
def test_segment_distance_in_special_positions(
    solid: Obstacle, pairs: list[tuple[tuple[float, float, float], tuple[float, float, float]]]
) -> None:
    p, q = np.array(pairs).transpose(1, 0, 2)
    found = segment_distance(solid, p, q)
    np.testing.assert_allclose(found, least_along(solid, p, q), atol=1e-11)
    np.testing.assert_allclose(found, segment_distance(solid, q, p), atol=1e-11)


@given(solids, ends, st.floats(0, 1e-9))
@settings(max_examples=50)
def test_segment_of_no_length_is_a_point(
    solid: Obstacle, place: tuple[float, float, float], length: float
) -> None:
    p = np.array([place])
    at_p = solid.signed_distance(p)
    np.testing.assert_allclose(segment_distance(solid, p, p), at_p, atol=1e-14)
    np.testing.assert_allclose(
        segment_distance(solid, p, p + length), at_p, atol=2 * length + 1e-14
    )


@pytest.mark.slow
@given(solids, triples, triples, st.floats(0.05, 3))
@settings(max_examples=32)
def test_a_segment_is_as_near_as_its_nearer_part(
    solid: Obstacle,
    start: tuple[float, float, float],
    step: tuple[float, float, float],
    stretch: float,
) -> None:
    p, d = np.array([start]), np.array([step])
    parts = np.minimum(
        segment_distance(solid, p, p + stretch * d / 3),
        segment_distance(solid, p + stretch * d / 3, p + stretch * d),
    )
    np.testing.assert_allclose(segment_distance(solid, p, p + stretch * d), parts, atol=1e-11)


def test_segment_distance_in_closed_form() -> None:
    p = np.array([[-3.0, 0.5, 0.0], [-3.0, 0.2, 0.0], [-3.0, 2.0, 0.0], [2.0, 0.0, 0.0]])
    q = np.array([[3.0, 0.5, 0.0], [3.0, 0.2, 0.0], [3.0, 2.0, 0.0], [0.0, 2.0, 0.0]])
    root = math.sqrt(2)
    for solid, expected in [
        (Box(size=(2, 2, 2)), [-0.5, -0.8, 1, 0]),
        (Sphere(radius=1), [-0.5, -0.8, 1, root - 1]),
        (Cylinder(radius=1, height=4), [-0.5, -0.8, 1, root - 1]),
        (Cylinder(radius=1, height=0.2), [-0.1, -0.1, 1, root - 1]),
        (Capsule(radius=1, height=2), [-0.5, -0.8, 1, root - 1]),
    ]:
        np.testing.assert_allclose(segment_distance(solid, p, q), expected, atol=1e-14)


def test_segment_distance_keeps_its_digits_far_from_the_origin() -> None:
    far = Cylinder(radius=2.0, height=3.0, position=(9e5, -9e5, 9e5), wxyz=(1, 0, 0, 0))
    home = Cylinder(radius=2.0, height=3.0)
    rng = np.random.default_rng(6)
    p, q = rng.integers(-64, 64, (2, 500, 3)) / 16
    at = np.array(far.position)
    np.testing.assert_allclose(
        segment_distance(far, p + at, q + at), segment_distance(home, p, q), atol=1e-14
    )


@pytest.mark.slow
@given(
    st.lists(st.one_of(solids, aligned), max_size=4),
    st.lists(st.tuples(ends, ends), min_size=1, max_size=25),
    st.floats(-0.5, 1.5),
)
@settings(max_examples=32)
def test_blocked_segments_are_those_nearer_than_the_margin(
    obstacles: list[Obstacle],
    pairs: list[tuple[tuple[float, float, float], tuple[float, float, float]]],
    margin: float,
) -> None:
    p, q = np.array(pairs).transpose(1, 0, 2)
    blocked = ObstacleSet(tuple(obstacles)).blocked(p, q, margin)
    least = np.full(len(p), np.inf)
    for solid in obstacles:
        least = np.minimum(least, segment_distance(solid, p, q))
    decided = np.abs(least - margin) > 1e-11
    assert (blocked == (least < margin))[decided].all()


@pytest.mark.slow
@every_solid
def test_blocked_segments_with_a_margin_each(solid: Obstacle) -> None:
    rng = np.random.default_rng(7)
    p = rng.uniform(-3, 3, (20_000, 3))
    q = p + rng.normal(size=p.shape) * rng.choice([0, 0.1, 1, 5], (len(p), 1))
    margins = rng.uniform(-0.2, 1, len(p))
    blocked = ObstacleSet((solid,)).blocked(p, q, margins)
    np.testing.assert_array_equal(blocked, segment_distance(solid, p, q) < margins)
    assert 500 < blocked.sum() < 19_000
    one = ObstacleSet((solid,)).blocked(p, q, 0.25)
    np.testing.assert_array_equal(one, ObstacleSet((solid,)).blocked(p, q, np.full(len(p), 0.25)))


def test_a_segment_that_keeps_the_margin_exactly_is_free() -> None:
    p, q = np.array([[-5.0, 0.0, 2.0]]), np.array([[5.0, 0.0, 2.0]])
    for solid in (
        Box(size=(2, 2, 2)),
        Sphere(radius=1),
        Cylinder(radius=1, height=2),
        Capsule(radius=0.5, height=1),
    ):
        assert not ObstacleSet((solid,)).blocked(p, q, 1.0)[0]
        assert ObstacleSet((solid,)).blocked(p, q, 1.0 + 1e-9)[0]


@given(st.lists(solids, min_size=1, max_size=5), st.lists(triples, min_size=1, max_size=10))
@settings(max_examples=40)
def test_nearest_is_the_least_distance_and_its_owner(
    obstacles: list[Obstacle], places: list[tuple[float, float, float]]
) -> None:
    points = np.array(places)
    distance, index = ObstacleSet(tuple(obstacles)).nearest(points)
    for x, d, k in zip(points, distance, index, strict=True):
        of_each = [float(solid.signed_distance(x[None])[0]) for solid in obstacles]
        assert math.isclose(d, min(of_each), abs_tol=1e-13)
        assert math.isclose(d, of_each[k], abs_tol=1e-13)


def test_first_obstacle_wins_a_tie() -> None:
    twins = (Sphere(radius=1), Sphere(radius=1))
    assert ObstacleSet(twins).nearest(np.zeros((1, 3)))[1].tolist() == [0]


def test_nothing_is_near_or_blocked_without_obstacles() -> None:
    points = np.zeros((3, 3))
    distance, index = ObstacleSet().nearest(points)
    assert distance.tolist() == [np.inf] * 3
    assert index.tolist() == [-1] * 3
    assert not ObstacleSet().blocked(points, points, 1.0).any()


@every_solid
def test_no_points_give_no_distances(solid: Obstacle) -> None:
    none = np.empty((0, 3))
    assert solid.signed_distance(none).shape == (0,)
    assert gradient(solid, none).shape == (0, 3)
    assert segment_distance(solid, none, none).shape == (0,)
    assert ObstacleSet((solid,)).blocked(none, none, 1.0).shape == (0,)


@given(solids)
@settings(max_examples=50)
def test_a_solid_survives_saving_and_compares_by_value(solid: Obstacle) -> None:
    again = ADAPTER.validate_json(ADAPTER.dump_json(solid))
    assert again == solid
    assert hash(again) == hash(solid)
    assert again is not solid
    assert math.isclose(math.hypot(*solid.wxyz), 1, abs_tol=1e-14)


@given(quaternions, st.sampled_from([5e-324, 1e-300, 1e-3, 1.0, 1e3, 1.5e308]))
@settings(max_examples=examples(26))
def test_a_quaternion_of_any_length_is_the_same_rotation(
    wxyz: tuple[float, float, float, float], scale: float
) -> None:
    largest = max(map(abs, wxyz))
    whole = tuple(float(round(2 * part / largest)) / 2 for part in wxyz)
    plain = Sphere(radius=1, wxyz=whole)
    scaled = Sphere(radius=1, wxyz=tuple(2 * part * (scale / 2 or scale) for part in whole))
    np.testing.assert_allclose(scaled.wxyz, plain.wxyz, atol=1e-15)


def test_lists_and_whole_numbers_are_accepted() -> None:
    box = ADAPTER.validate_python({"shape": "box", "size": [1, 2, 3], "position": [0, 0, 1]})
    assert box == Box(size=(1.0, 2.0, 3.0), position=(0.0, 0.0, 1.0))
    assert {type(part) for part in box.size} == {float}
    assert type(Sphere(radius=np.float64(1.5)).radius) is float


@pytest.mark.parametrize(
    "given_",
    [
        {"shape": "cone", "radius": 1},
        {"radius": 1},
        {"shape": "sphere"},
        {"shape": "sphere", "radius": 0},
        {"shape": "sphere", "radius": -1},
        {"shape": "sphere", "radius": 1.1e6},
        {"shape": "sphere", "radius": True},
        {"shape": "sphere", "radius": "1"},
        {"shape": "sphere", "radius": math.nan},
        {"shape": "sphere", "radius": math.inf},
        {"shape": "sphere", "radius": 10**400},
        {"shape": "sphere", "radius": 1, "height": 1},
        {"shape": "box", "size": [1, 1]},
        {"shape": "box", "size": [1, 1, 0]},
        {"shape": "box", "size": 1},
        {"shape": "sphere", "radius": 1, "position": [0, 0]},
        {"shape": "sphere", "radius": 1, "position": [0, 0, 1.1e6]},
        {"shape": "sphere", "radius": 1, "position": [0, 0, -1.1e6]},
        {"shape": "sphere", "radius": 1, "position": [0, 0, math.nan]},
        {"shape": "sphere", "radius": 1, "position": [0, False, 0]},
        {"shape": "sphere", "radius": 1, "position": "012"},
        {"shape": "sphere", "radius": 1, "wxyz": [0, 0, 0, 0]},
        {"shape": "sphere", "radius": 1, "wxyz": [0, 0, 0, -0.0]},
        {"shape": "sphere", "radius": 1, "wxyz": [1, 0, 0]},
        {"shape": "sphere", "radius": 1, "wxyz": [1, 0, 0, math.inf]},
    ],
    ids=str,
)
def test_what_is_no_solid_is_refused(given_: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        ADAPTER.validate_python(given_)


def test_a_solid_cannot_change() -> None:
    box = Box(size=(1, 1, 1))
    with pytest.raises(ValidationError):
        box.size = (2, 2, 2)  # type: ignore[misc]
    with pytest.raises(ValueError, match="read-only"):
        rotation(box.wxyz)[0, 0] = 2
