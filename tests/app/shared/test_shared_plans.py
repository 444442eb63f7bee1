"""Plans that a class shares are those of equal scenes."""

from __future__ import annotations

import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest

from abi.planner.live_planner import LivePlanner
from abi.planner.plan import Plan
from abi.planner.planner import plan
from abi.progress import CancelledError
from abi.scene.scene import Scene, load_scene
from app.panels.plan_sentence import plan_sentence
from app.shared.shared_plans import SharedPlans
from app.state.frame import Frame
from app.tab.planner import TabPlanner
from tests.kernel_forms import kernels_as


def test_a_plan_is_found_by_an_equal_scene_only() -> None:
    plans, made = SharedPlans(), plan(load_scene("two-boxes"))
    plans.keep(made.scene, made)
    assert plans.find(load_scene("two-boxes")) is made
    assert plans.find(made.scene.replace(goal=(0.5, 0.5, 0.5))) is None


def test_a_full_plan_goes_before_a_newer_partial_one() -> None:
    plans, made = SharedPlans(), plan(load_scene("two-boxes"))
    hasty = replace(made, partial=True)
    plans.keep(made.scene, hasty)
    assert plans.find(made.scene, full=True) is None
    plans.keep(made.scene, made)
    plans.keep(made.scene, hasty)
    assert plans.find(made.scene) is made


def test_one_tab_of_many_plans_a_scene_in_full() -> None:
    plans, scene = SharedPlans(), load_scene("two-boxes")
    with plans.claim(scene) as first, plans.claim(load_scene("two-boxes")) as second:
        assert (first, second) == (True, False)
        with plans.claim(scene.replace(goal=(0.5, 0.5, 0.5))) as other:
            assert other
    # also after a fault
    with pytest.raises(MemoryError), plans.claim(scene):
        raise MemoryError
    with plans.claim(scene) as again:
        assert again


class Slow(LivePlanner):
    """Planner that is let go on."""

    def __init__(self, made: Plan) -> None:
        super().__init__()
        self.made, self.begun, self.go_on = made, threading.Event(), threading.Event()

    def __call__(self, scene: Scene) -> Plan:
        self.begun.set()
        assert self.go_on.wait(60)
        return self.made


def test_a_planner_takes_what_another_is_planning() -> None:
    plans, scene = SharedPlans(), load_scene("two-boxes")
    one, other = (TabPlanner(k, print) for k in range(2))
    one.live = slow = Slow(plan(scene))
    other.live = Slow(plan(scene))
    with ThreadPoolExecutor(2) as pool:
        first = pool.submit(one, scene, plans)
        assert slow.begun.wait(60)
        second = pool.submit(other, load_scene("two-boxes"), plans)
        slow.go_on.set()
        assert first.result(60) is second.result(60) is slow.made
    assert not other.live.begun.is_set()


def test_a_planner_that_waits_for_another_ends_once_something_else_is_chosen() -> None:
    plans, scene, planner = SharedPlans(), load_scene("two-boxes"), TabPlanner(1, print)
    planner.overtaken = True
    with plans.claim(scene), pytest.raises(CancelledError):
        planner(scene, plans)


def test_a_planner_takes_a_plan_as_incomplete_as_it_is() -> None:
    plans, made = SharedPlans(), plan(load_scene("two-boxes"))
    planner = TabPlanner(1, print)
    hasty = replace(made, coarse=True, partial=True)
    plans.keep(made.scene, hasty)
    assert planner.take(made.scene, plans) is hasty
    plans.keep(made.scene, made)
    assert planner.finish(made.scene, plans) is made


def test_a_planner_counts_its_own_time_and_not_that_in_which_others_have_the_processor() -> None:
    scene, planner = load_scene("two-boxes"), TabPlanner(1, print)
    made = plan(scene)

    class Waiting(LivePlanner):
        def __call__(self, scene: Scene) -> Plan:
            time.sleep(0.2)
            return made

    class Working(LivePlanner):
        def __call__(self, scene: Scene) -> Plan:
            begin = time.thread_time()
            while time.thread_time() - begin < 0.2:
                pass
            return made

    planner.live = Waiting()
    planner(scene, None)
    assert planner.processor_ms < 100
    planner.live = Working()
    planner(scene, None)
    assert planner.processor_ms >= 200


def test_no_time_is_told_of_what_ran_before_it_was_compiled() -> None:
    planner, scene = TabPlanner(0, print), load_scene("two-boxes")
    with kernels_as(compiled=False):
        slow = planner(scene, None)
    assert slow.total_ms == 0
    assert not any(slow.ms[name] for name in slow.interpreted)
    assert slow.ms["timing"] > 0  # it has no kernel
    assert " in " not in plan_sentence(Frame(slow))
    with kernels_as(compiled=True):
        other = planner(scene.replace(spline={"degree": 2}), None)
        moved = planner(scene.replace(goal=(0.5, 0.5, 0.5)), None)
        remeshed = planner(scene.replace(mesh={"pitch": 0.7}), None)
    assert other.path is slow.path  # searched once, and no second time for its time
    assert other.ms["a_star"] == 0 < other.ms["bspline"]
    assert other.total_ms > 0
    assert moved.ms["a_star"] > 0
    assert moved.interpreted <= {"mesh"}  # which is the same
    assert not remeshed.interpreted
    assert remeshed.ms["mesh"] > 0
