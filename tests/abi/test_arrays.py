"""Short texts of results that hold arrays."""

from __future__ import annotations

import dataclasses

import pytest

import abi
from abi.obstacles.obstacle_set import ObstacleSet

LONGEST = 400
"""Letters that fit a few lines of a terminal."""


@pytest.mark.parametrize("name", ["paper", "two-boxes"])
def test_every_result_prints_as_one_line(name: str) -> None:
    scene = abi.load_scene(name)
    plan = abi.Planner(compile=False)(scene)
    assert plan.bspline is not None
    assert plan.arm_clearance is not None
    results = [getattr(plan, field.name) for field in dataclasses.fields(plan)]
    results += [*plan.searches, plan.bspline.clearance, plan.bspline.clearance.certificate]
    results += [plan.arm_clearance.certificate, ObstacleSet(scene.obstacles), plan.joint_rates]
    for result in results:
        if dataclasses.is_dataclass(result):
            assert "\n" not in repr(result)
            assert len(repr(result)) < LONGEST


def test_a_plan_prints_its_length_or_why_there_is_none() -> None:
    plan = abi.Planner(compile=False)(abi.load_scene("paper"))
    assert plan.followed_arc is not None
    assert f"{plan.followed_arc.length:.4g} cm" in repr(plan)
    assert "proven clear" in repr(plan)
    blocked = abi.Planner(compile=False)(abi.load_scene("no-way"))
    assert str(blocked.error) in repr(blocked)


def test_a_clearance_prints_its_distance() -> None:
    plan = abi.Planner(compile=False)(abi.load_scene("paper"))
    assert plan.bspline is not None
    assert f"distance={plan.bspline.clearance.distance:.6g}" in repr(plan.bspline.clearance)
