"""A motion of a shipped arm, as a second simulator follows it."""

from __future__ import annotations

import pytest

from abi.planner.planner import plan
from abi.scene.scene import load_scene


def test_pybullet_follows_a_plan_to_a_tenth_of_a_millimetre_and_touches_nothing() -> None:
    pytest.importorskip("pybullet", reason="PyBullet has no wheel for this machine")
    from benchmarks.in_pybullet import follow  # here, since it imports PyBullet

    found = plan(load_scene("kitchen-ur5e"))
    assert found.error is None
    followed = follow(found)
    assert float(str(followed["error"])) < 0.1
    assert followed["links"] == "none"
