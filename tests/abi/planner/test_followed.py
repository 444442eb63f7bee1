"""The shipped sequence of tasks, as a simulator follows it."""

from __future__ import annotations

import numpy as np
import pytest

from abi.planner.task_plan import plan_tasks
from abi.scene.scene import load_scene
from tests.simulator import follow

CARRIES = 3
"""Number of the leg on which the block is in the air from beginning to end."""
FINGERS = ("panda_finger_joint1", "panda_finger_joint2")


@pytest.mark.slow  # six plans of a real arm, and twelve seconds in steps of a millisecond
def test_mujoco_follows_the_tasks_to_a_millimetre_without_contact_but_the_grasp() -> None:
    plan = plan_tasks(load_scene("pick-and-place"))
    assert plan.error is None, plan.error

    followed = follow(plan, FINGERS)

    assert followed.error < 1e-3
    assert {one for _, one, _ in followed.contacts} == {"block"}, followed.contacts
    fingers = {"panda_leftfinger", "panda_rightfinger"}
    for leg in range(len(plan.legs)):
        touched = {other for number, _, other in followed.contacts if number == leg}
        grasps = plan.legs[leg].scene.arm.attached is not None
        assert touched <= (fingers | {"world"} if grasps else {"world"})
        assert not grasps or touched & fingers
        assert leg != CARRIES or "world" not in touched
    left = plan.legs[-1].scene.obstacles[2].position
    np.testing.assert_allclose(followed.block, left, atol=1e-3)
