from __future__ import annotations

import math
from typing import Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.arm_planning.paper_arm_model import paper_arm
from abi.arrays import FloatArray
from abi.robot.paper_arm.inverse_kinematics import solve
from abi.robot.paper_arm.paper_arm import PaperArm, forward
from abi.scene.arm_settings import ArmSettings
from tests.thorough import examples

Elbow = Literal["up", "down"]
ELBOWS: tuple[Elbow, Elbow] = ("up", "down")
LENGTH = st.floats(-1, 1).map(lambda power: 10.0**power)
SEED = st.integers(0, 2**32 - 1)


@st.composite
def arms(draw: st.DrawFn) -> PaperArm:
    lengths = {name: draw(LENGTH) for name in ("a1", "a2", "a3", "a4", "a5")}
    base = tuple(draw(st.floats(-20, 20)) for _ in range(3))
    return paper_arm(ArmSettings(base=base, **lengths))


def default_arm(**changes: float) -> PaperArm:
    return paper_arm(ArmSettings(base=(0.0, 0.0, 0.0), **changes))


def tool(arm: PaperArm, found: FloatArray, q5: FloatArray) -> FloatArray:
    zero = np.zeros_like(q5)
    return forward(arm, np.column_stack([found, zero, q5, zero]))


def tangents_of(points: FloatArray) -> FloatArray:
    slopes = np.gradient(points, axis=0)
    size = np.linalg.norm(slopes, axis=1, keepdims=True)
    return np.asarray(np.divide(slopes, size, out=np.zeros_like(slopes), where=size > 0))


def follow(arm: PaperArm, points: FloatArray, elbow: Elbow = "up") -> tuple[FloatArray, FloatArray]:
    """Solve along a path, check that the tool is on it, return joints and the largest steps."""
    q5 = np.zeros(len(points))
    found, shortfall = solve(arm, points, q5, elbow, tangents_of(points))
    assert (shortfall == 0).all()
    np.testing.assert_allclose(tool(arm, found, q5), points, rtol=0, atol=1e-9)
    return found, np.abs(np.diff(found, axis=0)).max(axis=0)


def reachable_points(arm: PaperArm, count: int, seed: int) -> tuple[FloatArray, FloatArray]:
    """Points from random joints, spread over all quadrants, and the extension of each."""
    rng = np.random.default_rng(seed)
    positions = rng.uniform(-np.pi, np.pi, (count, 6))
    positions[:, 4] = rng.uniform(0, arm.limits[4, 1], count)
    return forward(arm, positions), positions[:, 4]


@pytest.mark.slow
@settings(max_examples=24)
@given(arms(), SEED, st.sampled_from(ELBOWS))
def test_the_tool_is_on_every_reachable_point(arm: PaperArm, seed: int, elbow: Elbow) -> None:
    points, q5 = reachable_points(arm, 40, seed)
    for row in range(0, 40, 8):
        chosen = slice(row, row + 8)
        found, shortfall = solve(arm, points[chosen], q5[chosen], elbow, np.zeros((8, 3)))
        assert (shortfall == 0).all()
        error = np.abs(tool(arm, found, q5[chosen]) - points[chosen]).max()
        assert error < 1e-9
        sign = 1 if elbow == "up" else -1
        assert np.all(sign * found[:, 2] >= 0)


@pytest.mark.slow
@settings(max_examples=24)
@given(arms(), SEED)
def test_solving_gives_back_the_joints_that_made_the_point(arm: PaperArm, seed: int) -> None:
    rng = np.random.default_rng(seed)
    positions = rng.uniform(-np.pi, np.pi, (1, 6))
    q5 = positions[:, 4] = rng.uniform(0, arm.limits[4, 1], 1)
    q1, q2, q3 = positions[0, :3]
    if arm.a3 * math.sin(q2) + (arm.a4 + arm.a5 + q5[0]) * math.sin(q2 + q3) < 0:
        # The same pose, facing the point.
        q1, q2, q3 = q1 + math.pi, -q2, -q3
    elbow: Elbow = "up" if q3 >= 0 else "down"
    found, _ = solve(arm, forward(arm, positions), q5, elbow, np.zeros((1, 3)))
    np.testing.assert_allclose(
        np.exp(1j * found[0]), np.exp(1j * np.array([q1, q2, q3])), atol=1e-5
    )


