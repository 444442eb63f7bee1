"""Sequences of tasks: legs that join, and an object that is attached, carried and released."""

from __future__ import annotations

import copy
import itertools
import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from mcap.reader import make_reader
from scipy.spatial.transform import Rotation

from abi.arm_planning.arm_errors import ArmNotClear, NoJointMotion
from abi.arm_planning.motion.arm_clearance import Contact
from abi.arrays import FloatArray
from abi.certification.certify import certify
from abi.certification.read_motion import read_motion
from abi.errors import SceneError
from abi.explain.arm_faults import limits_warning
from abi.export.carried_objects import carried_objects
from abi.export.formats import export
from abi.export.html_page import page_data
from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.obstacles.primitives import Box, Sphere
from abi.planner.arm_words import clearance_sentence
from abi.planner.planner import plan
from abi.planner.task_plan import TaskPlan, plan_tasks
from abi.robot.attached_object import STANDING
from abi.robot.bodies.link_bodies import triangles_of
from abi.robot.urdf.link import Link
from abi.robot.urdf.tip_pose import tip_pose
from abi.scene.scene import Scene
from abi.verify.verify import Verdict, verify
from tests.abi.robot.robots import arm, packed
from tests.thorough import of_each_kind

FILES = {"a.zip": packed({"a.urdf": arm()})}
BASE = np.array([0.0, 0.0, 1.0])
JOINTS = [
    [0.0, 0.2, 0.3],
    [0.9, -0.4, 0.4],
    [-0.6, 0.5, 0.3],
    [-0.5, 0.5, 0.2],
    [0.3, 0.1, 0.5],
    [0.1, 0.2, 0.4],
]
"""Where the legs begin and end."""
CLEARANCE = 0.06
"""More than the tool is from the ball where it takes it."""


def tool(joints: list[float] | FloatArray) -> FloatArray:
    """World from tip, from the robot's joints alone."""
    robot = Scene.from_dict(data(), FILES).arm.robot
    pose = tip_pose(robot, "d", dict(zip("pqs", joints, strict=True))).copy()
    pose[:3, 3] += BASE
    return pose


def data(**fields: Any) -> dict[str, Any]:
    return {
        "version": 1,
        "unit": "m",
        "workspace": {"min": [-3.0] * 3, "max": [3.0] * 3},
        "mesh": {"pitch": 2.0},
        "start": {"joints": JOINTS[0]},
        "goal": {"joints": JOINTS[1]},
        "arm": {"model": "urdf", "urdf": "a.zip", "tip": "d", "base": BASE.tolist()},
        **fields,
    }


@cache
def planned() -> TaskPlan:
    """A ball that touches another one beyond it is taken from there to another place."""
    ball = tool(JOINTS[1]) @ [0.0, 0.0, 0.25, 1.0]
    other = tool(JOINTS[1]) @ [0.0, 0.0, 0.35, 1.0]
    scene = Scene.from_dict(
        data(
            obstacles=[
                {"shape": "sphere", "radius": 0.05, "position": ball[:3].tolist()},
                {"shape": "box", "size": [0.2, 0.2, 0.2], "position": [1.5, 1.5, 0.5]},
                {"shape": "sphere", "radius": 0.05, "position": other[:3].tolist()},
            ],
            arm={**data()["arm"], "clearance": CLEARANCE},
            tasks=[
                {"name": "reach", "attach": 0},
                {"goal": {"joints": JOINTS[2]}},
                {"goal": {"joints": JOINTS[3]}, "release": True},
                {"goal": {"joints": JOINTS[4]}},
                {"goal": {"joints": JOINTS[5]}},
            ],
        ),
        FILES,
    )
    found = plan_tasks(scene)
    assert found.error is None, found.error
    return found


def written() -> dict[str, Any]:
    plain: dict[str, Any] = json.loads(json.dumps(planned().to_dict()))
    return plain


@cache
def honest() -> tuple[Verdict, ...]:
    return verify(written(), planned().scene.meshes)


