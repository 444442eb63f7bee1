"""Kernels against other algorithms, and compiled against plain."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import interpolate

from abi.arm_planning.paper_arm_model import paper_arm
from abi.arrays import FloatArray
from abi.curves import curve
from abi.curves.bspline import BSpline, clamped
from abi.curves.clearance.curve_clearance import Clearance, curve_clearance
from abi.obstacles.obstacle_set import Obstacles, ObstacleSet
from abi.robot.paper_arm import inverse_kinematics as ik
from abi.scene.arm_settings import ArmSettings
from tests.abi.shape_distances import gradient, segment_distance
from tests.kernel_forms import compiled, plain
from tests.random_geometry import random_obstacle

seeds = st.integers(0, 2**32 - 1)


def some_obstacles(random: np.random.Generator, least: int = 1) -> Obstacles:
    return tuple(random_obstacle(random) for _ in range(random.integers(least, 6)))


def some_spline(random: np.random.Generator) -> BSpline:
    degree = int(random.integers(1, 6))
    return clamped(random.uniform(0, 6, (degree + int(random.integers(1, 9)), 3)), degree)


@pytest.mark.slow
@settings(max_examples=24)
@given(seeds, st.integers(2, 6), st.booleans())
def test_polylines_are_as_near_as_their_nearest_segment(seed: int, size: int, snap: bool) -> None:
    random = np.random.default_rng(seed)
    obstacles = ObstacleSet(some_obstacles(random, 0))
    points = random.uniform(-1, 7, (7, size, 3))
    if snap:  # along faces, through centres, and of no length
        points = np.round(points)
        points[:, 0] = obstacles[0].position if obstacles else 0.0
        points[0] = points[0, :1]
    starts, ends = points[:, :-1].reshape(-1, 3), points[:, 1:].reshape(-1, 3)
    expected = np.full(7, np.inf)
    for obstacle in obstacles:
        legs = segment_distance(obstacle, starts, ends).reshape(7, -1)
        expected = np.minimum(expected, legs.min(axis=1))
    for found in (plain(lambda: obstacles.polyline_clearances(points)),
                  compiled(lambda: obstacles.polyline_clearances(points))):  # fmt: skip
        assert found == pytest.approx(expected, abs=1e-12)
    assert obstacles.polyline_clearance(points[0]) == pytest.approx(expected[0], abs=1e-12)


@pytest.mark.slow
@settings(max_examples=24)
@given(seeds)
def test_the_way_out_is_the_nearest_obstacles_gradient(seed: int) -> None:
    random = np.random.default_rng(seed)
    obstacles = ObstacleSet(some_obstacles(random))
    points = random.uniform(-1, 7, (50, 3))
    expected, whose = obstacles.nearest(points)
    slopes = np.array(
        [gradient(obstacles[k], point[None])[0] for k, point in zip(whose, points, strict=True)]
    )
    for away, out in (plain(lambda: obstacles.signed_distance_gradient(points)),
                      compiled(lambda: obstacles.signed_distance_gradient(points))):  # fmt: skip
        assert away == pytest.approx(expected, abs=1e-12)
        assert np.abs(out - slopes).max() <= 1e-9


def same(first: Clearance, second: Clearance) -> bool:
    return (
        first.distance == pytest.approx(second.distance, abs=1e-12)
        and first.nearest == pytest.approx(second.nearest, abs=1e-12)
        and len(first.violations) == len(second.violations)
    )


@settings(max_examples=30)
@given(seeds, st.sampled_from([1e-1, 1e-3, 1e-5]))
def test_a_measurement_is_the_same_compiled_and_plain(seed: int, tolerance: float) -> None:
    random = np.random.default_rng(seed)
    obstacles, spline = ObstacleSet(some_obstacles(random)), some_spline(random)
    asked = float(random.uniform(-0.5, 1))
    assert same(
        plain(lambda: curve_clearance(spline, obstacles, asked, tolerance)),
        compiled(lambda: curve_clearance(spline, obstacles, asked, tolerance)),
    )


@pytest.mark.slow
@settings(max_examples=12)
@given(seeds, st.integers(0, 4))
def test_a_spline_is_that_of_scipy(seed: int, order: int) -> None:
    spline = some_spline(np.random.default_rng(seed))
    other = interpolate.BSpline(spline.knots, spline.control_points, spline.degree)
    # out of order, and at the breaks
    u = np.random.default_rng(seed).permutation(np.append(np.linspace(0, 1, 41), spline.breaks))
    expected = other(u, nu=order) if order <= spline.degree else np.zeros((len(u), 3))
    scale = 1e-11 * (1 + np.abs(expected).max())
    weights = interpolate.BSpline.design_matrix(u, spline.knots, spline.degree).toarray()
    for run in (plain, compiled):
        assert np.abs(run(lambda: spline(u, order)) - expected).max() <= scale
        assert np.abs(run(lambda: spline.influence(u)) - weights).max() <= 1e-13


@settings(max_examples=40)
@given(seeds)
def test_bezier_points_are_the_same_compiled_and_plain(seed: int) -> None:
    first = plain(lambda: some_spline(np.random.default_rng(seed)).bezier())
    second = compiled(lambda: some_spline(np.random.default_rng(seed)).bezier())
    assert np.array_equal(first.breaks, second.breaks)
    assert np.abs(first.points - second.points).max() <= 1e-14 * first.size


@pytest.mark.slow
@settings(max_examples=12)
@given(seeds)
def test_arc_lengths_are_inverted_compiled_and_plain(seed: int) -> None:
    random = np.random.default_rng(seed)
    spline = some_spline(random)
    asked = random.uniform(0, 1, 60)
    lengths = []
    for run in (plain, compiled):
        arc = run(lambda: curve.arc_length(spline))
        found = run(lambda arc=arc: arc.parameter(asked * arc.length))  # type: ignore[misc]
        there = run(lambda arc=arc, found=found: arc.distance(found))  # type: ignore[misc]
        assert np.abs(there - asked * arc.length).max() <= 1e-12 * arc.length
        assert arc.passed == pytest.approx(arc.distance(arc.nodes), abs=1e-12 * arc.length)
        lengths.append(arc.length)
    assert lengths[0] == pytest.approx(lengths[1], rel=1e-13)


@settings(max_examples=30)
@given(seeds, st.sampled_from(["beside", "through", "along"]))
def test_joints_are_the_same_compiled_and_plain(seed: int, how: str) -> None:
    random = np.random.default_rng(seed)
    arm = paper_arm(ArmSettings())
    ends = random.uniform(-3, 3, (2, 3))
    if how == "through":
        ends[1, :2] = -ends[0, :2]
    if how == "along":
        ends[:, :2] = 0
    share = np.linspace(0, 1, 81)[:, None]
    points: FloatArray = arm.shoulder + ends[0] + share * (ends[1] - ends[0])
    tangents = np.repeat((ends[1:] - ends[:1]) / np.linalg.norm(ends[1] - ends[0]), 81, axis=0)
    first, second = (
        run(lambda: ik.solve(arm, points, np.zeros(81), "up", tangents))
        for run in (plain, compiled)
    )
    for one, other in zip(first, second, strict=True):
        assert one == pytest.approx(other, abs=1e-9)
