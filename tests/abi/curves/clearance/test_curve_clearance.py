from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline

from abi.arrays import FloatArray
from abi.curves.bezier import Bezier
from abi.curves.clearance.curve_clearance import curve_clearance
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import NO_OBSTACLES, Obstacle, Obstacles, ObstacleSet
from abi.obstacles.primitives import Box, Capsule, Cylinder, Sphere
from abi.obstacles.triangle_mesh.repair import clean
from tests.abi import meshes
from tests.abi.bezier import interpolated
from tests.abi.solids import world_from_body
from tests.thorough import examples


@dataclass(frozen=True, eq=False)
class Spline:
    """A clamped uniform B-spline through scipy, on an interval of its own."""

    spline: BSpline
    interval: tuple[float, float]

    def bezier(self) -> Bezier:
        return interpolated(self, np.unique(self.spline.t), int(self.spline.k))

    def __call__(self, parameter: ArrayLike, order: int = 0) -> FloatArray:
        return np.asarray(self.spline(np.clip(parameter, *self.interval), nu=order))


def spline(control: ArrayLike, degree: int, first: float = 0.0, last: float = 1.0) -> Spline:
    points = np.asarray(control, dtype=float)
    inner = np.linspace(first, last, len(points) - degree + 1)
    knots = np.r_[[first] * degree, inner, [last] * degree]
    return Spline(BSpline(knots, points, degree), (first, last))


OBSTACLES: Obstacles = (
    Box(size=(1, 2, 1.5), position=(1, 0.5, 0), wxyz=(0.8, -0.3, 0.4, 0.2)),
    Cylinder(radius=0.6, height=2, position=(-1.5, 1, 0.5), wxyz=(0.5, 0.5, 0.1, 0)),
    Sphere(radius=0.7, position=(0, -2, 0.5)),
    Capsule(radius=0.3, height=1.5, position=(2, 2, -1), wxyz=(0.7, 0, 0.7, 0)),
)


NOT_CONVEX = {
    "knot": clean(*meshes.knot(800)),
    "blob": clean(*meshes.bumpy(3)),
    "rooms": clean(*meshes.room(2)),
    "half": clean(meshes.bumpy(2)[0], meshes.bumpy(2)[1][:160]),
}


def dense(curve: Spline, obstacles: Obstacles, n: int = 20_001) -> tuple[FloatArray, FloatArray]:
    parameters = np.linspace(*curve.interval, n)
    return parameters, ObstacleSet(obstacles).nearest(curve(parameters))[0]


def least_within(curve: Spline, obstacles: Obstacles, start: float, end: float) -> float:
    """Least distance on a stretch: dense samples, then denser around the least."""
    for _ in range(4):
        parameters = np.linspace(start, end, 2001)
        distances = ObstacleSet(obstacles).nearest(curve(parameters))[0]
        k = int(distances.argmin())
        start, end = parameters[max(k - 1, 0)], parameters[min(k + 1, 2000)]
    return float(distances[k])


coordinates = st.tuples(*[st.floats(-3, 3)] * 3)
curves = st.builds(
    lambda control, degree, last: spline(control, min(degree, len(control) - 1), 0.0, last),
    st.lists(coordinates, min_size=2, max_size=10),
    st.integers(1, 5),
    st.sampled_from([1.0, 0.01, 300.0]),
)
some_obstacles = st.sets(st.sampled_from(OBSTACLES), min_size=1).map(tuple)


@pytest.mark.slow
@given(curves, some_obstacles, st.floats(-0.5, 1.5), st.sampled_from([1e-1, 1e-3, 1e-5]))
@settings(max_examples=24)
def test_no_dense_sample_contradicts_the_measurement(
    curve: Spline, obstacles: Obstacles, required: float, tolerance: float
) -> None:
    found = curve_clearance(curve, ObstacleSet(obstacles), required, tolerance)
    parameters, distances = dense(curve, obstacles)
    assert distances.min() >= found.distance - 1e-9
    assert 0 <= found.nearest - found.distance <= tolerance + 1e-12
    # The bound is reached: the nearest sample is a point of the curve and near its true minimum.
    assert distances.min() >= found.nearest - tolerance - 1e-9
    at_nearest, whose = ObstacleSet(obstacles).nearest(curve(np.array([found.at])))
    assert math.isclose(at_nearest[0], found.nearest, abs_tol=1e-9)
    of_owner = obstacles[found.obstacle].signed_distance(curve(np.array([found.at])))[0]
    assert math.isclose(of_owner, at_nearest[0], abs_tol=1e-9)
    assert whose[0] >= 0

    inside = np.zeros(len(parameters), dtype=bool)
    for start, end in found.violations:
        here = (parameters >= start) & (parameters <= end)
        inside |= here
        assert least_within(curve, obstacles, start, end) < required
    assert inside[distances < required - tolerance - 1e-9].all()
    assert (found.violations == ()) == (found.nearest >= required - 1e-9)