def joined(plan: dict[str, Any]) -> Verdict:
    return verify(plan, planned().scene.meshes)[-1]


def test_each_leg_begins_in_the_joints_in_which_the_last_one_ended() -> None:
    whole, legs = planned().trajectory, planned().legs
    assert whole is not None
    motions = [leg.motion for leg in legs]
    for before, after in itertools.pairwise(motions):
        assert before is not None
        assert after is not None
        np.testing.assert_allclose(after.positions[0], before.positions[-1], rtol=0, atol=1e-9)
    assert (np.diff(whole.time) > 0).all()
    assert np.abs(np.diff(whole.positions, axis=0)).max() < 0.05
    for joints, at in zip(JOINTS, planned().begins, strict=True):
        sample = int(np.abs(whole.time - at).argmin())
        np.testing.assert_allclose(whole.positions[sample], joints, atol=1e-9)


@pytest.mark.parametrize("seed", of_each_kind(range(20), 0, 1))
def test_the_arm_rests_where_legs_join_by_whatever_law_it_moves(seed: int) -> None:
    random = np.random.default_rng(seed)
    joints = random.uniform(-0.5, 0.5, (4, 3)).tolist()
    law = ("three_phase", "slowed", "time_optimal", "jerk_limited")[seed % 4]
    ends = {"start": {"joints": joints[0]}, "goal": {"joints": joints[1]}}
    tasks = [{}, *({"goal": {"joints": one}} for one in joints[2:])]
    scene = Scene.from_dict(data(**ends, tasks=tasks, motion={"law": law}), FILES)
    found = plan_tasks(scene)
    assert found.error is None, found.error
    motions = [leg.motion for leg in found.legs if leg.motion is not None]
    assert len(motions) == 3
    for before, after in itertools.pairwise(motions):
        np.testing.assert_allclose(after.positions[0], before.positions[-1], rtol=0, atol=1e-9)
    for motion in motions:
        assert np.abs(motion.joint_velocities[[0, -1]]).max() <= 1e-9
        assert np.abs(motion.joint_velocities).max() > 0.01
    whole = found.trajectory
    assert whole is not None
    np.testing.assert_allclose(whole.positions[0], joints[0], rtol=0, atol=1e-9)
    np.testing.assert_allclose(whole.positions[-1], joints[-1], rtol=0, atol=1e-9)


def test_the_object_is_a_body_of_the_arm_meanwhile_and_then_stands_where_the_tool_took_it() -> None:
    legs, ball = planned().legs, planned().scene.obstacles[0]
    assert [len(leg.scene.obstacles) for leg in legs] == [3, 2, 2, 3, 3]
    held = [leg.scene.robot.attached for leg in legs]
    assert [one == "" for one in held] == [True, False, False, True, True]

    moved = tool(JOINTS[3]) @ np.linalg.inv(tool(JOINTS[1])) @ [*ball.position, 1.0]
    left = legs[-1].scene.obstacles[0]
    np.testing.assert_allclose(left.position, moved[:3], atol=1e-9)
    clearance = legs[1].arm_clearance
    assert clearance is not None
    reasons = {one.link: one.reason for one in clearance.allowed if one.other == "held_object"}
    assert reasons.pop("d") == "grasp"
    assert "c" not in reasons


def test_what_is_taken_or_left_is_apart_and_all_else_keeps_the_clearance() -> None:
    legs = planned().legs
    assert [leg.scene.arm.grasping for leg in legs] == [True, True, True, True, False]
    for leg in legs:
        assert leg.arm_clearance is not None
        assert bool(leg.arm_clearance.apart_only) == leg.scene.arm.grasping
        assert np.isfinite(leg.arm_clearance.distances).all()
        assert leg.arm_clearance.distance >= CLEARANCE
        assert ("gripper and object apart" in clearance_sentence(leg)) == leg.scene.arm.grasping
        smaller = leg.scene.arm.grasping and leg.scene.arm.attached is not None
        assert ("1 mm smaller" in clearance_sentence(leg)) == smaller
    # the same legs with the clearance kept by all links are not to be had
    for number in (0, 1, 3):
        failed = plan(legs[number].scene.replace(arm={"grasping": False})).error
        assert isinstance(failed, NoJointMotion)


