from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.integrate import cumulative_trapezoid

from abi.arrays import FloatArray
from abi.curves.three_phase_profile import ThreePhaseProfile, three_phase
from abi.errors import SceneError
from tests.thorough import examples

MAGNITUDE = st.floats(-3, 3).map(lambda power: 10.0**power)


@st.composite
def profiles(draw: st.DrawFn) -> ThreePhaseProfile:
    return three_phase(draw(MAGNITUDE), draw(MAGNITUDE), draw(MAGNITUDE), draw(MAGNITUDE))


def inside(profile: ThreePhaseProfile) -> FloatArray:
    """Times strictly inside each phase that lasts."""
    ends = np.cumsum([0.0, profile.t1, profile.t2, profile.t3])
    shares = np.array([0.1, 0.3, 0.5, 0.7, 0.9])
    spans = [(a, b) for a, b in itertools.pairwise(ends) if b - a > 1e-9 * ends[-1]]
    return np.concatenate([a + (b - a) * shares for a, b in spans])


@settings(max_examples=examples(66))
@given(profiles())
def test_rests_at_start_and_end_and_travels_the_length(profile: ThreePhaseProfile) -> None:
    assert profile(0.0) == 0
    assert profile(profile.duration) == pytest.approx(profile.length, rel=1e-12)
    assert profile(0.0, 1) == 0
    assert profile(profile.duration, 1) == 0


@settings(max_examples=examples(66))
@given(profiles())
def test_phases_meet(profile: ThreePhaseProfile) -> None:
    for time in (profile.t1, profile.t1 + profile.t2):
        before, after = np.nextafter(time, 0), np.nextafter(time, np.inf)
        tick = 4 * np.spacing(profile.duration)
        steepest = max(profile.acceleration, profile.deceleration)
        jump = abs(profile(after) - profile(before))
        assert jump <= profile.peak_speed * tick + 1e-15 * profile.length
        jump = abs(profile(after, 1) - profile(before, 1))
        assert jump <= steepest * tick + 1e-15 * profile.peak_speed


@settings(max_examples=examples(66))
@given(profiles())
def test_distance_is_monotone_and_the_speed_is_kept(profile: ThreePhaseProfile) -> None:
    time = np.linspace(-0.1, 1.1, 500) * profile.duration
    assert np.all(np.diff(profile(time)) >= -1e-13 * profile.length)
    assert np.all(profile(time, 1) >= 0)
    assert np.all(profile(time, 1) <= profile.speed)
    assert profile.peak_speed == pytest.approx(profile(time, 1).max(), rel=0.05)


@settings(max_examples=examples(66))
@given(profiles())
def test_accelerations_are_exact(profile: ThreePhaseProfile) -> None:
    assert profile(profile.t1 / 2, 2) == profile.acceleration
    assert profile(profile.duration - profile.t3 / 2, 2) == -profile.deceleration
    if profile.t2 > 1e-9 * profile.duration:
        assert profile(profile.t1 + profile.t2 / 2, 2) == 0


@pytest.mark.slow
@settings(max_examples=examples(26))
@given(profiles())
def test_orders_are_derivatives_of_each_other(profile: ThreePhaseProfile) -> None:
    time = inside(profile)
    step = 1e-6 * profile.duration * np.ones_like(time)
    ends = np.cumsum([0.0, profile.t1, profile.t2, profile.t3])
    step = np.minimum(step, np.abs(time[:, None] - ends).min(axis=1))
    speed = (profile(time + step) - profile(time - step)) / (2 * step)
    noise = 1e-15 * profile.length / step
    assert np.all(np.abs(speed - profile(time, 1)) <= 4 * noise + 1e-6 * profile.peak_speed)
    acceleration = (profile(time + step, 1) - profile(time - step, 1)) / (2 * step)
    noise = 1e-15 * profile.peak_speed / step * (1 + profile.duration / profile.t1)
    noise = noise * (1 + profile.duration / profile.t3)
    wanted = profile(time, 2)
    assert np.all(np.abs(acceleration - wanted) <= 4 * noise + 1e-6 * np.abs(wanted))


@settings(max_examples=examples(33))
@given(profiles())
def test_distance_is_the_integral_of_the_speed(profile: ThreePhaseProfile) -> None:
    ends = np.cumsum([0.0, profile.t1, profile.t2, profile.t3])
    time = np.unique(np.concatenate([np.linspace(0, profile.duration, 200), ends]))
    travelled = cumulative_trapezoid(profile(time, 1), time, initial=0)
    # Near the end of a cruise the time itself is known to a rounding only.
    tick = np.spacing(profile.duration) * max(profile.acceleration, profile.deceleration)
    tolerance = 1e-11 * profile.length + tick * profile.duration / 100
    assert np.abs(travelled - profile(time)).max() <= tolerance


@settings(max_examples=examples(66))
@given(profiles())
@example(three_phase(1.0, 10.0, 2.0, 3.0))
@example(three_phase(100.0, 1.0, 2.0, 3.0))
def test_theorem_1(profile: ThreePhaseProfile) -> None:
    assert abs(profile.theorem_residual) <= 4e-16 * profile.t1
    assert profile.t1 * profile.acceleration == pytest.approx(profile.peak_speed, rel=1e-14)
    assert profile.t3 * profile.deceleration == pytest.approx(profile.peak_speed, rel=1e-14)


@settings(max_examples=examples(66))
@given(MAGNITUDE, MAGNITUDE, MAGNITUDE, MAGNITUDE)
def test_no_motion_within_the_limits_is_faster(
    length: float, speed: float, acceleration: float, deceleration: float
) -> None:
    profile = three_phase(length, speed, acceleration, deceleration)
    # Whatever lower cruising speed is taken instead, the same length lasts longer.
    for share in (0.5, 0.9, 0.99):
        cruise = share * profile.peak_speed
        ramps = cruise**2 / 2 * (1 / acceleration + 1 / deceleration)
        slower = cruise / acceleration + cruise / deceleration + (length - ramps) / cruise
        assert slower >= profile.duration * (1 - 1e-12)
    assert profile.peak_speed <= speed
    assert profile.t2 == 0 if profile.triangular else profile.peak_speed == speed


def test_triangular_peak_as_in_the_formula() -> None:
    profile = three_phase(2.0, 100.0, 3.0, 6.0)
    assert profile.triangular
    assert profile.peak_speed == pytest.approx(math.sqrt(2 * 2.0 * 3 * 6 / 9), rel=1e-14)


def test_no_length_takes_no_time() -> None:
    profile = three_phase(0.0, 1.0, 1.0, 1.0)
    assert profile.duration == 0
    assert np.array_equal(profile([-1.0, 0.0, 1.0]), [0, 0, 0])


def test_rests_outside_the_motion() -> None:
    profile = three_phase(3.0, 1.0, 2.0, 4.0)
    outside = [-1.0, profile.duration + 1]
    assert np.array_equal(profile(outside), [0, 3])
    assert np.array_equal(profile(outside, 1), [0, 0])
    assert np.array_equal(profile(outside, 2), [0, 0])


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan, math.inf])
def test_refuses_what_is_no_rate(bad: float) -> None:
    with pytest.raises(SceneError, match=r"motion\.deceleration"):
        three_phase(1.0, 1.0, 1.0, bad)


@pytest.mark.parametrize("bad", [-1.0, math.nan, math.inf])
def test_refuses_what_is_no_length(bad: float) -> None:
    with pytest.raises(SceneError, match="length"):
        three_phase(bad, 1.0, 1.0, 1.0)