@pytest.mark.slow
@given(curves, some_obstacles, st.floats(-0.5, 1.5))
@settings(max_examples=24)
def test_violations_are_in_order_apart_and_no_wider_than_needed(
    curve: Spline, obstacles: Obstacles, required: float
) -> None:
    found = curve_clearance(curve, ObstacleSet(obstacles), required)
    edges = np.array(found.violations).reshape(-1, 2)
    assert (edges[:, 0] < edges[:, 1]).all()
    assert (edges[1:, 0] > edges[:-1, 1]).all()
    assert (edges >= curve.interval[0]).all()
    assert (edges <= curve.interval[1]).all()
    # 1/512 of the curve away from an interval's ends there is only violation, or a rise so short
    # that it fits between two samples, which are at most 1/128 apart.
    first, last = curve.interval
    pad = (last - first) / 512
    speed = np.linalg.norm(curve(np.linspace(first, last, 2001), order=1), axis=1).max()
    parameters, distances = dense(curve, obstacles)
    for start, end in edges:
        low = start + pad * (start > first)
        high = end - pad * (end < last)
        stretch = distances[(parameters > low) & (parameters < high)]
        assert (stretch < required + 2.1 * speed * pad).all()


@given(some_obstacles, coordinates, coordinates)
@settings(max_examples=examples(26))
def test_a_straight_line_agrees_with_the_segment(
    obstacles: Obstacles,
    start: tuple[float, float, float],
    end: tuple[float, float, float],
) -> None:
    ends = np.array([start, end])
    exact = ObstacleSet(obstacles).polyline_clearance(ends)
    for degree, control in [(1, ends), (3, np.linspace(start, end, 4))]:
        found = curve_clearance(spline(control, degree), ObstacleSet(obstacles), tolerance=1e-4)
        assert found.distance - 1e-9 <= exact <= found.nearest + 1e-9
        assert found.nearest - found.distance <= 1e-4 + 1e-12


@given(st.lists(coordinates, min_size=2, max_size=8), some_obstacles)
@settings(max_examples=examples(20))
def test_a_polyline_is_as_near_as_its_nearest_sample(
    vertices: list[tuple[float, float, float]], obstacles: Obstacles
) -> None:
    points = np.array(vertices)
    exact = ObstacleSet(obstacles).polyline_clearance(points)
    _, distances = dense(spline(points, 1), obstacles)
    step = np.linalg.norm(np.diff(points, axis=0), axis=1).max() * len(points) / 20_000
    assert exact <= distances.min() + 1e-12
    assert exact >= distances.min() - step - 1e-12


def test_a_polyline_of_one_point() -> None:
    ball = Sphere(radius=1)
    assert ObstacleSet((ball,)).polyline_clearance(np.array([[3.0, 0, 0]])) == 2
    assert ObstacleSet().polyline_clearance(np.array([[3.0, 0, 0]])) == math.inf


def test_a_parabola_over_a_ball_in_closed_form() -> None:
    # y = x² + 2 on [-2, 2] is nearest to the origin's ball at its vertex.
    parabola = spline([(-2, 6, 0), (0, -2, 0), (2, 6, 0)], 2)
    found = curve_clearance(parabola, ObstacleSet((Sphere(radius=1),)), 2.0, 1e-6)
    assert found.nearest == pytest.approx(1, abs=1e-6)
    assert found.distance == pytest.approx(1, abs=1e-6)
    assert found.at == pytest.approx(0.5, abs=1e-3)
    assert found.obstacle == 0
    # Distance 2 is crossed where x² + (x² + 2)² = 9: x² = (√45 - 5)/2 of the quadratic in x².
    x = math.sqrt((math.sqrt(45) - 5) / 2)
    ((start, end),) = found.violations
    assert start == pytest.approx(0.5 - x / 4, abs=1 / 400)
    assert end == pytest.approx(0.5 + x / 4, abs=1 / 400)