def test_the_first_leg_is_not_taken_for_all_of_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("abi.verify.verify.check_chain", lambda *_: "")
    whole = copy.deepcopy(written())
    alone = whole["legs"][0] | {"scene": whole["scene"]}
    assert "the first of 5 legs" in joined(alone).reason

    # and without tasks the only leg keeps what its scene asks for
    one_leg = copy.deepcopy(whole) | {"legs": whole["legs"][:1]}
    one_leg["scene"] = copy.deepcopy(whole["legs"][0]["scene"])
    one_leg["scene"]["arm"]["grasping"] = False
    one_leg["legs"][0]["scene"]["arm"]["grasping"] = True
    assert "keeps less distance" in joined(one_leg).reason


def test_every_leg_is_proven_and_so_is_that_they_join() -> None:
    verdicts = honest()
    clear = [
        f"leg {number}, {name}"
        for number, leg in enumerate(written()["legs"], 1)
        for name in ("bspline", "quadratic", "arm")
        if leg[name] and leg[name]["certified"]
    ]
    assert len(clear) > 5
    assert [one.curve for one in verdicts] == [*clear, "tasks"]
    assert all(one.proven for one in verdicts), verdicts


def test_notes_name_the_legs_before_which_the_gripper_moves_unproven() -> None:
    whole, legs = planned(), [*planned().legs]
    assert whole.notes == whole.scene.notes
    for number in (2, 3, 4):
        arm = legs[number].scene.arm.model_copy(update={"gripper": {"finger": 0.01}})
        scene = legs[number].scene.model_copy(update={"arm": arm})
        legs[number] = replace(legs[number], scene=scene)
    assert "before leg 3 is not proven" in replace(whole, legs=tuple(legs)).notes[-1]


def test_a_note_tells_of_an_object_that_is_taken_from_afar() -> None:
    assert not any("taken from" in note for note in planned().notes)
    taken = planned().scene.tasks[0].attach
    assert taken is not None
    leg = planned().legs[0]
    far = replace(leg.motion, tool=leg.motion.tool + 0.5)  # type: ignore[type-var, union-attr]
    moved = replace(planned(), legs=(replace(leg, motion=far),))
    (note,) = (note for note in moved.notes if "taken from" in note)
    assert note.startswith(f"On leg 1 obstacle {taken + 1} is taken from 0.")


def test_what_is_told_of_all_legs_counts_obstacles_as_their_scene_does() -> None:
    whole = planned()
    for number, leg in enumerate(whole.legs):
        for k, obstacle in enumerate(leg.scene.obstacles):
            error = ArmNotClear("Here", "goal", "d", k)
            stopped = replace(whole, legs=(*whole.legs[:number], replace(leg, error=error)))
            assert stopped.error is not None
            there = stopped.error.obstacle
            assert isinstance(there, int)
            size = whole.scene.obstacles[there].model_dump(exclude={"position", "wxyz"})
            assert size == obstacle.model_dump(exclude={"position", "wxyz"})
            assert f"obstacle {there + 1}" in stopped.error.message
            assert (there == k) == (leg.scene.arm.attached is None)
            assert leg.arm_clearance is not None
            contact = Contact("d", k, 0.0, 0.1, 0.1, 0.01)
            touches = replace(leg.arm_clearance, contacts=(contact,))
            (told,) = replace(
                whole, legs=(*whole.legs[:number], replace(leg, arm_clearance=touches))
            ).joined.arm_clearance.contacts  # type: ignore[union-attr]
            assert told.obstacle == there


