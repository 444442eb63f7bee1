from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import partial

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike
from scipy.integrate import solve_ivp

from abi.arm_planning.arm_errors import OUT_OF_REACH
from abi.arm_planning.motion.tool_motion import tool_motion, tool_samples
from abi.arm_planning.motion.trajectory import ArmMotion, follow
from abi.arm_planning.paper_arm_model import paper_arm
from abi.arm_planning.wrist_drives import wrist_positions
from abi.arrays import FloatArray
from abi.curves.bezier import Bezier
from abi.curves.curve import arc_length
from abi.curves.three_phase_profile import three_phase
from abi.errors import ArgumentError
from abi.explain.paper import printed
from abi.robot.paper_arm.paper_arm import JOINTS
from abi.scene.arm_settings import ArmSettings
from tests.abi.bezier import interpolated
from tests.thorough import examples

POSITIVE = st.floats(-1, 1).map(lambda power: 10.0**power)
SEED = st.integers(0, 2**32 - 1)


@dataclass(frozen=True, eq=False)
class Polynomial:
    """A polynomial curve on [0, 1], rows of coefficients from the constant on."""

    coefficients: FloatArray

    @property
    def interval(self) -> tuple[float, float]:
        return 0.0, 1.0

    def bezier(self) -> Bezier:
        return interpolated(self, np.array(self.interval), len(self.coefficients) - 1)

    def __call__(self, parameter: ArrayLike, order: int = 0) -> FloatArray:
        u = np.clip(np.asarray(parameter, dtype=float), 0, 1)
        rows = self.coefficients
        for _ in range(order):
            rows = rows[1:] * np.arange(1, len(rows))[:, None]
        return np.asarray(sum((u[..., None] ** k * row for k, row in enumerate(rows)), np.zeros(3)))


def straight(start: ArrayLike, end: ArrayLike) -> Polynomial:
    return Polynomial(np.array([start, np.subtract(end, start)], dtype=float))


def printed_quadratic() -> Polynomial:
    return Polynomial(printed.QUADRATIC.coefficients[0])


def run(
    curve: Polynomial,
    arm: ArmSettings | None = None,
    samples: int = 200,
) -> ArmMotion:
    arm = ArmSettings() if arm is None else arm
    arc = arc_length(curve)
    profile = three_phase(arc.length, 4.0, 6.0, 6.0)
    return follow(curve, arc, profile, paper_arm(arm), arm, samples)


def random_curve(seed: int) -> Polynomial:
    rng = np.random.default_rng(seed)
    return Polynomial(np.array([[3.0, 1.0, 4.0], *rng.uniform(-2, 2, (3, 3))]))


@settings(max_examples=examples(20))
@given(SEED, POSITIVE, POSITIVE, POSITIVE)
@example(11307, 1.0, 1.0, 1.0)
def test_velocity_and_acceleration_are_the_derivatives(
    seed: int, speed: float, acceleration: float, deceleration: float
) -> None:
    curve = random_curve(seed)
    arc = arc_length(curve)
    profile = three_phase(arc.length, speed, acceleration, deceleration)
    trajectory = partial(tool_motion, curve, arc, profile)
    edges = np.cumsum([0.0, profile.t1, profile.t2, profile.t3])
    inside = [a + (b - a) * np.array([0.2, 0.5, 0.8]) for a, b in itertools.pairwise(edges)]
    time = np.concatenate([part for part in inside if np.ptp(part) > 1e-3 * edges[-1]])
    for order in (0, 1):
        # Richardson's: where the curve all but turns on the spot, one step alone is not near enough
        coarse, fine = (
            (trajectory(time + step, order) - trajectory(time - step, order)) / (2 * step)
            for step in (1e-5 * profile.duration, 5e-6 * profile.duration)
        )
        numeric = (4 * fine - coarse) / 3
        scale = arc.length / profile.duration ** (order + 1)
        np.testing.assert_allclose(
            trajectory(time, order + 1), numeric, rtol=0, atol=2e-4 * scale * (1 + order * 50)
        )
    speeds = np.linalg.norm(trajectory(time, 1), axis=1)
    np.testing.assert_allclose(speeds, profile(time, 1), rtol=1e-9)


