"""A plan is diagnosed once, however many tabs show it, and by another tab where one gives up."""

from __future__ import annotations

import threading
from dataclasses import replace

import numpy as np
import pytest

from abi.explain.reason import Reason
from abi.planner.plan import Plan
from abi.planner.planner import Planner
from abi.scene.scene import Scene, load_scene
from app.shared import diagnoses
from app.shared.diagnoses import diagnose, reason_of

BECAUSE = Reason("because", "do that", None, np.zeros((0, 3)))


@pytest.fixture(scope="module")
def made() -> Plan:
    return Planner(compile=False)(load_scene("no-way"))


@pytest.fixture
def failed(made: Plan) -> Plan:
    """A plan that failed, of which nothing is known yet."""
    return replace(made)


def test_all_tabs_are_told_what_one_has_found(
    failed: Plan, monkeypatch: pytest.MonkeyPatch
) -> None:
    explained: list[Plan] = []

    def explain(scene: Scene, plan: Plan, cancelled: object) -> Reason:
        explained.append(plan)
        return BECAUSE

    monkeypatch.setattr(diagnoses, "explain", explain)
    assert reason_of(failed) is None
    for _ in range(5):
        assert diagnose(failed, lambda: False)
        assert reason_of(failed) is BECAUSE
    assert explained == [failed]


def test_one_tab_is_at_it_and_another_after_it_was_interrupted(
    failed: Plan, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked, go_on = threading.Event(), threading.Event()

    def explain(scene: Scene, plan: Plan, cancelled: object) -> Reason:
        asked.set()
        assert go_on.wait(30.0)
        return BECAUSE

    monkeypatch.setattr(diagnoses, "explain", explain)
    answers: list[bool] = []
    first = threading.Thread(target=lambda: answers.append(diagnose(failed, lambda: True)))
    first.start()
    assert asked.wait(30.0)
    assert not diagnose(failed, lambda: False)
    go_on.set()
    first.join()
    assert answers == [False]
    assert diagnose(failed, lambda: False)
    assert reason_of(failed) is BECAUSE


def test_a_fault_leaves_it_to_others(failed: Plan, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(diagnoses, "explain", lambda *_: [][0])
        with pytest.raises(IndexError):
            diagnose(failed, lambda: False)
    assert diagnose(failed, lambda: False)
    reason = reason_of(failed)
    assert reason is not None
    assert reason.message