def test_a_certified_motion_has_what_is_held_as_a_body() -> None:
    leg = planned().legs[1]
    assert leg.motion is not None
    motion = leg.motion.joints, leg.motion.time, leg.motion.positions
    verdict = certify(None, *motion, leg.scene).to_dict()

    assert "held_object" in {one["link"] for one in verdict["certificate"]["bodies"]}
    assert verify(verdict, leg.scene.meshes)[0].proven


@cache
def centres_of_what_is_held() -> FloatArray:
    """Centres of the ball at the samples of the leg that takes it away, (n, 3)."""
    leg = planned().legs[1]
    ball = leg.scene.arm.attached
    assert isinstance(ball, Sphere)
    assert leg.motion is not None
    robot = Scene.from_dict(data(), FILES).arm.robot
    states = [dict(zip("pqs", joints, strict=True)) for joints in leg.motion.positions.tolist()]
    poses = np.stack([tip_pose(robot, "d", state) for state in states])
    return np.asarray((poses @ [*ball.position, 1.0])[:, :3] + BASE)


@pytest.mark.parametrize("at", [0.0, 0.43, 1.0])
def test_what_is_held_is_proven_against_a_thin_plate_from_the_first_to_the_last_moment(
    at: float,
) -> None:
    leg = planned().legs[1]
    ball, motion, centres = leg.scene.arm.attached, leg.motion, centres_of_what_is_held()
    assert isinstance(ball, Sphere)
    assert motion is not None
    before = min(int(at * len(centres)), len(centres) - 2)
    # at the ends in a sample, on the way between two
    middle = centres[before] if at == 0 else centres[before + 1] if at == 1 else None
    middle = centres[before : before + 2].mean(axis=0) if middle is None else middle
    along = centres[before + 1] - centres[before]
    beside = np.cross(along, [0, 0, 1])
    for normal, away in ((along, 0.0), (beside, 0.03), (beside, 0.048), (beside, 0.053)):
        turn = Rotation.align_vectors([normal], [[1, 0, 0]])[0]
        x, y, z, w = turn.as_quat()
        place = middle + away * normal / np.linalg.norm(normal)
        plate = Box(size=(1e-4, 0.02, 0.02), position=tuple(place), wxyz=(w, x, y, z))
        scene = leg.scene.model_copy(update={"obstacles": (*leg.scene.obstacles, plate)})
        gaps = ObstacleSet((plate,)).signed_distance(centres) - ball.radius

        verdict = certify(None, motion.joints, motion.time, motion.positions, scene)
        assert verdict.state == ("touches" if gaps.min() < -STANDING else "clear")
        told = "object then a millimetre smaller" in verdict.sentence
        assert told == (verdict.state == "clear" and leg.scene.arm.grasping)


def jump(plan: dict[str, Any]) -> None:
    plan["legs"][2]["arm"]["certificate"]["positions"][0][0] += 1e-6


def move_what_is_left(plan: dict[str, Any]) -> None:
    plan["legs"][3]["scene"]["obstacles"][0]["position"][1] += 1e-5


def hold_another(plan: dict[str, Any]) -> None:
    plan["legs"][2]["scene"]["arm"]["attached"]["radius"] = 0.04


def keep_less(plan: dict[str, Any]) -> None:
    plan["legs"][4]["scene"]["arm"]["grasping"] = True


def forget_it(plan: dict[str, Any]) -> None:
    plan["legs"][2]["scene"]["arm"]["attached"] = None


def leave_out_a_leg(plan: dict[str, Any]) -> None:
    del plan["legs"][3]


def slacken(plan: dict[str, Any]) -> None:
    plan["legs"][1]["scene"]["arm"]["allowed"] = [["d", 0]]


def go_elsewhere(plan: dict[str, Any]) -> None:
    plan["scene"]["tasks"][3]["goal"] = {"joints": [0.3, 0.2, 0.5]}


def tell_another_motion(plan: dict[str, Any]) -> None:
    plan["trajectory"]["positions"][5][1] += 1e-6


def name_other_joints(plan: dict[str, Any]) -> None:
    plan["trajectory"]["joints"].reverse()


