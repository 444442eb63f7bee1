"""A planner's memory, and its limits."""

from __future__ import annotations

import gc
import threading
import weakref
from functools import partial
from typing import Any

import pytest

from abi import compiling
from abi.arm_planning.branch.arm_branch import JointPath
from abi.arm_planning.motion_law import motion_law
from abi.curves import fit_bspline
from abi.curves.cubic_profile import PathProfile
from abi.errors import StageError
from abi.planner import tool_branch
from abi.planner.branch import Branch
from abi.planner.planner import Planner
from abi.scene.scene import load_scene
from abi.scene.settings import MotionSettings
from abi.search.search import SEARCHES


def test_a_stage_that_broke_is_run_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also with what it was given before it broke, and had a result for."""
    fit = fit_bspline.fit

    def fails_at_degree_3(points: object, degree: int, *rest: object) -> object:
        if degree == 3:
            raise MemoryError
        return fit(points, degree, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(fit_bspline, "fit", fails_at_degree_3)
    planner, scene = Planner(), load_scene("paper")
    first = planner(scene)
    with pytest.raises(MemoryError):
        planner(scene.replace(spline={"degree": 3}))
    again = planner(scene)

    assert again.error is None
    assert first.bspline_arc is not None
    assert again.bspline_arc is not None
    assert again.bspline_arc.length == first.bspline_arc.length


def test_what_the_machine_does_meanwhile_is_not_a_searchs_time() -> None:
    kept_from_it = 0.05  # [s]

    def search(*args: Any, **named: Any) -> Any:
        threading.Event().wait(kept_from_it)
        return SEARCHES["a_star"](*args, **named)

    plan = Planner(searches={**SEARCHES, "a_star": search})(load_scene("paper"))
    assert plan.error is None
    assert plan.ms["a_star"] < 1e3 * kept_from_it
    assert plan.total_ms > 1e3 * kept_from_it


def test_calls_from_several_threads_take_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    fit, together = fit_bspline.fit, threading.Barrier(2)
    met: list[bool] = []

    def waits_for_another(*args: Any) -> Any:
        try:
            together.wait(0.2)
            met.append(True)
        except threading.BrokenBarrierError:
            together.reset()
        return fit(*args)

    monkeypatch.setattr(fit_bspline, "fit", waits_for_another)
    planner, plans = Planner(), {}

    def plans_at(degree: int) -> None:
        plans[degree] = planner(load_scene("paper").replace(spline={"degree": degree}))

    threads = [threading.Thread(target=plans_at, args=(degree,)) for degree in (3, 4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not met
    for degree, found in plans.items():
        assert found.bspline is not None
        assert found.bspline.curve.degree == degree


def test_the_time_of_the_timing_is_that_of_the_law_that_made_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    took = 0.05  # [s]

    def slow_law(joint_path: JointPath, asked: MotionSettings) -> PathProfile:
        threading.Event().wait(took if asked.law == "slowed" else 0.0)
        return motion_law(joint_path, asked)

    monkeypatch.setattr(tool_branch, "motion_law", slow_law)
    made, scene = Planner(), load_scene("paper")
    slowed = scene.replace(motion={"law": "slowed"})
    assert made(slowed).ms["timing"] >= 1e3 * took
    assert made(scene).ms["timing"] < 1e3 * took
    assert made(slowed).ms["timing"] >= 1e3 * took


def test_many_obstacles_wait_for_the_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []

    monkeypatch.setattr(compiling, "is_done", lambda: False)
    monkeypatch.setattr(compiling, "compile", lambda: calls.append(True))
    body = {"shape": "sphere", "radius": 0.001}
    scene = load_scene("paper")
    few, many = (
        [{**body, "position": [3 + 0.001 * k, 3, 3]} for k in range(count)] for count in (3, 301)
    )
    Planner()(scene.replace(obstacles=few))
    assert not calls
    Planner()(scene.replace(obstacles=many))
    assert calls


def test_the_first_plan_of_a_urdf_arm_waits_for_kept_kernels(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    calls: list[str] = []
    for name in ("begin", "wait_for_loading"):
        monkeypatch.setattr(compiling, name, partial(calls.append, name))

    def find_path(*_: object) -> None:
        calls.append("run")
        raise StageError("search", "no_path", "None.", "None.")

    monkeypatch.setattr(Branch, "find_path", find_path)
    scene = load_scene("paper")
    Planner()(scene)
    assert calls == ["wait_for_loading", "run", "begin"]
    calls.clear()
    Planner()(scene.replace(arm={"model": "urdf"}))
    assert calls[:3] == ["begin", "wait_for_loading", "run"]


def test_planners_of_one_box_share_its_mesh_while_one_has_it() -> None:
    # no planner of another test has this mesh
    scene = load_scene("paper").replace(mesh={"pitch": 1.3579})
    one, other = Planner(), Planner()
    mesh = one(scene).mesh
    assert other(scene).mesh is mesh
    assert other(scene.replace(mesh={"pitch": 0.9})).mesh is not mesh
    kept = weakref.ref(mesh)
    del one, other, mesh
    gc.collect()
    assert kept() is None


@pytest.mark.parametrize("unit", ["m", "cm", "mm"])
def test_errors_name_the_unit(unit: str) -> None:
    planner = Planner()
    scene = load_scene("paper").replace(unit=unit, goal=[3.0, 3.0, 3.0])
    blocked = planner(scene).error
    assert blocked is not None
    assert f"is 1 {unit} inside obstacle 1" in blocked.message == str(blocked)

    # the same error is remembered; the unit is the scene's all the same
    other = "m" if unit != "m" else "cm"
    again = planner(scene.replace(unit=other)).error
    assert again is not None
    assert f"is 1 {other} inside" in again.message
    assert f"is 1 {unit} inside" in blocked.message == str(blocked)
    assert type(again) is type(blocked)


def test_a_slide_that_ran_out_is_named() -> None:
    scene = load_scene("paper").replace(motion={"speed": 0.5})
    error = Planner()(scene).error
    assert error is not None
    assert error.kind == "out_of_reach"
    assert "too near to the shoulder" in error.message
    assert "slide would run to 26.4 cm, and it ends at 2.4 cm" in error.hint
