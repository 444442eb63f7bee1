from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.arrays import FloatArray
from abi.curves.bspline import BSpline, clamped
from tests.thorough import examples


@st.composite
def splines(draw: st.DrawFn) -> BSpline:
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    degree = draw(st.integers(1, 5))
    points = rng.uniform(-1, 1, (draw(st.integers(degree + 1, 12)), 3))
    return clamped(points * 10.0 ** draw(st.floats(-3, 3)), degree)


def basis(knots: FloatArray, k: int, degree: int, u: float) -> float:
    """Cox-de Boor recursion, an oracle; u below the last knot."""
    if degree == 0:
        return float(knots[k] <= u < knots[k + 1])
    value = 0.0
    rise, fall = knots[k + degree] - knots[k], knots[k + degree + 1] - knots[k + 1]
    if rise > 0:
        value += (u - knots[k]) / rise * basis(knots, k, degree - 1, u)
    if fall > 0:
        value += (knots[k + degree + 1] - u) / fall * basis(knots, k + 1, degree - 1, u)
    return value


@settings(max_examples=examples(20))
@given(splines(), st.floats(0, 1, exclude_max=True))
def test_point_is_the_sum_of_the_basis(spline: BSpline, u: float) -> None:
    count = len(spline.control_points)
    weights = [basis(spline.knots, k, spline.degree, u) for k in range(count)]
    assert sum(weights) == pytest.approx(1, rel=1e-12)
    scale = np.abs(spline.control_points).max()
    assert spline(u) == pytest.approx(weights @ spline.control_points, abs=1e-12 * scale)


@settings(max_examples=examples(33))
@given(splines(), st.integers(1, 5))
def test_derivatives_are_differences(spline: BSpline, order: int) -> None:
    step = 1e-5
    middles = (spline.breaks[:-1] + spline.breaks[1:]) / 2
    ahead, behind = spline(middles + step, order - 1), spline(middles - step, order - 1)
    difference = (ahead - behind) / (2 * step)
    scale = np.abs(spline.control_points).max() * (2 * spline.degree * len(middles)) ** order
    assert np.abs(spline(middles, order) - difference).max() <= 1e-5 * scale


@settings(max_examples=examples(20))
@given(splines())
def test_pieces_join_smoothly(spline: BSpline) -> None:
    inner = spline.breaks[1:-1]
    for order in range(spline.degree):
        scale = np.abs(spline.control_points).max() * (2 * spline.degree * len(inner) + 2) ** order
        jump = spline(inner + 1e-12, order) - spline(inner - 1e-12, order)
        assert np.all(np.abs(jump) <= 1e-8 * scale)


@settings(max_examples=examples(20))
@given(splines(), st.integers(0, 2**32 - 1))
def test_pieces_lie_in_the_hull_of_their_control_points(spline: BSpline, seed: int) -> None:
    directions = np.random.default_rng(seed).normal(size=(3, 50))
    scale = 1e-12 * np.abs(spline.control_points @ directions).max()
    for k in range(len(spline.breaks) - 1):
        u = np.linspace(spline.breaks[k], spline.breaks[k + 1], 30)
        hull = spline.control_points[k : k + spline.degree + 1] @ directions
        reached = spline(u) @ directions
        assert np.all(reached <= hull.max(axis=0) + scale)
        assert np.all(reached >= hull.min(axis=0) - scale)


@settings(max_examples=examples(20))
@given(splines())
def test_ends_are_exact_and_the_outside_is_clamped(spline: BSpline) -> None:
    first, last = spline.control_points[[0, -1]]
    assert np.array_equal(spline([-1.0, 0.0, 1.0, 2.0]), [first, first, last, last])


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_numbers_give_points_and_arrays_give_rows(order: int) -> None:
    spline = clamped(np.random.default_rng(0).normal(size=(6, 3)), 2)
    u = np.linspace(0, 1, 9)
    rows = spline(u, order)
    assert rows.shape == (9, 3)
    assert spline([], order).shape == (0, 3)
    for row, one in zip(rows, u, strict=True):
        assert np.array_equal(spline(float(one), order), row)
