"""Joints at start and goal, as they are typed in a tab."""

from __future__ import annotations

import math

import numpy as np
import pytest
import viser

from abi.robot.urdf_arm import UrdfArm
from app.panels.stages.end_text import End
from app.tab.session import Session
from tests.app.fake_tab import FakeTab, until

JOINTS = "115, -80, 110, -126, -86, 23"


def ends(session: Session) -> dict[End, viser.GuiTextHandle]:
    return session.panels.stages.arm.ends


@pytest.mark.slow
def test_joints_are_typed_shown_kept_and_left_once_their_end_is_moved(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    fake.set(session.panels.files.choice, "kitchen-ur5e")
    until(lambda: session.plan is not None and isinstance(session.plan.arm, UrdfArm))
    until(lambda: session.resting)
    assert not ends(session)["start"].value
    fake.set(session.panels.stages.arm.model.direction, "any")
    until(lambda: session.plan is not None and session.plan.scene.arm.axis is None)

    fake.set(ends(session)["start"], JOINTS)
    until(lambda: session.plan is not None and session.plan.scene.arm.start is not None)
    until(lambda: session.resting)
    plan = session.plan
    assert plan is not None
    asked = np.radians([float(word) for word in JOINTS.split(", ")])
    assert plan.scene.arm.start is not None
    assert plan.scene.arm.start.joints == pytest.approx(asked)
    assert plan.motion is not None
    assert plan.motion.positions[0] == pytest.approx(asked)
    assert ends(session)["start"].value == JOINTS
    # what is shown is rounded, what is kept is not
    assert session.panels.read(plan.scene) == plan.scene

    fake.drag(session.panels.ends.gizmos["start"], [-0.3, 0.45, 0.3])
    until(lambda: session.plan is not None and session.plan.scene.start == (-0.3, 0.45, 0.3))
    until(lambda: session.resting)
    assert session.plan is not None
    assert session.plan.scene.arm.start is None
    assert not ends(session)["start"].value
    assert session.panels.read(session.plan.scene) == session.plan.scene


@pytest.mark.slow
def test_text_is_joints_a_state_or_nothing(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    fake.set(session.panels.files.choice, "kitchen-ur5e")
    until(lambda: session.plan is not None and isinstance(session.plan.arm, UrdfArm))
    until(lambda: session.resting)
    fake.set(session.panels.stages.arm.model.direction, "any")
    until(lambda: session.plan is not None and session.plan.scene.arm.axis is None)
    box = ends(session)["goal"]
    for text, read in (
        ("10, 20", {"joints": [math.radians(10), math.radians(20)]}),
        ("home", {"state": "home"}),
    ):
        fake.set(box, text)
        until(lambda read=read: session.panels.stages.arm.read()["arm"]["goal"] == read)  # type: ignore[misc]
        until(lambda: session.panels.refused is not None)
        assert "arm.goal" in str(session.panels.refused)
