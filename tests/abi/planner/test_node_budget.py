from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.planner.live_planner import LivePlanner
from abi.planner.node_budget import FRAME_MS, LEAST_NODES, Pace
from abi.scene.scene import Scene, load_scene


def scene_of(pitch: float, lattice: str = "bcc") -> Scene:
    return load_scene("paper").replace(mesh={"pitch": pitch, "lattice": lattice})


def nodes(scene: Scene) -> int:
    return scene.mesh.node_count(scene.workspace)


@settings(max_examples=60, deadline=None)
@given(
    pitch=st.floats(0.07, 3),
    lattice=st.sampled_from(["bcc", "kuhn", "delaunay"]),
    budget=st.integers(LEAST_NODES, 1_000_000),
)
def test_a_mesh_that_is_too_fine_is_made_just_coarse_enough(
    pitch: float, lattice: str, budget: int
) -> None:
    pace = Pace()
    pace.nodes = budget
    scene = scene_of(pitch, lattice)
    coarser = pace.coarser(scene)
    if nodes(scene) <= budget:
        assert coarser is None
        return
    assert coarser is not None
    assert budget / 3 < nodes(coarser) <= budget
    assert coarser.model_copy(update={"mesh": scene.mesh}) == scene


@settings(max_examples=60, deadline=None)
@given(rate=st.floats(300, 60_000), pitch=st.floats(0.07, 0.2))
def test_it_learns_how_many_nodes_fit_a_frame_and_stays_there(rate: float, pitch: float) -> None:
    pace, scene = Pace(), scene_of(pitch)
    pitches = []
    for _ in range(40):
        made = pace.coarser(scene) or scene
        pitches.append(made.mesh.pitch)
        pace.took(nodes(made), nodes(made) / rate)
    # a steady hand sees a steady mesh
    assert len(set(pitches[-10:])) == 1
    assert nodes(made) <= max(2 * rate * FRAME_MS, LEAST_NODES)
    assert nodes(made) >= min(nodes(scene), rate * FRAME_MS / 4)


def test_a_small_mesh_says_nothing_of_large_ones() -> None:
    pace = Pace()
    before = pace.nodes
    pace.took(189, 500.0)
    assert pace.nodes == before


def test_a_plan_without_a_path_says_nothing() -> None:
    scene = scene_of(0.25)
    live = LivePlanner()
    live(scene)
    before = live.pace.nodes
    for k in range(10):
        blocked = live(scene.replace(start=[3.0, 3.0, 2.5 + 0.01 * k]))
        assert blocked.error is not None
    assert live.pace.nodes == before


def test_in_haste_one_search_runs_on_a_coarser_mesh_and_then_all_on_the_whole() -> None:
    planner, scene = LivePlanner(), scene_of(0.3)
    planner.pace.nodes = LEAST_NODES
    hasty = planner(scene)

    assert planner.coarse
    assert hasty.error is None
    assert hasty.mesh is not None
    assert len(hasty.mesh.points) <= LEAST_NODES
    assert [found.algorithm for found in hasty.searches] == [scene.search.algorithm]

    whole = planner.finish(scene)
    assert not planner.coarse
    assert not planner.partial
    assert whole.mesh is not None
    assert len(whole.mesh.points) == nodes(scene)
    assert len(whole.searches) == 3

    # what does not touch the path needs no coarser mesh
    faster = planner(scene.replace(motion={"speed": 5}))
    assert not planner.coarse
    assert faster.quadratic is whole.quadratic
    assert faster.profile is not None
    assert faster.profile.peak_speed == pytest.approx(5)


def test_in_haste_one_search_may_do_on_the_whole_mesh_and_the_rest_keeps_it() -> None:
    planner, scene = LivePlanner(), scene_of(0.3)
    planner.pace.nodes = nodes(scene)
    hasty = planner(scene)

    assert planner.partial
    assert not planner.coarse
    assert [found.algorithm for found in hasty.searches] == [scene.search.algorithm]

    whole = planner.finish(scene)
    assert not planner.partial
    assert len(whole.searches) == 3
    assert whole.path is hasty.path
    assert whole.bspline is hasty.bspline


def test_what_is_quick_is_planned_with_all_searches() -> None:
    planner, scene = LivePlanner(), scene_of(1.3)
    assert len(planner(scene).searches) == 3
    assert not planner.partial