def test_one_time_and_many_agree() -> None:
    curve = printed_quadratic()
    arc = arc_length(curve)
    profile = three_phase(arc.length, 4.0, 6.0, 6.0)
    trajectory, low, high = partial(tool_motion, curve, arc, profile), 0.0, profile.duration
    times = np.linspace(low, high, 7)
    for order in (0, 1, 2):
        each = np.array([trajectory(float(t), order) for t in times])
        np.testing.assert_allclose(each, trajectory(times, order), rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(trajectory(low), [0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(trajectory(high), [6, 6, 6], atol=1e-12)
    with pytest.raises(ArgumentError, match="order is 3"):
        trajectory(0.0, 3)


def test_a_curve_that_rests_at_its_ends_has_directions_there() -> None:
    # u³(10 − 15u + 6u²): zero first and second derivative at both ends.
    way = np.array([3.0, 4.0, 0.0])
    rows = np.array([0, 0, 0, 10, -15, 6])[:, None] * way
    curve = Polynomial(rows + np.array([[1.0, 1.0, 5.0]] + [[0.0] * 3] * 5))
    arc = arc_length(curve)
    along = curve, arc, three_phase(arc.length, 1.0, 1.0, 1.0)
    times = np.linspace(0, along[2].duration, 41)
    np.testing.assert_allclose(tool_samples(*along, times)[1], np.tile(way / 5, (41, 1)), atol=1e-6)
    accelerations = tool_motion(*along, times, 2)
    assert np.isfinite(accelerations).all()
    assert np.linalg.norm(accelerations, axis=1).max() == pytest.approx(1.0, rel=1e-3)


@st.composite
def drives(draw: st.DrawFn) -> ArmSettings:
    triple = st.tuples(POSITIVE, POSITIVE, POSITIVE)
    forces = st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-5, 5))
    return ArmSettings(
        masses=draw(triple), radii=draw(triple), forces=draw(forces), q5=draw(st.floats(0, 1))
    )


@settings(max_examples=25)
@given(drives())
def test_corrected_drives_solve_the_equation_of_motion(given_settings: ArmSettings) -> None:
    """I·q'' = Q from rest, integrated numerically; the sliding joint moves the mass m5 + m6."""
    (m4, m5, m6), (i4, i5, i6) = given_settings.masses, given_settings.radii
    inertia = np.array([m4 * i4**2 + m5 * i5**2 + m6 * i6**2, m5 + m6, m6 * i6**2])
    rates = np.array(given_settings.forces) / inertia
    time = np.linspace(0, 2.0, 9)
    start = [0.0, given_settings.q5, 0.0, 0.0, 0.0, 0.0]
    solved = solve_ivp(
        lambda _, state: np.concatenate([state[3:], rates]),
        (0, 2.0),
        start,
        t_eval=time,
        rtol=1e-10,
        atol=1e-10,
    )
    found = wrist_positions(given_settings, time)
    np.testing.assert_allclose(found, solved.y[:3].T, rtol=1e-7, atol=1e-7)


@settings(max_examples=examples(33))
@given(drives())
def test_printed_drives_are_the_papers(corrected: ArmSettings) -> None:
    printed = corrected.model_copy(update={"dynamics": "as_printed", "q5": 0.0})
    (m4, m5, m6), (i4, i5, i6) = printed.masses, printed.radii
    inertia = [i4**2 * m4 + i5**2 * m5 + i6**2 * m6, i5**2 * m5 + i6**2 * m6, i6**2 * m6]
    time = np.array([0.0, 0.5, 3.0])
    expected = time[:, None] ** 2 * np.array(printed.forces) / np.array(inertia)
    found = wrist_positions(printed, time)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-200)
    # The turning joints differ by the missing half, and only by that.
    halved = wrist_positions(corrected, time)[:, [0, 2]]
    np.testing.assert_allclose(found[:, [0, 2]], 2 * halved, rtol=1e-12, atol=1e-200)


def test_extreme_drives_stay_finite() -> None:
    for size in (1e-6, 1e6):
        light = ArmSettings(masses=(size,) * 3, radii=(size,) * 3, forces=(1e6, -1e6, 1e6))
        for dynamics in ("corrected", "as_printed"):
            chosen = light.model_copy(update={"dynamics": dynamics})
            motion = run(printed_quadratic(), chosen)
            assert np.isfinite(motion.positions).all()
            assert np.isfinite(motion.tool).all()


@pytest.mark.parametrize("elbow", ["up", "down"])
def test_the_arm_follows_the_papers_curve(elbow: str) -> None:
    arm = ArmSettings(elbow=elbow, forces=(0.5, 0.2, 0.6))
    motion = run(printed_quadratic(), arm)
    assert motion.reachable
    assert motion.error is None
    assert motion.within_limits == (elbow == "up")
    np.testing.assert_allclose(motion.tool, motion.target, rtol=0, atol=1e-9)
    np.testing.assert_allclose(motion.target[[0, -1]], [[0, 0, 0], [6, 6, 6]], atol=1e-9)
    assert len(motion.time) == 200
    np.testing.assert_allclose(motion.positions[:, 3:], wrist_positions(arm, motion.time))
    assert motion.positions[-1, 4] > 0


