from __future__ import annotations

import gc
import weakref

import pytest

from abi.planner.live_planner import LivePlanner
from abi.planner.node_budget import LEAST_NODES
from tests.abi.planner.test_node_budget import nodes, scene_of


def test_a_plan_without_a_path_says_nothing() -> None:
    scene = scene_of(0.25)
    live = LivePlanner()
    live(scene)
    before = live.budget.nodes
    for k in range(10):
        blocked = live(scene.replace(start=[3.0, 3.0, 2.5 + 0.01 * k]))
        assert blocked.error is not None
    assert live.budget.nodes == before


def test_in_haste_one_search_runs_on_a_coarser_mesh_and_then_all_on_the_whole() -> None:
    planner, scene = LivePlanner(), scene_of(0.3)
    planner.budget.nodes = LEAST_NODES
    hasty = planner(scene)

    assert hasty.coarse
    assert hasty.partial
    assert hasty.error is None
    assert hasty.mesh is not None
    assert len(hasty.mesh.points) <= LEAST_NODES
    assert [found.algorithm for found in hasty.searches] == [scene.search.algorithm]

    whole = planner.finish(scene)
    assert not whole.coarse
    assert not whole.partial
    assert whole.mesh is not None
    assert len(whole.mesh.points) == nodes(scene)
    assert len(whole.searches) == 3

    # what does not touch the path needs no coarser mesh
    faster = planner(scene.replace(motion={"speed": 5}))
    assert not faster.coarse
    assert faster.quadratic is whole.quadratic
    assert faster.profile is not None
    assert faster.profile.peak_speed == pytest.approx(5)


def test_in_haste_one_search_may_do_on_the_whole_mesh_and_the_rest_keeps_it() -> None:
    planner, scene = LivePlanner(), scene_of(0.3)
    planner.budget.nodes = nodes(scene)
    hasty = planner(scene)

    assert hasty.partial
    assert not hasty.coarse
    assert [found.algorithm for found in hasty.searches] == [scene.search.algorithm]

    whole = planner.finish(scene)
    assert not whole.partial
    assert len(whole.searches) == 3
    assert whole.path is hasty.path
    assert whole.bspline is hasty.bspline


def test_what_is_quick_is_planned_with_all_searches() -> None:
    planner, scene = LivePlanner(), scene_of(1.3)
    plan = planner(scene)
    assert len(plan.searches) == 3
    assert not plan.partial


def test_what_was_planned_is_freed_once_it_is_forgotten_and_planned_the_same_again() -> None:
    planner, scene = LivePlanner(), scene_of(0.6)
    plan = planner.finish(scene)
    assert plan.path is not None
    assert plan.bspline_arc is not None
    points, length, nodes_learnt = plan.path.points, plan.bspline_arc.length, planner.budget.nodes
    kept = weakref.ref(plan.graph)
    del plan
    gc.collect()
    assert kept() is not None

    planner.forget()
    gc.collect()
    assert kept() is None
    assert planner.budget.nodes == nodes_learnt
    again = planner(scene)
    assert again.path is not None
    assert again.bspline_arc is not None
    assert again.path.points.tolist() == points.tolist()
    assert again.bspline_arc.length == length
