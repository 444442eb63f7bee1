"""How often a motion is sampled, and motions that take too long."""

from __future__ import annotations

import re

import numpy as np
import pytest

from abi.errors import SceneError, StageError
from abi.planner.plan import Plan
from abi.planner.planner import Planner, plan
from abi.planner.slow_motion import refuse_slow
from abi.scene.scene import load_scene
from abi.verify.verify import verify


def test_a_motion_has_the_samples_or_the_time_step_that_are_asked_for() -> None:
    planner, scene = Planner(), load_scene("paper").replace(motion={"curve": "bspline"})
    usual = planner(scene).profile
    assert usual is not None
    for law in ("three_phase", "slowed", "time_optimal", "jerk_limited"):
        few = planner(scene.replace(motion={"law": law, "samples": 7})).motion
        stepped = planner(scene.replace(motion={"law": law, "time_step": 0.032}))
        assert few is not None
        assert len(few.time) == 7
        assert stepped.motion is not None
        assert stepped.profile is not None
        time = stepped.motion.time
        np.testing.assert_allclose(time, 0.032 * np.arange(len(time)), atol=1e-12)
        assert few.time[-1] <= stepped.profile.duration < few.time[-1] + 0.032 + 1e-9
        assert all(one.proven for one in verify(stepped.to_dict()) if one.curve == "bspline")


def test_the_arm_is_proven_with_a_time_step_where_it_is_without() -> None:
    scene = load_scene("arm-in-the-way").replace(motion={"time_step": 0.05})
    assert all(one.proven for one in verify(plan(scene).to_dict()) if one.curve == "arm")


def test_samples_beside_a_step_and_too_many_are_refused() -> None:
    scene = load_scene("paper")
    with pytest.raises(SceneError, match="time_step"):
        scene.replace(motion={"samples": 9, "time_step": 0.1})

    error = plan(scene.replace(motion={"time_step": 1e-5})).error
    assert error is not None
    assert error.kind == "too_many_samples"
    step = float(error.hint.split()[-2])
    assert plan(scene.replace(motion={"time_step": step})).error is None


def test_a_motion_slowed_down_beyond_use_is_refused_and_a_slow_one_that_is_asked_for_is_not() -> (
    None
):
    arm = {"forces": [0.0, 0.0, 0.0]}
    scene = load_scene("paper").replace(motion={"curve": "bspline"}, arm=arm)
    slow = plan(scene.replace(motion={"speed": 0.01}))
    assert slow.error is None
    assert slow.profile is not None
    assert slow.profile.duration > 600
    assert slow.arm is not None
    unasked = Plan(scene, arm=slow.arm, profile=slow.profile, motion=slow.motion)

    with pytest.raises(StageError) as refusal:
        refuse_slow(unasked)

    assert refusal.value.kind == "too_slow"
    assert f"{slow.profile.duration:.0f} s" in refusal.value.message
    assert re.search(r"for a way of \d+(\.\d+)? cm,", refusal.value.in_unit("cm").message)
    refuse_slow(slow)