@pytest.mark.parametrize("elbow", ELBOWS)
@pytest.mark.parametrize(("x", "y"), [(4, 4), (-4, 4), (-4, -4), (4, -4), (0, 4), (0, -4), (4, 0)])
def test_the_arm_faces_the_point_in_every_quadrant(x: float, y: float, elbow: Elbow) -> None:
    arm = default_arm()
    point = np.array([[x, y, 4.0]])
    found, _ = solve(arm, point, np.zeros(1), elbow, np.zeros((1, 3)))
    # q1 = 0 faces -y, and r >= 0: the arm does not reach over its back.
    facing = np.array([math.sin(found[0, 0]), -math.cos(found[0, 0])])
    np.testing.assert_allclose(facing, np.array([x, y]) / math.hypot(x, y), atol=1e-12)
    np.testing.assert_allclose(tool(arm, found, np.zeros(1)), point, atol=1e-9)


@pytest.mark.slow
@settings(max_examples=24)
@given(arms(), SEED)
def test_elbow_up_is_the_more_upright_upper_arm(arm: PaperArm, seed: int) -> None:
    points, q5 = reachable_points(arm, 1, seed)
    up, down = (solve(arm, points, q5, elbow, np.zeros((1, 3)))[0] for elbow in ELBOWS)
    np.testing.assert_allclose(up[:, 2], -down[:, 2])
    assert math.cos(up[0, 1]) >= math.cos(down[0, 1]) - 1e-9 or points[0, 2] < arm.shoulder[2]


@pytest.mark.slow
@settings(max_examples=24)
@given(arms(), SEED)
def test_the_corrected_printed_formula_gives_both_elbows(arm: PaperArm, seed: int) -> None:
    """The paper's q2 with a3³·Pza for the printed a3²·Pza, over both signs of its root."""
    points, q5 = reachable_points(arm, 1, seed)
    x, y, z = points[0] - arm.shoulder
    a3, a6, p = arm.a3, arm.a4 + arm.a5 + q5[0], x * x + y * y
    square = p + z * z
    inside = -(a3**2) * p * (a3**4 + (square - a6**2) ** 2 - 2 * a3**2 * (a6**2 + square))
    lead = a3**3 * z + a3 * z * (square - a6**2)
    roots = lead + np.array([1, -1]) * math.sqrt(max(0.0, inside))
    printed = roots / (2 * a3**2 * square)
    ours = [solve(arm, points, q5, elbow, np.zeros((1, 3)))[0][0, 1] for elbow in ELBOWS]
    np.testing.assert_allclose(np.sort(np.cos(ours)), np.sort(printed), atol=1e-5)


@pytest.mark.slow
@settings(max_examples=24)
@given(SEED, st.sampled_from(ELBOWS))
def test_joints_are_as_continuous_as_the_path(seed: int, elbow: Elbow) -> None:
    """No joint steps farther than the path's step allows at the local condition of the arm."""
    rng = np.random.default_rng(seed)
    arm = default_arm()
    t = np.linspace(0, 1, 1500)
    # A loop about the base axis, turning more than once, within reach.
    turn = rng.uniform(-9, 9) * t + rng.uniform(-np.pi, np.pi)
    radius = 5 + rng.uniform(-2.5, 2.5) * np.sin(rng.uniform(1, 6) * t + rng.uniform(0, 6))
    height = 3 + rng.uniform(-4, 4) * np.sin(rng.uniform(1, 6) * t + rng.uniform(0, 6))
    points = np.stack([radius * np.sin(turn), -radius * np.cos(turn), height], axis=1)
    joints, _ = follow(arm, points, elbow)
    path = np.linalg.norm(np.diff(points, axis=0), axis=1)
    gain = 1 / _smallest_singular_values(arm, joints)
    allowed = path * np.maximum(gain[1:], gain[:-1]) * 1.2
    assert np.all(np.linalg.norm(np.diff(joints, axis=0), axis=1) <= allowed)
    assert np.all(joints[:, 2] > 0) if elbow == "up" else np.all(joints[:, 2] < 0)


def _smallest_singular_values(arm: PaperArm, joints: FloatArray) -> FloatArray:
    """Least tool speeds (n,) per joint speed, from differences of the forward kinematics."""
    step = 1e-6
    rows = np.zeros((len(joints), 6, 6))
    rows[:, :, :3] = joints[:, None] + step * np.vstack([np.eye(3), -np.eye(3)])
    points = forward(arm, rows.reshape(-1, 6)).reshape(-1, 6, 3)
    jacobians = (points[:, :3] - points[:, 3:]).transpose(0, 2, 1) / (2 * step)
    return np.asarray(np.linalg.svd(jacobians, compute_uv=False)[:, -1])


