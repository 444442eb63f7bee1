from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.arrays import FloatArray
from abi.curves import curve as curves
from abi.curves.bspline import BSpline, clamped
from abi.curves.fit import proven_fit
from abi.curves.quadratic import Quadratic, least_squares
from abi.explain.paper import printed
from abi.obstacles.obstacle_set import NO_OBSTACLES, ObstacleSet
from abi.obstacles.primitives import Box, Sphere
from tests.thorough import examples


@st.composite
def splines(draw: st.DrawFn) -> BSpline:
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    degree = draw(st.integers(1, 5))
    points = rng.uniform(-1, 1, (draw(st.integers(degree + 1, 12)), 3))
    return clamped(points * 10.0 ** draw(st.floats(-3, 3)), degree)


def fitted(spline: BSpline) -> Quadratic:
    return least_squares(spline, curves.arc_length(spline))


def by_arc_length(spline: BSpline, t: FloatArray) -> FloatArray:
    arc = curves.arc_length(spline)
    return spline(arc.parameter(t * arc.length))


def size(spline: BSpline) -> float:
    return float(np.ptp(spline.control_points, axis=0).max())


@settings(max_examples=examples(20))
@given(splines())
def test_ends_are_those_of_the_curve(spline: BSpline) -> None:
    quadratic = fitted(spline)
    assert np.array_equal(quadratic(0.0), spline.control_points[0])
    tolerance = 1e-14 * np.abs(spline.control_points).max()
    assert quadratic(1.0) == pytest.approx(spline.control_points[-1], abs=20 * tolerance)


@settings(max_examples=40)
@given(splines())
def test_equals_numpy_least_squares_on_dense_samples(spline: BSpline) -> None:
    count = 20_000
    t = (np.arange(count) + 0.5) / count
    samples = by_arc_length(spline, t)
    first, last = spline([0.0, 1.0])
    above_line = samples - first - np.outer(t, last - first)
    bend = np.linalg.lstsq((t**2 - t)[:, None], above_line, rcond=None)[0][0]
    assert np.abs(fitted(spline).coefficients[0, 2] - bend).max() <= 1e-6 * size(spline)


@settings(max_examples=40)
@given(splines(), st.integers(0, 2**32 - 1))
def test_no_other_bend_is_nearer(spline: BSpline, seed: int) -> None:
    rng = np.random.default_rng(seed)
    quadratic = fitted(spline)
    c0, c1, c2 = quadratic.coefficients[0]
    count = 4000
    t = (np.arange(count) + 0.5) / count
    samples = by_arc_length(spline, t)
    error = np.sum((quadratic(t) - samples) ** 2) / count
    for scale in (1e-2, 1e-1, 1.0):
        move = rng.normal(size=3) * scale * size(spline)
        other = Quadratic.single(np.stack([c0, c1 - move, c2 + move]))
        assert np.sum((other(t) - samples) ** 2) / count >= error * (1 - 1e-6)


@settings(max_examples=40)
@given(splines())
def test_the_way_back_has_the_same_quadratic(spline: BSpline) -> None:
    back = clamped(spline.control_points[::-1], spline.degree)
    t = np.linspace(0, 1, 50)
    assert np.abs(fitted(back)(1 - t) - fitted(spline)(t)).max() <= 1e-10 * size(spline)


def test_a_straight_line_stays_straight_however_it_is_parametrised() -> None:
    share = np.array([0.0, 0.0, 0.01, 0.5, 0.9, 0.9, 1.0])
    spline = clamped(np.outer(share, [1.0, 2.0, -3.0]) + 5, 3)
    assert np.abs(fitted(spline).coefficients[0, 2]).max() < 1e-12


def test_a_curve_that_stays_gives_a_point() -> None:
    quadratic = fitted(clamped(np.ones((4, 3)), 2))
    assert np.array_equal(quadratic.coefficients, [[[1, 1, 1], [0, 0, 0], [0, 0, 0]]])


@settings(max_examples=examples(20))
@given(splines(), st.floats(0.01, 0.99))
def test_derivatives_are_differences(spline: BSpline, t: float) -> None:
    quadratic = fitted(spline)
    step = 1e-4
    for order in (1, 2, 3):
        ahead, behind = quadratic(t + step, order - 1), quadratic(t - step, order - 1)
        difference = (ahead - behind) / (2 * step)
        scale = 1e-9 * np.abs(quadratic.coefficients).max()
        assert quadratic(t, order) == pytest.approx(difference, abs=scale)


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_numbers_give_points_and_arrays_give_rows(order: int) -> None:
    quadratic = printed.QUADRATIC
    t = np.linspace(-0.5, 1.5, 9)
    rows = quadratic(t, order)
    assert rows.shape == (9, 3)
    assert quadratic([], order).shape == (0, 3)
    for row, one in zip(rows, t, strict=True):
        assert np.array_equal(quadratic(float(one), order), row)


def test_the_printed_one_keeps_what_dense_samples_keep() -> None:
    obstacles = (Box(size=(2.5, 2.5, 2.5), position=(3, 3, 3)), Sphere(radius=0.5))
    points = printed.QUADRATIC(np.linspace(0, 1, 20_001))
    seen = float(ObstacleSet(obstacles[:1]).nearest(points)[0].min())
    for required, holds in ((seen - 1e-4, True), (seen + 1e-4, False)):
        found = proven_fit(
            printed.QUADRATIC, printed.QUADRATIC.extent, ObstacleSet(obstacles[:1]), required
        )
        assert found.holds is holds
        assert found.clearance.distance == pytest.approx(seen, abs=2e-5)
    assert not proven_fit(
        printed.QUADRATIC, printed.QUADRATIC.extent, ObstacleSet(obstacles), 0.0
    ).holds


def test_a_fit_says_when_it_enters_an_obstacle() -> None:
    around = clamped(np.array([[0.0, 0, 0], [0, 6, 0], [0, 6, 0], [6, 6, 0]]), 1)
    found = fitted(around)
    free = proven_fit(found, found.extent, NO_OBSTACLES, 0.5)
    assert free.holds
    assert free.clearance.distance == np.inf
    centre = tuple(found(0.5).tolist())
    blocked = proven_fit(
        found, found.extent, ObstacleSet((Sphere(radius=0.3, position=centre),)), 0.5
    )
    assert not blocked.holds
    assert blocked.clearance.nearest == pytest.approx(-0.3, abs=1e-6)