@given(curves, st.floats(0, 1), st.floats(1e-4, 1e-2))
@settings(max_examples=examples(20))
def test_a_ball_too_small_for_dense_samples_is_found(
    curve: Spline, where: float, radius: float
) -> None:
    first, last = curve.interval
    parameter = first + where * (last - first)
    centre = curve(np.array([parameter]))[0]
    balls = (Sphere(radius=radius, position=tuple(centre.tolist())),)
    found = curve_clearance(curve, ObstacleSet(balls), 0.0, radius / 10)
    assert found.distance <= -radius + 1e-9
    assert found.nearest <= -0.9 * radius + 1e-9
    assert found.obstacle == 0
    assert any(start <= parameter <= end for start, end in found.violations)


def test_the_obstacle_found_last_is_named() -> None:
    # The first ball is nearest at the first 65 samples, the second between two of them.
    line = spline([(0, 0, 0), (6.4, 0, 0)], 1)
    balls = (
        Sphere(radius=1, position=(3.2, 1.02, 0)),
        Sphere(radius=0.01, position=(1.05, 0, 0)),
    )
    found = curve_clearance(line, ObstacleSet(balls))
    assert found.obstacle == 1
    assert found.nearest == pytest.approx(-0.01, abs=1e-3)
    assert found.at == pytest.approx(1.05 / 6.4, abs=1e-3)


def test_a_path_that_starts_at_the_distance_asked_does_not_violate() -> None:
    ball: tuple[Obstacle, ...] = (Sphere(radius=1, position=(0.3, 0.1, 0.2)),)
    control = [(0.3, 0.1, 1.7), (0.3, 0.5, 2.5), (1, 2, 3), (3, 3, 3)]
    assert curve_clearance(spline(control, 3), ObstacleSet(ball), 0.5).violations == ()
    found = curve_clearance(spline(control, 3), ObstacleSet(ball), 0.5 + 1e-6)
    assert found.violations[0][0] == 0
    assert found.violations[0][1] < 0.05


def test_a_path_along_a_wall_at_the_distance_asked_does_not_violate() -> None:
    wall = (Box(size=(10, 10, 1), wxyz=(0.9, 0.3, 0, 0)),)
    pose = world_from_body(wall[0])[:3, :3]
    control = np.array([(-3, -2, 0.7), (0, 3, 0.7), (1, -3, 0.7), (2, 1, 0.7), (4, 2, 0.7)])
    found = curve_clearance(spline(control @ pose.T, 4), ObstacleSet(wall), 0.2, 1e-6)
    assert not found.violations
    assert found.distance == pytest.approx(0.2, abs=1e-9)


def test_a_curve_that_stands_still_is_measured() -> None:
    control = [(0, 0, 3)] * 4 + [(0, 0, 2)] * 4
    found = curve_clearance(spline(control, 3), ObstacleSet((Sphere(radius=1),)), 0.5, 1e-4)
    assert found.nearest == pytest.approx(1, abs=1e-12)
    point = curve_clearance(spline([(0, 0, 3)] * 5, 3), ObstacleSet((Sphere(radius=1),)), 2.5)
    assert point.distance == pytest.approx(2, abs=1e-12)
    assert point.violations == ((0.0, 1.0),)


def test_without_obstacles_the_distance_is_infinite() -> None:
    found = curve_clearance(spline([(0, 0, 0), (1, 0, 0)], 1, 2.0, 5.0), NO_OBSTACLES, 1.0)
    assert (found.distance, found.nearest, found.obstacle) == (math.inf, math.inf, -1)
    assert found.at == 2.0
    assert not found.violations


@pytest.mark.parametrize("tolerance", [1e-3, 0.0])
def test_a_curve_through_the_heart_of_an_obstacle_ends(tolerance: float) -> None:
    # The distance has a kink at its least, and the curve lies on the medial plane for a while.
    box = (Box(size=(2, 4, 2)),)
    found = curve_clearance(spline([(-3, 0, 0), (3, 0.1, 0)], 1), ObstacleSet(box), 0.1, tolerance)
    assert found.nearest == pytest.approx(-1, abs=1e-3)
    assert found.nearest - found.distance <= max(tolerance, 1e-9) + 1e-12
    ((start, end),) = found.violations
    assert start == pytest.approx(0.5 - 1.1 / 6, abs=1 / 400)
    assert end == pytest.approx(0.5 + 1.1 / 6, abs=1 / 400)


