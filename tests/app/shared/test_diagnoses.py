"""A plan is diagnosed once, however many tabs show it, and by another tab where one gives up."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from abi.explain.reason import Reason
from abi.planner.plan import Plan
from abi.planner.planner import Planner
from abi.scene.scene import Scene, load_scene
from app.shared import diagnoses
from app.shared.diagnoses import Diagnoses

BECAUSE = Reason("because", "do that", None, np.zeros((0, 3)))


@pytest.fixture(scope="module")
def failed() -> Plan:
    return Planner(compile=False)(load_scene("no-way"))


def test_all_tabs_are_told_what_one_has_found(
    failed: Plan, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[Plan] = []

    def explain(scene: Scene, plan: Plan, cancelled: object) -> Reason:
        made.append(plan)
        return BECAUSE

    monkeypatch.setattr(diagnoses, "explain", explain)
    kept = Diagnoses()
    assert kept.reason(failed) is None
    for _ in range(5):
        assert kept.make(failed, lambda: False)
        assert kept.reason(failed) is BECAUSE
    assert made == [failed]


def test_one_tab_is_at_it_and_another_after_it_was_interrupted(
    failed: Plan, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept, asked, go_on = Diagnoses(), threading.Event(), threading.Event()

    def explain(scene: Scene, plan: Plan, cancelled: object) -> Reason:
        asked.set()
        assert go_on.wait(30.0)
        return BECAUSE

    monkeypatch.setattr(diagnoses, "explain", explain)
    answers: list[bool] = []
    first = threading.Thread(target=lambda: answers.append(kept.make(failed, lambda: True)))
    first.start()
    assert asked.wait(30.0)
    assert not kept.make(failed, lambda: False)
    go_on.set()
    first.join()
    assert answers == [False]
    assert kept.make(failed, lambda: False)
    assert kept.reason(failed) is BECAUSE


def test_a_fault_leaves_it_to_others(failed: Plan, monkeypatch: pytest.MonkeyPatch) -> None:
    kept = Diagnoses()
    with monkeypatch.context() as patch:
        patch.setattr(diagnoses, "explain", lambda *_: [][0])
        with pytest.raises(IndexError):
            kept.make(failed, lambda: False)
    assert kept.make(failed, lambda: False)
    reason = kept.reason(failed)
    assert reason is not None
    assert reason.message
