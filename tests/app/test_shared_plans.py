"""Plans that a class shares are those of equal scenes."""

from __future__ import annotations

import pytest

from abi import compiling
from abi.planner.planner import plan
from abi.scene.scene import load_scene
from app.shared_plans import SharedPlans


def test_a_plan_is_found_by_an_equal_scene_only(monkeypatch: pytest.MonkeyPatch) -> None:
    plans, made = SharedPlans(), plan(load_scene("two-boxes"))
    monkeypatch.setattr(compiling, "is_done", lambda: False)
    plans.keep(made)
    assert plans.find(load_scene("two-boxes")) is made
    assert plans.find(made.scene.replace(goal=(0.5, 0.5, 0.5))) is None
    # its times are those of code that was not compiled
    monkeypatch.setattr(compiling, "is_done", lambda: True)
    assert plans.find(made.scene) is None
