from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike
from scipy.integrate import quad

from abi.arrays import FloatArray
from abi.curves.bezier import Bezier
from abi.curves.bspline import clamped
from abi.curves.curve import Curve, arc_length
from abi.explain.paper import printed
from tests.abi.bezier import interpolated
from tests.thorough import examples


@dataclass(frozen=True)
class Polynomial:
    """Rows of coefficients, constant first, on any interval."""

    coefficients: FloatArray
    interval: tuple[float, float]

    def bezier(self) -> Bezier:
        return interpolated(self, np.array(self.interval, dtype=float), len(self.coefficients) - 1)

    def __call__(self, parameter: ArrayLike, order: int = 0) -> FloatArray:
        u = np.asarray(parameter, dtype=float)
        columns = [np.polynomial.Polynomial(column) for column in self.coefficients.T]
        return np.stack([column.deriv(order)(u) for column in columns], axis=-1)


@st.composite
def splines(draw: st.DrawFn, repeated: bool = False) -> Curve:
    """Random splines of any degree and size; ``repeated`` ones rest at some control points."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    degree = draw(st.integers(1, 5))
    points = rng.uniform(-1, 1, (draw(st.integers(degree + 1, 12)), 3))
    if repeated:
        points = np.repeat(points, rng.integers(1, degree + 3, len(points)), axis=0)
    return clamped(points * 10.0 ** draw(st.floats(-3, 3)), degree)


def integral(curve: Curve, first: float, last: float) -> float:
    """Arc length by adaptive quadrature between the breaks, an oracle."""
    breaks = curve.bezier().breaks
    inner = breaks[(breaks > first) & (breaks < last)]
    ends = [first, *inner, last]
    total = 0.0
    for a, b in itertools.pairwise(ends):
        found, _ = quad(lambda u: np.linalg.norm(curve(u, 1)), a, b, epsabs=0, epsrel=1e-11)
        total += float(found)
    return total


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_lengths_with_closed_form(size: float) -> None:
    line = Polynomial(size * np.array([[1.0, 2, 3], [2.0, 3, 6]]), (0, 2))
    assert arc_length(line).length == pytest.approx(14 * size, rel=1e-14)
    parabola = Polynomial(size * np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), (0, 3))
    exact = 3 * math.sqrt(37) / 2 + math.asinh(6) / 4
    assert arc_length(parabola).length == pytest.approx(exact * size, rel=1e-12)


def test_turning_points_inside_a_piece() -> None:
    # The speed abs(u)·sqrt(4 + 9u²) of (u², u³) has a kink at 0, that of (u², 0) too.
    cusp = Polynomial(np.array([[0.0, 0, 0], [0, 0, 0], [1, 0, 0], [0, 1, 0]]), (-1, 1))
    assert arc_length(cusp).length == pytest.approx(2 * (13**1.5 - 8) / 27, rel=1e-11)
    back = Polynomial(np.array([[0.0, 0, 0], [0, 0, 0], [1, 0, 0]]), (-1, 2))
    assert arc_length(back).length == pytest.approx(5, rel=1e-11)
    assert arc_length(back).distance(0.0) == pytest.approx(1, rel=1e-10)
    assert back(arc_length(back).parameter(1.5)) == pytest.approx([0.5, 0, 0], abs=1e-10)


@settings(max_examples=25)
@given(splines(), st.floats(0.01, 1))
def test_distance_equals_adaptive_quadrature(curve: Curve, parameter: float) -> None:
    arc = arc_length(curve)
    assert arc.distance(parameter) == pytest.approx(integral(curve, 0, parameter), rel=1e-9)


@settings(max_examples=examples(50))
@given(splines(), st.integers(1, 50))
def test_inverse_and_forward_are_inverse(curve: Curve, count: int) -> None:
    arc = arc_length(curve)
    distance = np.linspace(0, arc.length, count + 1)
    there = arc.distance(arc.parameter(distance))
    assert np.abs(there - distance).max() <= 1e-12 * arc.length
    parameter = np.linspace(0, 1, count + 1)
    back = arc.parameter(arc.distance(parameter))
    speed = np.linalg.norm(curve(parameter, 1), axis=1)
    assert np.all(np.abs(back - parameter) * speed <= 1e-11 * arc.length + 1e-5 * (speed == 0))


@settings(max_examples=examples(33))
@given(splines(repeated=True))
def test_repeated_control_points_give_no_nan(curve: Curve) -> None:
    arc = arc_length(curve)
    distance = np.linspace(0, arc.length, 60)
    parameter = arc.parameter(distance)
    assert np.isfinite(parameter).all()
    assert np.all(np.diff(parameter) >= 0)
    assert np.abs(arc.distance(parameter) - distance).max() <= 1e-12 * arc.length
    steps = np.linalg.norm(np.diff(curve(parameter), axis=0), axis=1)
    assert np.all(steps <= arc.length / 59 * (1 + 1e-9))


@settings(max_examples=50)
@given(splines())
def test_ends_are_exact_and_the_outside_is_clamped(curve: Curve) -> None:
    arc = arc_length(curve)
    assert np.array_equal(arc.parameter([-1.0, 0.0, arc.length, 2 * arc.length]), [0, 0, 1, 1])
    assert np.array_equal(arc.distance([-1.0, 0.0]), [0, 0])
    assert arc.distance([1.0, 2.0]) == pytest.approx(arc.length, rel=1e-14)


@settings(max_examples=50)
@given(splines())
def test_length_lies_between_chord_and_polygon(curve: Curve) -> None:
    length = arc_length(curve).length
    first, last = curve([0.0, 1.0])
    samples = curve(np.union1d(np.linspace(0, 1, 4001), curve.bezier().breaks))
    inscribed = np.linalg.norm(np.diff(samples, axis=0), axis=1).sum()
    assert np.linalg.norm(last - first) <= length * (1 + 1e-12)
    assert inscribed <= length * (1 + 1e-12)
    assert inscribed == pytest.approx(length, rel=1e-3)


@settings(max_examples=20)
@given(splines())
def test_gauss_points_integrate_along_the_curve(curve: Curve) -> None:
    arc = arc_length(curve)
    assert np.all(np.diff(arc.nodes) > 0)
    # The mean of s along the curve is half the length, that of s² a third of its square.
    share = arc.distance(arc.nodes) / arc.length
    assert arc.weights.sum() == pytest.approx(arc.length, rel=1e-13)
    assert share @ arc.weights == pytest.approx(arc.length / 2, rel=1e-11)
    assert share**2 @ arc.weights == pytest.approx(arc.length / 3, rel=1e-11)


def test_a_curve_that_stays_has_no_length() -> None:
    arc = arc_length(clamped(np.ones((5, 3)), 3))
    assert arc.length == 0
    assert np.isfinite(arc.parameter([0.0, 1.0])).all()
    assert np.array_equal(arc.distance([0.0, 0.5, 1.0]), [0, 0, 0])


@pytest.mark.parametrize("shape", [(), (0,), (7,), (2, 3)])
def test_shapes_are_kept(shape: tuple[int, ...]) -> None:
    arc = arc_length(printed.QUADRATIC)
    given_values = np.full(shape, 0.3)
    assert arc.distance(given_values).shape == shape
    assert arc.parameter(given_values).shape == shape


def test_results_cannot_change() -> None:
    arc = arc_length(printed.QUADRATIC)
    for array in (arc.edges, arc.travelled, arc.series, arc.nodes, arc.weights):
        assert not array.flags.writeable