@settings(max_examples=examples(33))
@given(st.floats(-np.pi, np.pi), st.floats(-0.8, 0.8), st.integers(2, 60), st.booleans())
def test_through_the_base_axis_q1_does_not_jump(
    angle: float, slope: float, half: int, on_axis: bool
) -> None:
    """A straight path through the axis, with a sample on it and without."""
    arm = default_arm()
    count = 2 * half + (1 if on_axis else 0)
    s = np.linspace(-4, 4, count)
    direction = np.array([math.cos(angle), math.sin(angle), slope])
    points = np.array([0.0, 0.0, 8.5]) + s[:, None] * direction
    q5 = np.zeros(count)
    tangents = np.tile(direction / np.linalg.norm(direction), (count, 1))
    found, _ = solve(arm, points, q5, "up", tangents)
    np.testing.assert_allclose(tool(arm, found, q5), points, atol=1e-9)
    assert np.ptp(found[:, 0]) < 1e-6
    steps = np.abs(np.diff(found[:, 1:], axis=0))
    assert steps.max() < 1.2 * 8 / count


@pytest.mark.parametrize("count", [100, 101, 999])
def test_a_curve_through_the_base_axis_keeps_all_joints_continuous(count: int) -> None:
    arm = default_arm()
    steps = []
    for refined in (count, 4 * count):
        t = np.linspace(-1, 1.3, refined)
        points = np.stack([3 * t + t**2, 2 * t**2 - t, 7 + t - t**3], axis=1)
        rates = np.stack([3 + 2 * t, 4 * t - 1, 1 - 3 * t**2], axis=1)
        tangents = rates / np.linalg.norm(rates, axis=1, keepdims=True)
        q5 = np.zeros(refined)
        found, _ = solve(arm, points, q5, "down", tangents)
        np.testing.assert_allclose(tool(arm, found, q5), points, atol=1e-9)
        steps.append(np.abs(np.diff(found, axis=0)).max())
    assert steps[0] < 10 / count
    assert steps[1] < steps[0] / 3


def test_under_the_shoulder_q2_does_not_jump() -> None:
    arm = default_arm(a1=4.0, a2=4.0)
    s = np.linspace(-2, 2, 201)
    points = np.stack([0 * s, s, 2 + 0 * s], axis=1)
    for elbow in ELBOWS:
        _, steps = follow(arm, points, elbow)
        assert steps.max() < 0.05


def test_past_the_base_axis_q1_turns_as_it_must() -> None:
    arm = default_arm()
    s = np.linspace(-3, 3, 6001)
    points = np.stack([s, 0.05 + 0 * s, 7 + 0 * s], axis=1)
    found, steps = follow(arm, points)
    assert np.ptp(found[:, 0]) == pytest.approx(2 * math.atan(3 / 0.05), abs=1e-6)
    # q1' = v·d/(d² + s²) is largest at the axis: v/d.
    assert steps[0] == pytest.approx(0.001 / 0.05, rel=1e-3)


@pytest.mark.parametrize("elbow", ELBOWS)
@pytest.mark.parametrize("angle", [0.3, 1.9, -2.8, -0.7])
def test_from_the_base_axis_q1_is_its_limit(angle: float, elbow: Elbow) -> None:
    """The paper's own start: the path leaves the base axis."""
    arm = default_arm()
    t = np.linspace(0, 1, 50)
    # It leaves in the direction `angle` and bends away.
    points = np.stack(
        [
            4 * t * math.sin(angle) + t**2,
            -4 * t * math.cos(angle) + t**2,
            6 + t,
        ],
        axis=1,
    )
    rates = np.stack(
        [4 * math.sin(angle) + 2 * t, -4 * math.cos(angle) + 2 * t, np.ones_like(t)], axis=1
    )
    tangents = rates / np.linalg.norm(rates, axis=1, keepdims=True)
    for order in (1, -1):
        found, _ = solve(arm, points[::order], np.zeros(50), elbow, order * tangents[::order])
        on_axis = found[0 if order == 1 else -1, 0]
        assert on_axis == pytest.approx(angle, abs=1e-9)
        np.testing.assert_allclose(tool(arm, found, np.zeros(50)), points[::order], atol=1e-9)


