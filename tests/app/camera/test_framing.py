"""A camera sees all points in what is free of its picture, and stands no farther than it must."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from abi.planner.planner import plan as planned
from abi.scene.scene import load_scene, scene_names
from app.camera.extent import extent
from app.camera.framing import Window, axes, holds, lift, stand

_WINDOWS = st.builds(
    Window,
    fov=st.floats(0.5, 1.6),
    aspect=st.floats(0.4, 2.5),
    above=st.floats(0.0, 0.4),
    below=st.floats(0.0, 0.4),
)
_AWAY = st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-0.9, 0.9)).filter(
    lambda away: np.hypot(away[0], away[1]) > 0.01
)


@given(st.integers(0, 10_000), _AWAY, _WINDOWS)
def test_all_points_are_in_the_window_and_two_at_opposite_edges(
    seed: int, away: tuple[float, float, float], window: Window
) -> None:
    points = np.random.default_rng(seed).uniform(-3, 5, (30, 3))
    direction = np.array(away)
    position, target = stand(points, direction, window)
    right, up, forward = axes(direction)
    np.testing.assert_allclose(np.cross(target - position, direction), 0, atol=1e-6)
    assert (target - position) @ direction < 0
    depth = (points - position) @ forward
    assert (depth > 0).all()
    half = np.tan(window.fov / 2)
    # from 0 at the left or lower edge of the picture to 1 at the other
    across = ((points - position) @ right / depth / half / window.aspect + 1) / 2
    height = ((points - position) @ up / depth / half + 1) / 2
    free = 1 - window.above - window.below
    assert across.min() >= 0
    assert across.max() <= 1
    assert height.min() >= window.below
    assert height.max() <= 1 - window.above
    assert max(np.ptp(across), np.ptp(height) / free) > 0.9
    assert holds(points, position, target, window)
    # a picture's width aside nothing is seen, nor behind the camera
    aside = (2.1 + seed % 3) * depth.max() * half * window.aspect * right
    assert not holds(points, position + aside, target + aside, window)
    assert not holds(points, position, 2 * position - target, window)


@given(st.integers(0, 10_000), _AWAY, _WINDOWS, st.floats(-2, 2))
def test_a_camera_is_lowered_no_more_than_the_points_need(
    seed: int, away: tuple[float, float, float], window: Window, above: float
) -> None:
    points = np.random.default_rng(seed).uniform(-3, 5, (30, 3))
    direction = np.array(away)
    _, up, _ = axes(direction)
    placed, seen = stand(points, direction, window)
    before, aimed = placed + above * up, seen + above * up
    position, target = lift(points, before, aimed, window)
    step = (before - position) @ up
    np.testing.assert_allclose(position, before - step * up, atol=1e-9)
    np.testing.assert_allclose(target - position, aimed - before, atol=1e-9)
    assert step >= 0
    if above >= 0:
        # where it stood all could be seen, no higher than is needed
        assert holds(points, position, target, window)
        assert (before - step * up - placed) @ up >= -1e-9
    again, _ = lift(points, position, target, window)
    np.testing.assert_allclose(again, position, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", scene_names())
def test_the_extent_holds_workspace_curve_and_arm(name: str) -> None:
    plan = planned(load_scene(name))
    points = extent(plan)
    low, high = points.min(axis=0) - 1e-9, points.max(axis=0) + 1e-9
    held = [np.array([plan.scene.workspace.min, plan.scene.workspace.max])]
    if plan.motion is not None and plan.arm is not None:
        held.append(plan.motion.tool[[0, -1]])
        held.append(plan.arm.place(plan.motion.positions[:1]).reshape(-1, 3))
    for part in held:
        assert (part >= low).all()
        assert (part <= high).all()
