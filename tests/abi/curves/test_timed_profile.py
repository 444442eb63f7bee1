"""Motions along a length against the laws of motion, and the fastest against linear programs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import ruckig
import scipy
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.arrays import FloatArray, flat
from abi.curves.cubic_profile import CubicProfile, from_squared_speeds, jerk_limited
from abi.curves.three_phase_profile import three_phase
from abi.curves.time_optimal_kernels import fastest_speeds
from tests.kernel_forms import compiled, plain
from tests.thorough import examples

rates = st.floats(0.1, 30)
lengths = st.floats(1e-3, 1e3)


def check_derivatives(profile: CubicProfile) -> None:
    """Each derivative integrates to the one before it."""
    times = np.linspace(0, profile.duration, 2001)
    times = np.unique(np.concatenate([times, profile.breaks]))
    middle, step = (times[1:] + times[:-1]) / 2, np.diff(times)
    keep = step > 1e-9 * profile.duration
    for order in range(2):
        change = np.diff(profile(times, order))[keep]
        scale = float(np.abs(change).max())
        # Simpson's rule is exact: the pieces are cubics
        ends = profile(times[:-1], order + 1), profile(np.nextafter(times[1:], 0), order + 1)
        mean = (ends[0] + 4 * profile(middle, order + 1) + ends[1]) / 6
        np.testing.assert_allclose(change, (mean * step)[keep], atol=1e-7 * scale)


@settings(max_examples=examples(26))
@given(lengths, rates, rates, rates)
def test_a_jerk_limited_motion_keeps_its_limits_and_meets_one(
    length: float, speed: float, acceleration: float, jerk: float
) -> None:
    profile = jerk_limited(length, speed, acceleration, jerk)
    times = np.linspace(0, profile.duration, 501)
    values = [np.abs(profile(times, order)) for order in range(4)]

    assert values[0][0] == 0
    assert values[0][-1] == pytest.approx(length, rel=1e-9)
    assert values[1][[0, -1]] == pytest.approx(0, abs=1e-6 * speed)
    for value, limit in zip(values[1:], (speed, acceleration, jerk), strict=True):
        assert value.max() <= limit * (1 + 1e-6)
    assert profile.peak_speed == pytest.approx(
        float(profile(np.linspace(0, profile.duration, 20_001), 1).max()), rel=1e-4
    )
    check_derivatives(profile)
    # no slower than what halves every limit, no faster than without the jerk's
    assert profile.duration >= three_phase(length, speed, acceleration, acceleration).duration * (
        1 - 1e-9
    )
    slower = jerk_limited(length, speed / 2, acceleration / 4, jerk / 8)
    assert slower.duration == pytest.approx(2 * profile.duration, rel=1e-6)


@given(lengths, rates, rates, rates)
def test_a_jerk_limited_motion_is_ruckig_s(
    length: float, speed: float, acceleration: float, jerk: float
) -> None:
    profile = jerk_limited(length, speed, acceleration, jerk)
    states = ruckig.InputParameter(1)
    states.current_position, states.target_position = [0.0], [length]
    states.max_velocity, states.max_acceleration = [speed], [acceleration]
    states.max_jerk = [jerk]
    fastest = ruckig.Trajectory(1)
    ruckig.Ruckig(1).calculate(states, fastest)

    assert profile.duration == pytest.approx(fastest.duration, rel=1e-7)
    times = np.linspace(0, fastest.duration, 50)
    expected = np.array([fastest.at_time(time) for time in times])[:, :2, 0]
    for order, largest in enumerate((length, speed)):
        np.testing.assert_allclose(profile(times, order), expected[:, order], atol=1e-6 * largest)


@settings(max_examples=40)
@given(lengths, rates, st.floats(1, 9))
def test_a_stretched_motion_is_the_same_later(length: float, speed: float, factor: float) -> None:
    profile = jerk_limited(length, speed, 3.0, 9.0)
    slower = profile.stretched(factor)
    times = np.linspace(0, profile.duration, 101)

    for order in range(3):
        expected = profile(times, order) / factor**order
        scale = 1e-9 * float(np.abs(expected).max())
        np.testing.assert_allclose(slower(times[1:-1] * factor, order), expected[1:-1], atol=scale)


def some_path(seed: int, points: int, joints: int) -> tuple[FloatArray, FloatArray, float]:
    """Derivatives of smooth joints by the distance at a grid, and its step."""
    random = np.random.default_rng(seed)
    distances = np.linspace(0, 1, points)
    shift, rate = random.uniform(0, 6, (2, joints))
    first = np.cos(rate * distances[:, None] + shift)
    second = -rate * np.sin(rate * distances[:, None] + shift)
    return first, second, 1 / (points - 1)


def fastest(
    first: FloatArray, second: FloatArray, step: float, speeds: FloatArray, limits: FloatArray
) -> FloatArray:
    squared, room = np.empty(len(first)), np.empty(2 * len(first))
    arguments = flat(first), flat(second), step, flat(speeds), flat(limits)
    assert fastest_speeds(*arguments, room, squared) == -1
    return squared


@settings(max_examples=25)
@given(st.integers(0, 2**31), st.integers(1, 4))
def test_the_fastest_speeds_are_the_optimum_of_a_linear_program(seed: int, joints: int) -> None:
    first, second, step = some_path(seed, 41, joints)
    random = np.random.default_rng(seed + 1)
    speeds, limits = random.uniform(0.3, 3, (2, joints))
    found = fastest(first, second, step, speeds, limits)

    # u of a step is a difference of x: |q'·u + q''·x| ≤ A at both its ends, x ≤ (V / q')²
    count, rows, bounds = len(first), [], []
    for i in range(count - 1):
        for end in (i, i + 1):
            for j in range(joints):
                row = np.zeros(count)
                row[i + 1] += first[end, j] / (2 * step)
                row[i] -= first[end, j] / (2 * step)
                row[end] += second[end, j]
                rows += [row, -row]
                bounds += [limits[j], limits[j]]
    top = ((speeds / np.maximum(np.abs(first), 1e-12)) ** 2).min(axis=1)
    top[[0, -1]] = 0
    best = scipy.optimize.linprog(
        -np.ones(count), np.array(rows), bounds, bounds=[(0, float(x)) for x in top]
    )
    assert best.success
    assert (np.array(rows) @ found <= np.array(bounds) + 1e-9).all()
    assert (found <= top + 1e-9).all()
    # where no joint moves, the greedy choice leaves the optimum by less than the grid does
    assert found.sum() >= (1 - 2e-3) * best.x.sum()
    profile = from_squared_speeds(1.0, np.linspace(0, 1, count), found)
    check_derivatives(profile)


def by_toppra(path: Any, grid: FloatArray, speeds: FloatArray, limits: FloatArray) -> FloatArray:
    """The fastest speeds along a path by TOPP-RA's own library, whose ends of steps hold, too."""
    import toppra.algorithm
    import toppra.constraint

    rates = toppra.constraint.JointVelocityConstraint(np.stack([-speeds, speeds], axis=1))
    growth = toppra.constraint.JointAccelerationConstraint(
        np.stack([-limits, limits], axis=1),
        discretization_scheme=toppra.constraint.DiscretizationType.Interpolation,
    )
    solver = toppra.algorithm.TOPPRA([rates, growth], path, gridpoints=grid)
    _, found, *_ = solver.compute_parameterization(0, 0, return_data=True)
    return np.asarray(found)


