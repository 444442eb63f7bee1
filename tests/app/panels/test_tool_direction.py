"""The direction of a tool, and the part of a motion that keeps it, as they are set in a tab."""

from __future__ import annotations

import math

import pytest

from abi.arm_planning.joint_search.held_span import HeldSpan
from abi.robot.urdf_arm import UrdfArm
from abi.scene.held_axis import HeldAxis
from app.panels.stages.arm_model import ArmModelPanel
from app.tab.session import Session
from app.ui.time_bar import bar_style
from tests.app.fake_tab import FakeTab, until


def panel(session: Session) -> ArmModelPanel:
    return session.panels.stages.arm.model


@pytest.mark.slow
def test_an_angle_and_a_part_are_set_kept_and_left_with_the_arm(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    fake.set(session.panels.files.choice, "kitchen-ur5e")
    until(lambda: session.plan is not None and isinstance(session.plan.arm, UrdfArm))
    until(lambda: session.resting)
    box = panel(session)
    assert (box.direction.value, box.within.visible, box.part.visible) == ("down", True, False)

    fake.set(box.within, 8.0)
    fake.set(box.part, (0.0, 35.0))
    until(lambda: session.plan is not None and session.plan.scene.arm.held_axis is not None)
    until(lambda: session.resting and box.part.visible)
    plan = session.plan
    assert plan is not None
    held = plan.scene.arm.held_axis
    assert held is not None
    assert held.direction == (0.0, 0.0, -1.0)
    assert (held.tolerance, held.begin, held.end) == pytest.approx((math.radians(8), 0.0, 0.35))
    assert plan.error is None, plan.error
    assert len(plan.held_spans) == 1

    # what is shown is rounded, what is kept is not
    scene = plan.scene.replace(arm={"axis": {**held.model_dump(), "tolerance": 0.1234567}})
    box.write(scene)
    assert session.panels.read(scene) == scene
    assert HeldAxis.model_validate(box.read()["axis"]) == scene.arm.axis

    fake.set(box.model, "the paper's arm")
    until(lambda: session.plan is not None and session.plan.scene.arm.model == "abi")
    assert session.panels.refused is None
    assert session.plan is not None
    assert session.plan.scene.arm.axis is None


def test_the_time_bar_has_a_line_where_the_direction_is_kept() -> None:
    span = HeldSpan(first=1.0, last=3.0, angle=0.0, bound=0.0, tolerance=0.1)
    drawn = bar_style((), 4.0, (span,))
    # half as wide as the bar, its left end at a quarter of it
    assert "50.00% 100%/50.00% 2px" in drawn
    assert "abi-track" in drawn
    assert not bar_style((), 4.0)
