"""Another choice ends the plan of the last one, and what is drawn meanwhile is true of the new."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import pytest

from abi import progress
from abi.planner.live_planner import LivePlanner
from abi.planner.plan import Plan
from abi.scene.scene import Scene
from app.layers.arm.arm import ArmLayer
from app.layers.mesh import MeshLayer
from app.tab.session import Session
from tests.app.fake_tab import FakeTab, layer, until

_SLOW, _SLOW_DEGREE = "forest", 5


@pytest.fixture
def ended(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Moments at which a plan of the slow scene or degree was ended, [s]; nothing else ends it."""
    moments: list[float] = []
    plan: Callable[[LivePlanner, Scene], Plan] = LivePlanner.__call__

    def make(planner: LivePlanner, scene: Scene) -> Plan:
        if len(scene.obstacles) < 5 and scene.spline.degree != _SLOW_DEGREE:
            return plan(planner, scene)
        progress.tell("never ending")
        while True:
            threading.Event().wait(0.005)
            try:
                progress.check()
            except progress.CancelledError:
                moments.append(time.monotonic())
                raise

    monkeypatch.setattr(LivePlanner, "__call__", make)
    return moments


@pytest.mark.slow
def test_another_scene_ends_the_plan_of_the_last(
    tab: tuple[FakeTab, Session], ended: list[float]
) -> None:
    fake, session = tab
    until(lambda: session.resting)
    choice = session.panels.files.choice
    fake.set(choice, _SLOW)
    until(lambda: session._planner._said == "never ending")
    chosen = time.monotonic()
    fake.set(choice, "two-boxes")
    until(lambda: bool(ended))
    assert ended[0] - chosen < 0.3
    until(lambda: session.resting and len(session.frame.plan.scene.obstacles) == 2)
    assert session.frame.plan.error is None
    assert session._fault is None
    fake.set(choice, "paper")
    until(lambda: session.resting and len(session.frame.plan.scene.obstacles) == 1)


@pytest.mark.slow
def test_nothing_of_the_last_scene_stays_while_the_next_is_planned(
    tab: tuple[FakeTab, Session], ended: list[float]
) -> None:
    fake, session = tab
    until(lambda: session.resting)
    shown = session.panels.layout.overlay.shown
    fake.set(session.panels.files.choice, _SLOW)
    until(lambda: session._planner._said == "never ending")
    assert not layer(session, ArmLayer)._nodes.root.visible
    assert not any(cloud.visible for cloud in layer(session, MeshLayer)._clouds.values())
    assert "never ending" in shown["message"]
    # back to the scene before, which is not what was planned last
    plans = session.plans
    fake.set(session.panels.files.choice, "paper")
    until(lambda: session.plans > plans and session.resting)
    assert layer(session, ArmLayer)._nodes.root.visible
    assert "never ending" not in shown["message"]


@pytest.mark.slow
def test_no_verdict_stays_while_a_change_is_planned(
    tab: tuple[FakeTab, Session], ended: list[float]
) -> None:
    fake, session = tab
    until(lambda: session.resting)
    heading = session.panels.layout.folders["arm"]
    assert heading.label != "6 · Arm — planning …"
    fake.set(session.panels.stages.fields["spline.degree"], _SLOW_DEGREE)
    until(lambda: session._planner._said == "never ending")
    until(lambda: heading.label == "6 · Arm — planning …" and session.frame.outdated)
    fake.set(session.panels.files.choice, "two-boxes")
    until(lambda: session.resting and len(session.frame.plan.scene.obstacles) == 2)
    assert heading.label != "6 · Arm — planning …"