@settings(max_examples=20)
@given(st.integers(0, 2**31), st.integers(1, 7))
def test_the_fastest_motion_is_toppra_s(seed: int, joints: int) -> None:
    import toppra  # and pyplot with it, in each worker that collects this file

    random = np.random.default_rng(seed)
    places = random.uniform(-2, 2, (6, joints))
    path = toppra.SplineInterpolator(np.linspace(0, 1, len(places)), places)
    speeds, limits = random.uniform(0.3, 3, (2, joints))
    durations, expected = [], []
    for points in (201, 801):
        grid = np.linspace(0, 1, points)
        best = by_toppra(path, grid, speeds, limits) ** 2
        found = fastest(path(grid, 1), path(grid, 2), 1 / (points - 1), speeds, limits)
        np.testing.assert_allclose(found, best, atol=1e-2 * float(best.max()))
        durations.append(from_squared_speeds(1.0, grid, found).duration)
        expected.append(from_squared_speeds(1.0, grid, best).duration)
    np.testing.assert_allclose(durations, expected, rtol=1e-2)


def test_the_fastest_speeds_are_the_same_compiled_and_plain() -> None:
    first, second, step = some_path(3, 201, 3)
    arguments = first, second, step, np.ones(3), np.full(3, 2.0)
    np.testing.assert_allclose(
        plain(lambda: fastest(*arguments)), compiled(lambda: fastest(*arguments)), atol=1e-12
    )