def test_the_papers_start_on_the_base_axis_has_a_q1() -> None:
    motion = run(printed_quadratic(), ArmSettings(base=(0.0, 0.0, 0.0)))
    assert np.isfinite(motion.positions).all()
    np.testing.assert_allclose(motion.tool, motion.target, rtol=0, atol=1e-9)
    assert motion.positions[0, 0] == pytest.approx(math.atan2(12.397, -1.145), abs=1e-9)
    assert motion.peak_joint_speed[0] < 2


def test_joint_steps_shrink_with_the_sampling() -> None:
    coarse, fine = (run(printed_quadratic(), samples=count) for count in (100, 400))
    step = [np.abs(np.diff(m.positions, axis=0)).max() for m in (coarse, fine)]
    assert step[1] < 0.3 * step[0]
    np.testing.assert_allclose(fine.peak_joint_speed, coarse.peak_joint_speed, rtol=0.02)


def test_velocity_is_sampled_with_the_positions() -> None:
    motion = run(printed_quadratic(), samples=2001)
    numeric = np.gradient(motion.target, motion.time, axis=0, edge_order=2)
    np.testing.assert_allclose(motion.tool_velocity, numeric, atol=0.02)


def stretches(motion: ArmMotion) -> list[tuple[float, float, float]]:
    """First and last time of each run of samples out of reach, and the worst in it."""
    side = np.sign(motion.shortfall)
    runs = np.split(np.arange(len(side)), np.flatnonzero(np.diff(side)) + 1)
    worst = [max(motion.shortfall[run].tolist(), key=abs) for run in runs]
    ends = [motion.time[run[[0, -1]]].tolist() for run in runs]
    return [(*both, one) for both, one in zip(ends, worst, strict=True) if one]


def test_too_far_is_told_by_time_and_distance() -> None:
    arm = ArmSettings(base=(0.0, 0.0, 0.0))
    motion = run(straight((4.0, 0.0, 3.0), (14.0, 0.0, 3.0)), arm)
    ((first, last, shortfall),) = stretches(motion)
    reach = arm.a3 + arm.a4 + arm.a5
    distance = np.linalg.norm(motion.target - [0, 0, 3], axis=1)
    assert first == motion.time[distance > reach][0]
    assert last == motion.time[-1]
    assert shortfall == pytest.approx(14 - reach, abs=1e-9)
    missed = np.linalg.norm(motion.tool - motion.target, axis=1)
    np.testing.assert_allclose(missed, np.maximum(distance - reach, 0), atol=1e-9)
    assert not motion.reachable
    assert motion.error is not None
    assert motion.error.kind == OUT_OF_REACH
    assert f"from {first:.2f} s to {last:.2f} s" in motion.error.message
    assert f"too far away, by up to {14 - reach:.3g} cm" in motion.error.in_unit("cm").message


def test_too_near_is_told_too() -> None:
    arm = ArmSettings(base=(0.0, 0.0, 0.0), a3=6.0, a4=1.0, a5=1.0)
    motion = run(straight((7.0, 0.5, 3.0), (-7.0, 0.5, 3.0)), arm)
    ((first, last, shortfall),) = stretches(motion)
    distance = np.linalg.norm(motion.target - [0, 0, 3], axis=1)
    assert shortfall == pytest.approx(float(distance.min()) - 4)
    assert (first, last) == tuple(motion.time[distance < 4][[0, -1]])
    assert motion.error is not None
    assert "too near" in motion.error.message


def test_several_stretches_are_told_apart() -> None:
    arm = ArmSettings(base=(0.0, 0.0, 0.0))
    motion = run(straight((13.0, 2.0, 3.0), (-12.5, 2.0, 3.0)), arm)
    (begin, first_end, worst), (second_begin, end, second) = stretches(motion)
    assert begin == 0
    assert first_end < second_begin
    assert end == motion.time[-1]
    assert worst > second > 0
    assert motion.error is not None
    assert f"from {begin:.2f} s to {first_end:.2f} s" in motion.error.message


def test_joints_past_their_limits_are_named() -> None:
    arm = ArmSettings(forces=(100.0, 2.0, 0.0))
    motion = run(printed_quadratic(), arm)
    limits = paper_arm(arm).limits
    past = (motion.positions < limits[:, 0]) | (motion.positions > limits[:, 1])
    expected = [name for name, column in zip(JOINTS, past.T, strict=True) if column.any()]
    assert {"q4", "q5"} <= set(expected)
    assert [violation.joint for violation in motion.limit_violations] == expected
    assert not motion.within_limits
    for violation in motion.limit_violations:
        column = JOINTS.index(violation.joint)
        row = int(np.flatnonzero(motion.time == violation.time)[0])
        assert motion.positions[row, column] == violation.value
        assert abs(violation.value) == np.abs(motion.positions[:, column]).max()


def test_results_cannot_be_changed() -> None:
    motion = run(printed_quadratic(), samples=5)
    for array in (motion.time, motion.positions, motion.target, motion.tool, motion.tool_velocity):
        assert not array.flags.writeable