def run_backwards(plan: dict[str, Any]) -> None:
    plan["trajectory"]["time"].reverse()


def run_faster(plan: dict[str, Any]) -> None:
    plan["trajectory"]["time"] = [0.5 * time for time in plan["trajectory"]["time"]]


def have_no_times(plan: dict[str, Any]) -> None:
    plan["legs"][0]["arm"]["time"] = []


def belong_to_other_legs(plan: dict[str, Any]) -> None:
    plan["trajectory"]["leg"][1:] = plan["trajectory"]["leg"][:-1]


def join_at_other_times(plan: dict[str, Any]) -> None:
    plan["trajectory"]["begins"][1] += 0.1


def begin_elsewhere(plan: dict[str, Any]) -> None:
    plan["scene"]["start"] = plan["scene"]["arm"]["start"] = {"joints": JOINTS[4]}


def end_the_first_leg_elsewhere(plan: dict[str, Any]) -> None:
    plan["scene"]["goal"] = plan["scene"]["arm"]["goal"] = {"joints": JOINTS[4]}


@pytest.mark.parametrize(
    "damage",
    [
        *(begin_elsewhere, end_the_first_leg_elsewhere, run_faster),
        *(jump, move_what_is_left, hold_another, forget_it, leave_out_a_leg),
        *(keep_less, slacken, go_elsewhere, tell_another_motion),
        *(
            name_other_joints,
            run_backwards,
            belong_to_other_legs,
            have_no_times,
            join_at_other_times,
        ),
    ],
)
def test_legs_that_do_not_join_are_found(
    damage: Callable[[dict[str, Any]], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert honest()[-1].proven
    # of each leg by itself other tests ask
    monkeypatch.setattr("abi.verify.verify.check_chain", lambda *_: "")
    plan = written()
    damage(plan)

    assert not joined(plan).proven


@pytest.mark.parametrize("more", [{"verdict": "clear", "motion": {}}, {"legs": []}])
def test_a_leg_is_checked_as_one_whatever_else_it_says(more: dict[str, Any]) -> None:
    plan = copy.deepcopy(written())
    plan["legs"][1].update(more)
    plan["legs"][1]["arm"]["certificate"]["planes"] = []
    verdicts = {one.curve: one.proven for one in verify(plan, planned().scene.meshes)}
    assert not verdicts["leg 2, arm"]
    assert set(verdicts) == {one.curve for one in honest()}
    with pytest.raises(SceneError, match="one of a plan"):
        verify({**plan["legs"][0], **more}, planned().scene.meshes)


def test_a_leg_without_a_motion_ends_the_sequence() -> None:
    scene = planned().scene
    ahead = tool(JOINTS[2])[:3, 3].tolist()
    box = {"shape": "box", "size": [0.3, 0.3, 0.3], "position": ahead}
    stopped = plan_tasks(scene.replace(obstacles=[*scene.obstacles, box]))

    assert len(stopped.legs) == 2
    assert stopped.error is not None
    assert stopped.trajectory is None
    assert stopped.to_dict()["error"] is not None


@pytest.mark.parametrize(
    ("tasks", "field"),
    [
        ([{}, {}], "tasks[1].goal"),
        ([{"attach": 1}], "tasks[0].attach"),  # which is flat
        ([{"attach": 2}], "tasks[0].attach"),
        ([{"release": True}], "tasks[0].release"),
        ([{"attach": 0}, {"goal": [1.0, 1.0, 1.0], "attach": 0}], "tasks[1].attach"),
    ],
)
def test_tasks_that_cannot_be_are_refused(tasks: list[dict[str, Any]], field: str) -> None:
    ball = {"shape": "sphere", "radius": 0.1, "position": [2.0, 2.0, 2.0]}
    sheet = {"shape": "mesh", "file": "a.obj", "position": [2.0, 2.0, 2.0]}
    files = {**FILES, "a.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"}
    with pytest.raises(SceneError) as refusal:
        Scene.from_dict(data(obstacles=[ball, sheet], tasks=tasks), files)

    assert refusal.value.field == field


def test_a_scene_with_tasks_and_those_of_its_legs_are_read_back_equal() -> None:
    for scene in (planned().scene, *(leg.scene for leg in planned().legs)):
        assert Scene.from_dict(json.loads(json.dumps(scene.to_dict())), FILES) == scene
    assert planned().scene.replace(tasks=[{"goal": {"joints": JOINTS[4]}}]).arm.goal is not None


def body_of(given: Any) -> tuple[Obstacle, Link]:
    """A shape, and the link that stands for it where it is held."""
    shape: Obstacle = Scene.from_dict(data(obstacles=[given]), FILES).obstacles[0]
    held = {**data()["arm"], "attached": shape, "grasping": True}
    robot = Scene.from_dict(data(arm=held), FILES).robot
    return shape, robot.links[robot.attached]


@pytest.mark.parametrize(
    ("given", "least"),
    [
        ({"shape": "box", "size": [0.2, 0.3, 0.1]}, 1.0),
        (trimesh.creation.box((0.2, 0.3, 0.1)), 1.0),
        (trimesh.creation.cone(radius=0.1, height=0.3, sections=6), 0.5),  # its tip keeps near
    ],
    ids=["box", "box as mesh", "cone"],
)
def test_the_corners_of_what_is_held_are_a_millimetre_within_it(given: Any, least: float) -> None:
    shape, link = body_of(given)

    away = ObstacleSet((shape,)).signed_distance(triangles_of(link).reshape(-1, 3))
    assert away.min() == pytest.approx(-STANDING, abs=1e-9)
    assert away.max() < -least * STANDING + 1e-9


def test_what_is_round_keeps_its_form_and_loses_a_millimetre_where_it_is_held() -> None:
    ball = {"shape": "sphere", "radius": 0.1}
    assert [one.size[0] for one in body_of(ball)[1].shapes] == [pytest.approx(0.099)]
    for kind, height in (("cylinder", 0.298), ("capsule", 0.3)):
        _, link = body_of({"shape": kind, "radius": 0.1, "height": 0.3})
        assert link.shapes[0].size[:2] == pytest.approx((0.099, height))
        assert link.drawn[0].size[:2] == pytest.approx((0.1, 0.3))
    assert [round(float(one.pose[2, 3]), 9) for one in link.shapes] == [0.0, -0.15, 0.15]


def test_files_of_a_motion_have_all_legs(tmp_path: Path) -> None:
    whole = planned().trajectory
    assert whole is not None
    export(planned(), tmp_path / "a.csv")
    rows = np.loadtxt(tmp_path / "a.csv", delimiter=",", skiprows=1, usecols=range(4))
    np.testing.assert_allclose(rows[:, 0], whole.time, rtol=0, atol=0)
    np.testing.assert_allclose(rows[:, 1:4], whole.positions, rtol=0, atol=0)
    # joints alone do not tell what they carry
    first = planned().legs[0].arm
    assert first is not None
    own = dict(zip(first.chain.names, first.chain.slides, strict=True))
    taken, left = planned().begins[[1, 3]]
    holds = f"From {taken:.4g} to {left:.4g} s its tool holds obstacle 1, as a part of the arm."
    limits = [bool(limits_warning(leg)) for leg in planned().legs]
    assert any(limits) == bool(limits_warning(planned().joined))
    for name in ("a.csv", "a.ros.json", "a.bag.mcap"):
        export(planned(), tmp_path / name, "rosbag" if name.endswith("mcap") else None)
        motion = read_motion(name, (tmp_path / name).read_bytes(), own)
        assert len(motion.times) == len(whole.time)
        (said,) = (note for note in motion.notes if note.startswith("The file says: "))
        assert holds in said
        assert ("PASSES LIMITS" in said) == any(limits)


def test_what_the_tool_holds_on_a_single_way_is_said_too(tmp_path: Path) -> None:
    leg = plan(planned().legs[1].scene.replace(motion={"samples": 25}))
    assert leg.arm is not None
    own = dict(zip(leg.arm.chain.names, leg.arm.chain.slides, strict=True))
    for name in ("a.csv", "a.ros.json", "a.ros.yaml"):
        export(leg, tmp_path / name)
        notes = read_motion(name, (tmp_path / name).read_bytes(), own).notes
        assert any("Its tool holds an object, as a part of the arm." in note for note in notes)

    export(planned(), tmp_path / "a.plan.json", "json")
    verdicts = verify(json.loads((tmp_path / "a.plan.json").read_text()), planned().scene.meshes)
    assert all(one.proven for one in verdicts)
    assert len(verdicts) > len(planned().legs)


def test_recording_and_page_carry_the_object_with_the_tool(tmp_path: Path) -> None:
    legs, begins = planned().legs, planned().begins
    export(planned(), tmp_path / "a.mcap")
    updates = []
    with (tmp_path / "a.mcap").open("rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages(topics=["/scene"]):
            updates.append((message.log_time, json.loads(message.data)["entities"]))
            assert channel.topic == "/scene"
    moments = [0.0, begins[1], begins[3]]
    np.testing.assert_allclose([time for time, _ in updates], np.array(moments) * 1e9, atol=1)
    frames = [
        next(one["frame_id"] for one in entities if one["id"] == "obstacle 1")
        for _, entities in updates
    ]
    assert frames == ["world", "d", "world"]

    (carried,) = carried_objects(planned().joined)
    assert carried.number == 0
    assert carried.left is not None
    assert carried.left == legs[-1].scene.obstacles[0]
    page = page_data(planned().joined)["arm"]
    time, ball = np.array(page["time"]), np.array(page["links"])[:, -1, 0]
    before, after = time <= begins[1], time >= begins[3]
    for rests, shape in ((before, planned().scene.obstacles[0]), (after, carried.left)):
        np.testing.assert_allclose(ball[rests] - np.array(shape.position), 0, atol=1e-3)
    assert np.abs(ball[~before & ~after] - ball[0]).max() > 0.5


def test_what_a_leg_states_of_its_curve_and_of_what_need_only_be_apart_is_checked() -> None:
    plan = copy.deepcopy(written())
    number, curve = next(
        (k, leg["bspline"]) for k, leg in enumerate(plan["legs"], 1) if leg["bspline"]
    )
    curve["clearance"] += 0.01
    plan["legs"][1]["arm"]["apart_only"] = []
    verdicts = verify(plan, planned().scene.meshes)
    wrong = {one.curve for one in verdicts if not one.proven}
    assert wrong == {f"leg {number}, bspline", "leg 2, arm"}


def test_all_legs_together_pass_the_limits_that_each_of_them_passes() -> None:
    legs, late = planned().legs, planned().legs[2]
    assert late.motion is not None
    assert late.joint_rates is not None
    # a joint that sets off too hard: the sample before is the last one of the leg before
    rates = [
        array.copy() for array in (late.motion.joint_velocities, late.motion.joint_accelerations)
    ]
    limit = float(late.joint_rates.acceleration_limits[1])
    rates[1][0, 1] = 1.5 * limit
    name = late.motion.joints[1]
    late = replace(late, motion=replace(late.motion, rates=(rates[0], rates[1])))
    whole = replace(planned(), legs=(*legs[:2], late, *legs[3:])).joined
    (one,) = (one for one in whole.limits_passed if one.quantity == "acceleration")
    begin = sum(float(leg.motion.time[-1]) for leg in legs[:2] if leg.motion is not None)
    assert (one.joint, one.value) == (name, 1.5 * limit)
    assert one.time == one.since == pytest.approx(begin)
    others = [p for leg in legs for p in leg.limits_passed]
    assert len(whole.limits_passed) == 1 + len({(p.joint, p.quantity) for p in others})
