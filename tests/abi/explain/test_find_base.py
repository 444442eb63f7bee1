"""The best base found in a region, beside plans that are made anew at every place."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

import abi
from abi.arm_planning.arm_errors import (
    ArmNotClear,
    direction_not_held,
    no_joint_motion,
    out_of_reach,
)
from abi.errors import StageError
from abi.explain.base_map import BaseMap, BaseTrial
from abi.explain.find_base import _tried, base_maps, default_region, find_base
from abi.planner.plan import Plan
from abi.planner.task_plan import plan_tasks
from tests.abi.planner.test_tasks import BASE, FILES, JOINTS, data

_LOW, _HIGH = (-4.0, -6.0, 0.0), (10.0, 10.0, 0.0)


@pytest.fixture(scope="module")
def scene() -> abi.Scene:
    return abi.load_scene("find-a-base").replace(mesh={"pitch": 1.0})


@pytest.fixture(scope="module")
def found(scene: abi.Scene) -> BaseMap:
    return find_base(scene, _LOW, _HIGH)


def _planned(scene: abi.Scene, trial: BaseTrial) -> float | None:
    """Length of a certified plan from a place, by a planner that remembers nothing."""
    plan = abi.plan(scene.replace(arm={"base": list(trial.base)}))
    if plan.error is not None or plan.arm_clearance is None or plan.motion is None:
        return None
    assert plan.followed_curve is not None
    certified = plan.arm_clearance.certified and plan.followed_curve.holds
    if not (certified and plan.motion.within_limits):
        return None
    arc = plan.followed_arc
    assert arc is not None
    return arc.length


def test_lengths_are_those_of_plans_made_anew(scene: abi.Scene, found: BaseMap) -> None:
    with_plan = [trial for trial in found.trials if trial.length is not None]
    without = [trial for trial in found.trials if trial.length is None]
    assert with_plan
    assert without
    for trial in with_plan[::9]:
        assert _planned(scene, trial) == pytest.approx(trial.length, rel=1e-9)
    for trial in without[::9]:
        assert _planned(scene, trial) is None


def test_none_tried_is_better_than_the_best(scene: abi.Scene, found: BaseMap) -> None:
    assert found.is_done
    assert found.best is not None
    assert found.best.length is not None
    assert all(t.length is None or t.length >= found.best.length for t in found.trials)
    assert _planned(scene, found.best) is not None
    assert abi.plan(scene).error is not None, "the scene's own base is no remedy"


def test_finer_cells_do_not_lose_what_coarse_ones_found(scene: abi.Scene, found: BaseMap) -> None:
    maps = list(base_maps(scene, _LOW, _HIGH))
    lengths = [m.best.length for m in maps if m.best is not None and m.best.length is not None]
    assert lengths == sorted(lengths, reverse=True)
    assert [len(m.trials) for m in maps[:-1]] == list(range(1, len(maps)))


def test_cells_cover_the_region_once(found: BaseMap) -> None:
    area = np.prod(np.subtract(_HIGH, _LOW)[:2])
    assert sum(cell.cell[0] * cell.cell[1] for cell in found.cells) == pytest.approx(float(area))
    for one, other in itertools.combinations(found.cells, 2):
        apart = np.abs(np.subtract(one.base, other.base))[:2]
        touching = np.add(one.cell, other.cell)[:2] / 2
        # places are rounded to a hundredth of a cell
        assert (apart > 0.98 * touching).any()


def test_reasons_are_counted(found: BaseMap) -> None:
    assert sum(found.faults.values()) == sum(t.length is None for t in found.trials)
    assert "" not in found.faults


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (out_of_reach(0.0, 1.0, 0.1, None), "out of reach on the way"),
        (ArmNotClear("Here", "goal", "a", 0), "a link in the way at the goal"),
        (no_joint_motion("goal", "a", 0), "a link in the way at the goal"),
        (no_joint_motion("start"), "out of reach at the start"),
        (no_joint_motion("path"), "no path for the whole arm"),
        (no_joint_motion("curve"), "no curve proven clear"),
        (no_joint_motion("same"), "the joints at the goal already"),
        (direction_not_held("start", 0.1, (0.0, 1.0)), "the direction not kept at the start"),
        (direction_not_held("path", 0.1, (0.0, 1.0)), "no motion that keeps the direction"),
        (StageError("timing", "too_slow", "Slow.", "Go."), "too slow"),
    ],
)
def test_a_reason_is_that_of_the_plan(scene: abi.Scene, error: StageError, reason: str) -> None:
    def planner(scene: abi.Scene, chosen_only: bool) -> Plan:
        return Plan(scene=scene, error=error)

    tried = _tried([planner], scene, BaseTrial((0.0, 0.0, 0.0), (1.0, 1.0, 0.0)))  # type: ignore[list-item]
    assert isinstance(tried, BaseTrial)
    assert tried.fault == reason


def test_a_tool_without_a_path_is_told_at_once() -> None:
    scene = abi.load_scene("no-way")
    found = find_base(scene, *default_region(scene))
    assert found.is_done
    assert found.best is None
    assert found.fault == getattr(abi.plan(scene).error, "message", None)


def test_it_stops_when_it_is_told_to(scene: abi.Scene) -> None:
    calls = itertools.count(1)
    found = find_base(scene, _LOW, _HIGH, lambda: next(calls) == 3)
    assert len(found.trials) == 3
    assert not found.is_done


@pytest.mark.parametrize(
    ("low", "high", "field"),
    [
        ((0.0, 0.0, 0.0), (1.0, -1.0, 0.0), "region.high"),
        ((float("nan"), 0.0, 0.0), (1.0, 1.0, 0.0), "region.low"),
        ((0.0, 0.0), (1.0, 1.0, 0.0), "region.low"),
        ("123", (1.0, 1.0, 0.0), "region.low is '123'"),
        (("a", 0.0, 0.0), (1.0, 1.0, 0.0), "region.low"),
        ((0.0, 0.0, 0.0), None, "region.high is None"),
    ],
)
def test_a_wrong_corner_is_named(scene: abi.Scene, low: Any, high: Any, field: str) -> None:
    with pytest.raises(abi.SceneError, match=field):
        find_base(scene, low, high)


@pytest.mark.slow
def test_a_region_may_be_a_line_or_a_point(scene: abi.Scene, found: BaseMap) -> None:
    assert found.best is not None
    point = find_base(scene, found.best.base, found.best.base)
    assert {trial.base for trial in point.trials} == {found.best.base}
    assert point.best is not None
    line = find_base(scene, (-4.0, 8.0, 0.0), (10.0, 8.0, 0.0), lambda: False)
    assert all(trial.base[1:] == (8.0, 0.0) for trial in line.trials)


@pytest.mark.slow
def test_a_large_mesh_is_tried_on_a_coarser_one_and_confirmed(
    scene: abi.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("abi.explain.find_base.MOST_NODES", 150)
    found = find_base(scene, (2.0, 8.0, 0.0), (4.0, 8.0, 0.0))
    assert found.best is not None
    assert _planned(scene, found.best) == pytest.approx(found.best.length, rel=1e-9)


def test_an_arm_that_goes_from_joints_to_joints_is_ranked_by_the_way_of_its_tool() -> None:
    kitchen = abi.load_scene("kitchen-ur5e").replace(obstacles=[])
    pose = [0.5, -1.4, 1.2, -1.0, -1.5, 0.0]
    ends = {"start": {"joints": pose}, "goal": {"joints": [0.2, *pose[1:]]}}
    scene = kitchen.replace(arm={**ends, "axis": None})
    place = scene.arm.base
    found = find_base(scene, place, place)
    motion = abi.plan(scene).motion
    assert found.best is not None
    assert motion is not None
    way = np.linalg.norm(np.diff(motion.tool, axis=0), axis=1).sum()
    assert found.best.length == pytest.approx(way, rel=0.05)


@pytest.mark.parametrize("beyond", [None, 2])
def test_of_tasks_a_base_is_one_for_all_legs(beyond: int | None) -> None:
    tasks: list[dict[str, Any]] = [{"goal": {"joints": joints}} for joints in JOINTS[1:]]
    if beyond is not None:
        tasks[beyond] = {"goal": [2.9, 2.9, 2.9]}
    scene = abi.Scene.from_dict(data(tasks=tasks), FILES)
    found, planned = find_base(scene, BASE.tolist(), BASE.tolist()), plan_tasks(scene)
    if beyond is not None:
        assert found.best is None
        assert planned.error is not None
        assert [*found.faults] == [f"out of reach at the goal (leg {beyond + 1})"]
        return
    # beyond the workspace's side, over which joints take the tool
    aside = find_base(scene, (2.9, 0.0, 1.0), (2.9, 0.0, 1.0))
    assert [*aside.faults] == ["start outside the workspace"]
    assert found.best is not None
    assert planned.trajectory is not None
    way = np.linalg.norm(np.diff(planned.trajectory.tool, axis=0), axis=1).sum()
    assert found.best.length == pytest.approx(way, rel=0.05)