def test_on_the_base_axis_all_along_q1_is_0() -> None:
    arm = default_arm()
    points = np.stack([np.zeros(30), np.zeros(30), np.linspace(4, 9, 30)], axis=1)
    found, _ = follow(arm, points)
    assert not found[:, 0].any()


def test_along_the_base_axis_q1_turns_between_arrival_and_departure() -> None:
    arm = default_arm()
    t = np.linspace(0, 3, 301)
    before, after = np.clip(1 - t, 0, None) ** 2, np.clip(t - 2, 0, None) ** 2
    points = np.stack([3 * before, 3 * after, 6 + t], axis=1)
    found, steps = follow(arm, points)
    assert steps.max() < 0.1
    assert abs(math.sin(found[-1, 0] - found[0, 0])) == pytest.approx(1)


@pytest.mark.slow
@settings(max_examples=24)
@given(arms(), SEED, st.sampled_from(ELBOWS))
def test_out_of_reach_is_told_by_distance(arm: PaperArm, seed: int, elbow: Elbow) -> None:
    """The stretched or folded arm points at the point, as near as it can come."""
    rng = np.random.default_rng(seed)
    direction = rng.normal(size=(20, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    forearm = arm.a4 + arm.a5
    longest, shortest = arm.a3 + forearm, abs(arm.a3 - forearm)
    distance = np.concatenate(
        [longest * rng.uniform(1.001, 5, 10), shortest * rng.uniform(0.1, 0.999, 10)]
    )
    points = arm.shoulder + direction * distance[:, None]
    q5 = np.zeros(20)
    found, shortfall = solve(arm, points, q5, elbow, np.zeros((20, 3)))
    expected = np.concatenate([distance[:10] - longest, distance[10:] - shortest])
    np.testing.assert_allclose(shortfall, expected, rtol=1e-6, atol=1e-9)
    missed = np.linalg.norm(tool(arm, found, q5) - points, axis=1)
    np.testing.assert_allclose(missed, np.abs(expected), rtol=1e-6, atol=1e-9)


@pytest.mark.slow
@settings(max_examples=40)
@given(arms(), SEED, st.sampled_from(ELBOWS))
def test_full_stretch_and_full_fold_are_within_reach(
    arm: PaperArm, seed: int, elbow: Elbow
) -> None:
    direction = np.random.default_rng(seed).normal(size=3)
    direction /= np.linalg.norm(direction)
    forearm = arm.a4 + arm.a5
    for distance in (arm.a3 + forearm, abs(arm.a3 - forearm)):
        points = arm.shoulder + distance * direction[None]
        found, shortfall = solve(arm, points, np.zeros(1), elbow, np.zeros((1, 3)))
        assert (shortfall == 0).all()
        np.testing.assert_allclose(tool(arm, found, np.zeros(1)), points, rtol=0, atol=1e-9)


@settings(max_examples=examples(33))
@given(SEED, st.floats(-9, 9), st.sampled_from(ELBOWS))
def test_a_forearm_pulled_past_the_elbow_still_solves(
    seed: int, forearm: float, elbow: Elbow
) -> None:
    arm = default_arm()
    q5 = np.full(5, forearm - arm.a4 - arm.a5)
    positions = np.random.default_rng(seed).uniform(-np.pi, np.pi, (5, 6))
    positions[:, 4] = q5
    points = forward(arm, positions)
    found, shortfall = solve(arm, points, q5, elbow, np.zeros((5, 3)))
    assert (shortfall == 0).all()
    np.testing.assert_allclose(tool(arm, found, q5), points, rtol=0, atol=1e-9)


def test_results_cannot_be_changed() -> None:
    arm = default_arm()
    found, shortfall = solve(arm, np.array([[1.0, 2.0, 7.0]]), np.zeros(1), "up", np.zeros((1, 3)))
    for array in (found, shortfall):
        assert not array.flags.writeable


@pytest.mark.parametrize("elbow", ELBOWS)
def test_a_hundred_thousand_poses_come_back_on_both_branches(elbow: Elbow) -> None:
    arm = default_arm()
    points, q5 = reachable_points(arm, 100_000, 5)
    found, shortfall = solve(arm, points, q5, elbow, np.zeros_like(points))

    assert (shortfall == 0).all()
    np.testing.assert_allclose(tool(arm, found, q5), points, rtol=0, atol=1e-9)
    assert ((found[:, 2] >= 0) if elbow == "up" else (found[:, 2] <= 0)).all()