@pytest.mark.slow
@given(curves, st.floats(0.0, 1.5))
@settings(max_examples=16)
def test_where_a_mesh_is_too_near_is_told_as_finely_as_of_a_solid(
    curve: Spline, required: float
) -> None:
    size = (1.0, 2.0, 1.5)
    pose: Any = {"position": (1.0, 0.5, 0.0), "wxyz": (0.8, -0.3, 0.4, 0.2)}
    solid, mesh = (
        curve_clearance(curve, ObstacleSet((body,)), required)
        for body in (Box(size=size, **pose), MeshShape.of(clean(*meshes.box(size)), **pose))
    )
    first, last = curve.interval
    fine = (last - first) / 512

    assert mesh.nearest == pytest.approx(solid.nearest, abs=2e-3)
    parameters, distances = dense(curve, (Box(size=size, **pose),))
    speed = np.linalg.norm(curve(parameters, order=1), axis=1).max()
    for found in (solid, mesh):
        told = np.zeros(len(parameters), dtype=bool)
        for start, end in found.violations:
            told |= (parameters >= start) & (parameters <= end)
            inner = (parameters > start + fine * (start > first)) & (
                parameters < end - fine * (end < last)
            )
            # a rise so short that it fits between two samples is not told apart
            assert (distances[inner] < required + 2.1 * speed * fine).all()
        assert told[distances < required - 1e-3 - 1e-9].all()


@pytest.mark.slow
@given(
    curves,
    st.sampled_from(["knot", "blob", "rooms", "half"]),
    st.floats(0.3, 2.0),
    st.floats(-0.2, 1.0),
    st.sampled_from([1e-1, 1e-2, 1e-3]),
)
@settings(max_examples=24, deadline=None)
def test_no_dense_sample_contradicts_what_is_measured_of_meshes(
    curve: Spline, name: str, scale: float, required: float, tolerance: float
) -> None:
    surface = NOT_CONVEX[name]
    obstacles: Obstacles = (
        MeshShape.of(surface, scale=scale, position=(0.4, -0.3, 0.2), wxyz=(0.8, -0.3, 0.4, 0.2)),
        MeshShape.of(surface, scale=0.3, position=(2, 1, -1)),
    )
    found = curve_clearance(curve, ObstacleSet(obstacles), required, tolerance)
    parameters, distances = dense(curve, obstacles, 4001)
    assert distances.min() >= found.distance - 1e-9
    assert 0 <= found.nearest - found.distance <= tolerance + 1e-9
    there = np.asarray(curve(found.at))[None]
    assert obstacles[found.obstacle].signed_distance(there)[0] == pytest.approx(
        found.nearest, abs=1e-9
    )
    told = np.zeros(len(parameters), dtype=bool)
    for start, end in found.violations:
        told |= (parameters >= start) & (parameters <= end)
    assert told[distances < required - tolerance - 1e-9].all()


@pytest.mark.slow
@given(curves, st.integers(0, 2**32 - 1))
@settings(max_examples=8, deadline=None)
def test_meshes_among_solids_are_measured_as_the_solids_they_are(curve: Spline, seed: int) -> None:
    random = np.random.default_rng(seed)
    solids: list[Obstacle] = []
    mixed: list[Obstacle] = []
    for k in range(8):
        pose: Any = {
            "position": tuple(random.uniform(-3, 3, 3)),
            "wxyz": tuple(random.normal(size=4)),
        }
        size = tuple(random.uniform(0.1, 1, 3))
        solids.append(Box(size=size, **pose))
        is_mesh = k % 3 != 1
        mixed.append(MeshShape.of(clean(*meshes.box(size)), **pose) if is_mesh else solids[-1])
    expected = curve_clearance(curve, ObstacleSet(tuple(solids)), 0.3, 1e-4)
    found = curve_clearance(curve, ObstacleSet(tuple(mixed)), 0.3, 1e-4)
    assert found.nearest == pytest.approx(expected.nearest, abs=1e-4)
    assert found.distance <= found.nearest <= found.distance + 1e-4 + 1e-9
    there = np.asarray(curve(found.at))[None]
    assert float(mixed[found.obstacle].signed_distance(there)[0]) == pytest.approx(
        found.nearest, abs=1e-9
    )
    assert (not found.violations) == (not expected.violations)


def test_a_needle_between_two_samples_is_found_beside_what_is_far_nearer() -> None:
    needle = MeshShape.of(clean(*meshes.box((0.02, 1, 1))), position=(1.075, 0, 0))
    block = MeshShape.of(clean(*meshes.box((1, 1, 1))), position=(4, 0, 0))
    found = curve_clearance(spline([(0, 0, 0), (6.4, 0, 0)], 1), ObstacleSet((needle, block)))

    assert found.obstacle == 1
    assert found.nearest == pytest.approx(-0.5, abs=1e-3)
    (first, last), (start, end) = found.violations
    assert first <= 1.066 / 6.4 < 1.084 / 6.4 <= last <= first + 1 / 64
    assert start <= 3.501 / 6.4 < 4.499 / 6.4 <= end <= start + 1 / 6.4 + 1 / 64
