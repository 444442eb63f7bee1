"""Plans whose whole arm keeps clear: found, proven, checked, and explained where there is none."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from abi import Planner, load_scene, plan
from abi.arm_planning.arm_errors import ArmNotClear, beyond_limit
from abi.arm_planning.branch.branch_memory import BranchMemory
from abi.arm_planning.branch.elbow_branch import ElbowBranch
from abi.arm_planning.paper_arm_model import paper_arm
from abi.arm_planning.world.arm_worlds import paper_arm_world
from abi.explain.arm_diagnosis import _bases
from abi.explain.diagnosis import explain
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.arm_words import contact_sentence
from abi.planner.plan import Plan
from abi.robot.paper_arm.paper_arm import PaperArm
from abi.scene.arm_settings import Elbow
from abi.scene.scene import Scene
from abi.search.build_graph import build_graph
from abi.search.without_edges import without_edges
from abi.tet_mesh.exclusion import FreeMesh, exclude
from abi.tet_mesh.tet_mesh import tetrahedralise
from abi.verify.verify import verify
from tests.random_arms import arm_scene, dense_clearance

_ON_WALL = (0.5**0.5, 0.0, 0.5**0.5, 0.0)


def elbow_branch_of(scene: Scene, elbow: Elbow = "up", slack: float = 0.0) -> ElbowBranch:
    arm, obstacles = paper_arm(scene.arm), ObstacleSet(scene.obstacles)
    surroundings = paper_arm_world(arm, obstacles, scene.workspace.min[2])
    return ElbowBranch(arm, elbow, surroundings, (0.0, 0.0), scene.arm.clearance, slack)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(40, 60))
def test_a_motion_is_found_and_no_dense_sample_touches(seed: int) -> None:
    scene = arm_scene(seed)
    found = plan(scene)
    if found.error is not None and found.error.kind != "arm_not_clear":
        return  # the tool has none
    assert found.error is None
    assert found.motion is not None
    assert isinstance(found.arm, PaperArm)
    assert found.arm_clearance is not None
    assert found.arm_clearance.certified
    assert found.motion.within_limits
    assert found.motion.reachable
    kept = found.arm_clearance.distance - 1e-9
    assert dense_clearance(found.arm, found.motion, ObstacleSet(scene.obstacles)) >= kept
    if found.tool_only is not None:  # there was something to avoid
        before = plan(scene.replace(arm={"avoid": False, "elbow": found.motion.elbow}))
        assert before.arm_clearance is not None
        assert before.motion is not None
        limits = before.motion.within_limits and before.motion.reachable
        assert not (before.arm_clearance.certified and limits)


@pytest.mark.parametrize("mode", ["clear", "pieces"])
def test_a_quadratic_that_is_asked_to_be_clear_keeps_to_the_arm(mode: str) -> None:
    followed = 0
    for seed in (0, 4, 5, 17):
        scene = arm_scene(seed).replace(quadratic={"mode": mode})
        found = plan(scene)
        assert found.tool_only is not None, "there is something to avoid"
        assert found.quadratic is not None
        assert found.motion is not None
        if found.followed == "quadratic":
            followed += 1
            assert found.quadratic.holds
            assert (
                elbow_branch_of(scene, found.motion.elbow).refutation(found.quadratic.curve) is None
            )
        else:
            assert found.quadratic.note
    assert followed >= 3


@pytest.mark.slow
def test_a_taut_path_gives_room_where_no_curve_near_it_is_proven_clear() -> None:
    found = plan(arm_scene(125, 0.262, meshes=True))
    assert found.error is None
    assert found.tool_only is not None
    assert found.arm_clearance is not None
    assert found.arm_clearance.certified


def test_more_tries_prove_a_leg_close_to_the_base_axis() -> None:
    scene = arm_scene(174, meshes=True)
    segment = np.array([[2.919, 2.919, 0.0], [2.919, 3.081, 0.0]])  # the axis is at 3, 3
    branch = replace(elbow_branch_of(scene, slack=0.006), most_tries=300)
    patient = branch.scaled(tries=20)
    assert not branch.clear_segments(segment).any()
    assert patient.clear_segments(segment).all()
    assert patient.polyline_refutation(segment) is None
    points = segment[0] + np.linspace(0, 1, 400)[:, None] * (segment[1] - segment[0])
    assert all(branch.polyline_refutation(point[None]) is None for point in points)


@pytest.mark.slow
def test_the_arm_in_the_way_goes_round() -> None:
    scene = load_scene("arm-in-the-way")
    tool, whole = plan(scene.replace(arm={"avoid": False})), plan(scene)
    assert tool.arm_clearance is not None
    assert "forearm" in {one.link for one in tool.arm_clearance.contacts}
    assert tool.error is None  # said, not refused
    assert whole.error is None
    assert whole.arm_clearance is not None
    assert whole.arm_clearance.certified
    assert whole.tool_only is not None
    assert whole.taut is not None
    assert tool.taut is not None
    assert whole.taut.length > tool.taut.length
    written = json.loads(json.dumps(whole.to_dict(), allow_nan=False))
    assert next(one for one in verify(written) if one.curve == "arm").proven


def test_links_keep_the_clearance_asked_for() -> None:
    scene = load_scene("arm-in-the-way").replace(arm={"clearance": 0.1})
    found = plan(scene)
    assert found.error is None
    assert found.arm_clearance is not None
    assert found.arm_clearance.distance >= 0.1
    assert found.arm_clearance.certified


def test_a_wrong_elbow_is_explained_and_the_other_one_is_tried() -> None:
    scene = load_scene("wrong-elbow").replace(arm={"elbow": "up"})
    found = plan(scene)
    assert isinstance(found.error, ArmNotClear)
    assert (found.error.where, found.error.obstacle) == ("start", 0)
    assert "obstacle 1" in found.error.message
    reason = explain(scene, found)
    assert reason is not None
    assert reason.change == {"arm": {"elbow": "down"}}
    np.testing.assert_allclose(reason.points, [scene.start])
    helped = plan(scene.replace(**reason.change))
    assert helped.error is None
    both = plan(scene.replace(arm={"elbow": "auto"}))
    assert both.motion is not None
    assert both.motion.elbow == "down"


def test_what_no_elbow_does_names_both_and_what_was_tried() -> None:
    surroundings = {"shape": "box", "size": [0.4, 8, 8], "position": [2.6, -1, 4]}
    other = {**surroundings, "position": [3.4, -1, 4]}
    data = {"version": 1, "start": [0.5, 4, 3], "goal": [1.5, 5, 3]}
    scene = Scene.from_dict({**data, "obstacles": [surroundings, other], "arm": {"elbow": "auto"}})
    found = plan(scene)
    assert isinstance(found.error, ArmNotClear)
    assert "elbow up" in found.error.message
    assert "elbow down" in found.error.message
    assert found.motion is not None  # the tool's own plan stays to be looked at
    assert explain(scene, found) is not None


def test_a_base_behind_a_wall_is_told_with_joint_and_limit() -> None:
    found = plan(load_scene("find-a-base"))
    assert isinstance(found.error, ArmNotClear)
    assert (
        "q2 (the shoulder) at 167.5°, past its limit of 160.4°, at the start" in found.error.message
    )


def test_a_wall_before_the_base_is_moved_past_all_that_the_arm_sweeps() -> None:
    scene = load_scene("find-a-base")
    reason = explain(scene, plan(scene))
    assert reason is not None
    assert reason.change is not None
    assert reason.moved == 0
    helped = plan(scene.replace(**reason.change))
    assert helped.error is None
    assert helped.is_arm_clear


def test_where_no_path_is_found_link_and_obstacle_are_told() -> None:
    """A window in a wall that is thin enough to stand on both sides of."""
    slabs = [
        ((0.1, 2.4, 7), (3, 1.2, 3.5)),
        ((0.1, 3.4, 7), (3, 5.3, 3.5)),
        ((0.1, 1.2, 2.4), (3, 3, 1.2)),
        ((0.1, 1.2, 3.4), (3, 3, 5.3)),
    ]
    scene = load_scene("arm-in-the-way").replace(
        start=(0.3, 2, 2),
        goal=(5.7, 2, 2),
        arm={"base": (3, -4, 0)},
        obstacles=[{"shape": "box", "size": size, "position": at} for size, at in slabs],
    )
    found = plan(scene)
    assert isinstance(found.error, ArmNotClear)
    assert found.error.where == "path"
    assert found.arm_clearance is not None
    touched = contact_sentence(found.arm_clearance.contacts[0], "cm")
    assert touched.removeprefix("The ") in found.error.message
    assert "obstacle 1" in found.error.message


def test_an_obstacle_that_is_in_the_way_is_moved_and_not_only_left_out() -> None:
    scene = load_scene("wall-with-window").replace(arm={"avoid": True})
    found = plan(scene)
    assert isinstance(found.error, ArmNotClear)
    reason = explain(scene, found)
    assert reason is not None
    assert reason.change is not None
    assert reason.moved is not None
    changed = scene.replace(**reason.change)
    for number, (one, before) in enumerate(zip(changed.obstacles, scene.obstacles, strict=True)):
        assert (one == before) == (number != reason.moved)
    helped = plan(changed)
    assert helped.error is None
    assert helped.is_arm_clear
    place = ", ".join(f"{number:g}" for number in changed.obstacles[reason.moved].position)
    assert f"Obstacle {reason.moved + 1} at ({place}) {scene.unit} works" in reason.hint
    json.dumps(reason.to_dict(), allow_nan=False)


def test_the_same_planner_plans_the_same_while_an_obstacle_moves() -> None:
    planner, scene = Planner(), load_scene("arm-in-the-way")
    for y in (2.5, 2.3, 2.5, 1.0, 2.4):
        moved = [{**scene.to_dict()["obstacles"][0], "position": [3, y, 2.25]}]
        changed = scene.replace(obstacles=moved)
        one, fresh = planner(changed), plan(changed)
        assert one.arm_clearance is not None
        assert fresh.arm_clearance is not None
        assert one.arm_clearance.distance == fresh.arm_clearance.distance
        assert (one.tool_only is None) == (fresh.tool_only is None)


@pytest.mark.parametrize("elbow", ["up", "down"])
def test_excluded_nodes_are_those_where_the_arm_is_not_clear(elbow: Elbow) -> None:
    scene = arm_scene(3, pitch=1.4)
    mesh = tetrahedralise(scene.workspace, scene.mesh)
    branch, obstacles = elbow_branch_of(scene, elbow), ObstacleSet(scene.obstacles)
    free = BranchMemory().exclude(FreeMesh.of(mesh), branch, obstacles)
    for node, point in enumerate(mesh.points):
        fault = branch.polyline_refutation(point[None])
        assert free.excluded[node] == (fault is not None and fault.decided)


def test_what_is_remembered_of_nodes_that_become_free_is_what_is_found_anew() -> None:
    scene = arm_scene(3, pitch=0.8)
    made = FreeMesh.of(tetrahedralise(scene.workspace, scene.mesh))
    margin = scene.spline.clearance
    memory = BranchMemory()
    moved = [
        one.model_copy(update={"position": tuple(p + 0.7 for p in one.position)})
        for one in scene.obstacles
    ]
    all_there = tuple(scene.obstacles)
    copies = tuple(one.model_copy() for one in all_there)
    fewer = (*all_there[1:], moved[0]), all_there[:1], (*moved,), all_there[::-1], copies
    for obstacles in (all_there, *fewer, all_there + copies, all_there * 2, all_there[1:]):
        there = scene.model_copy(update={"obstacles": obstacles})
        branch, solids = elbow_branch_of(there), ObstacleSet(obstacles)
        free = exclude(made.mesh, solids, margin)
        remembered, anew = (
            memory.exclude(free, branch, solids),
            BranchMemory().exclude(free, branch, solids),
        )
        assert (remembered.excluded == anew.excluded).all()
        every = branch.reached(made.mesh.points)
        expected = ~every | free.excluded
        for number in range(len(obstacles)):
            expected |= branch.touching(made.mesh.points, number, every)
        assert (anew.excluded == expected).all()


@pytest.mark.parametrize("lattice", ["bcc", "delaunay"])
def test_edges_are_taken_from_a_graph_both_ways(lattice: str) -> None:
    scene = Scene.from_dict({"version": 1, "mesh": {"lattice": lattice, "pitch": 2.0}})
    free = FreeMesh.of(tetrahedralise(scene.workspace, scene.mesh))
    graph = build_graph(free, ObstacleSet(()), 0.0, (0.1, 0.2, 0.3), (5.7, 5.6, 5.5), 0.0)
    a, b = map(int, graph.edges[len(graph.edges) // 2])
    link = (int(graph.tails[0]), int(graph.heads[0]))

    less = without_edges(graph, [(a, b), link])

    before, after = ({tuple(sorted(edge)) for edge in one.edges.tolist()} for one in (graph, less))
    assert before - after == {tuple(sorted((a, b))), tuple(sorted(link))}


@pytest.mark.parametrize(("mount", "across"), [((1, 0, 0, 0), 2), ((0, 1, 0, 0), 2), (_ON_WALL, 0)])
def test_no_remedy_lifts_a_base_off_what_it_stands_on(
    mount: tuple[float, float, float, float], across: int
) -> None:
    scene = load_scene("kitchen-ur5e").replace(arm={"base_wxyz": mount})
    places = np.array(_bases(scene, Plan(scene)))
    assert len(places) == 12
    assert (places[:, across] == scene.arm.base[across]).all()
    assert len(np.unique(places, axis=0)) == 12


def test_a_joint_within_its_limit_is_said_to_need_more_room() -> None:
    near = beyond_limit("q2", "shoulder", angle=1.99, limit=2.0, room=math.radians(1.5))
    assert near == (
        "would need q2 (the shoulder) at 114.0°, which leaves less than 1.5° to its limit of "
        "114.6°,"
    )
    past = beyond_limit("q2", "shoulder", angle=2.01, limit=2.0, room=math.radians(1.5))
    assert "past its limit" in past


def test_a_clear_arm_that_forces_take_past_a_limit_is_told_of_the_limit() -> None:
    scene = load_scene("drag-a-box")
    found = plan(scene.replace(arm={"forces": [20.0, 0.0, 0.0]}))
    assert found.error is not None
    assert "the arm is proven clear along a curve, but q4 goes to" in found.error.message
    assert "past its limit of 360°." in found.error.message
    assert "smaller arm.forces" in found.error.hint
    assert plan(scene.replace(arm={"forces": [0.5, 0.0, 0.0]})).error is None
