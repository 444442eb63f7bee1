"""Each pair of an arm's links is kept apart or allowed by a rule; so is what the arm stands on."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from abi.arm_planning.motion import urdf_motion
from abi.arm_planning.world.arm_worlds import chain_world
from abi.arm_planning.world.chain_distances import obstacle_distances
from abi.arm_planning.world.mount import mounts
from abi.certification import certify_motion, convex_bodies
from abi.certification.certify import certify
from abi.certification.convex_bodies import body_pairs, robot_bodies
from abi.certification.verdict_words import remarks
from abi.errors import SceneError
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.obstacles.primitives import Box
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.obstacles.triangle_mesh.repair import clean
from abi.planner.arm_words import allowed_sentences
from abi.planner.planner import Planner, plan
from abi.robot.bodies import allowed_contacts as allowed_pairs
from abi.robot.bodies import finer_links
from abi.robot.bodies.allowed_contacts import tree_reason
from abi.robot.bodies.always_touching import with_held
from abi.robot.bodies.floor_contacts import floor_notes
from abi.robot.bodies.held_links import held_notes
from abi.robot.kinematics.chain import Chain
from abi.robot.urdf.robot import joints_between
from abi.robot.urdf.robot_files import SHIPPED, load_robot, robot_from_archive
from abi.robot.urdf_arm import UrdfArm, urdf_arm
from abi.scene.scene import Scene, load_scene
from abi.verify.allowed_contacts import _with_held, are_joined, may_touch_floor, usual_range
from abi.verify.exact.robot_chain import exact_chain, exact_joints
from abi.verify.plan_obstacles import obstacles_of
from abi.verify.plumb_line import is_beneath
from abi.verify.verify import verify
from tests.abi import meshes
from tests.abi.robot.robots import OWN, joint, link, packed, urdf
from tests.random_geometry import random_obstacle
from tests.random_robots import random_robot
from tests.thorough import of_each_kind

seeds = st.integers(0, 2**31)
RAIL = urdf(
    *map(link, ("base", "post", "carriage", "lamp")),
    '<link name="plate"/>',
    joint("post_joint", "base", "post", "fixed"),
    joint("plate_joint", "base", "plate", "fixed"),
    joint("rail", "base", "carriage", "prismatic", axis="1 0 0"),
    joint("turn", "plate", "lamp"),
)
"""A carriage beside a post, and a lamp that turns on a plate without a shape."""


def some_arm(name: str, **options: object) -> UrdfArm:
    if name in SHIPPED:
        robot, tip = load_robot(name, MeshSource()), SHIPPED[name]
    else:
        robot, tip = robot_from_archive(packed({"a.urdf": OWN[name]})), "d"
    return urdf_arm(robot, tip, (0.0, 0.0, 0.0), **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", [*SHIPPED, *OWN])
def test_two_links_are_kept_apart_as_wholes_or_allowed_to_touch(name: str) -> None:
    one = some_arm(name)
    apart = {frozenset(pair) for pair in one.pairs.tolist()}
    allowed = [frozenset((link, str(other))) for link, other, _ in one.allowed]
    links = {capsule.link for capsule in one.capsules}
    assert len(allowed) == len(set(allowed))
    for first, second in itertools.combinations(links, 2):
        numbers = [
            [k for k, capsule in enumerate(one.capsules) if capsule.link == link]
            for link in (first, second)
        ]
        kept = [frozenset(pair) in apart for pair in itertools.product(*numbers)]
        assert all(kept) or not any(kept)
        assert any(kept) != (frozenset((first, second)) in allowed)


def test_a_pair_that_the_scene_names_may_touch() -> None:
    plain = some_arm("ur5e")
    one = some_arm("ur5e", asked=(("wrist_3_link", "shoulder_link"), ("shoulder_link", 0)))
    found = {*one.allowed} - {*plain.allowed}
    assert [(frozenset((link, other)), why) for link, other, why in found] == [
        (frozenset(("shoulder_link", "wrist_3_link")), "asked")
    ]
    assert len(one.pairs) == len(plain.pairs) - 1
    boxes = ObstacleSet((Box(size=(0.1, 0.1, 0.1), position=(0.5, 0.5, 0.5)),))
    around = chain_world(one, boxes, 0.0).allowed
    assert ("shoulder_link", 0, "asked") in around


@settings(deadline=None)
@given(seeds)
def test_an_arm_stands_on_what_the_verifier_finds_beneath_it(seed: int) -> None:
    random = np.random.default_rng(seed)
    obstacles: list[Obstacle] = []
    for _ in range(6):
        place = tuple(random.normal(0, (0.15, 0.15, 0.2)).tolist())
        if random.random() < 0.4:
            surface = clean(*meshes.box((0.4, 0.5, 0.1)))
            obstacles.append(MeshShape.of(surface, position=place, wxyz=(1, 0.1, 0.2, 0)))
        else:
            obstacles.append(random_obstacle(random).model_copy(update={"position": place}))
    wxyz = tuple(random.normal(size=4).tolist())
    base = tuple(random.normal(0, 0.1, 3).tolist())
    one = urdf_arm(load_robot("ur5e", MeshSource()), "tool0", base, wxyz=wxyz)
    files = {shape.file: shape.surface for shape in obstacles if isinstance(shape, MeshShape)}
    data = {"version": 1, "obstacles": [shape.model_dump(mode="json") for shape in obstacles]}
    exact = obstacles_of(Scene.from_dict(data, MeshSource(files)))
    beneath = [is_beneath(solid, np.array(base), wxyz, 1.0) for solid in exact]
    assert list(mounts(one, ObstacleSet(tuple(obstacles)))) == np.flatnonzero(beneath).tolist()


@pytest.mark.parametrize("top", [-0.06, 0.0, 0.01])
def test_a_table_is_stood_on_and_a_box_at_the_side_is_not(top: float) -> None:
    one = some_arm("panda")
    table = Box(size=(2, 2, 0.1), position=(0, 0, top - 0.05))
    beside = Box(size=(0.2, 0.2, 0.2), position=(0.17, 0, 0.1))
    over = Box(size=(0.3, 0.3, 0.3), position=(0, 0, 0.12))
    assert mounts(one, ObstacleSet((table, beside, over))) == (0,)


def test_distances_leave_out_what_a_link_may_touch() -> None:
    one, random = some_arm("xarm7", asked=(("link5", 2), ("link7", 2))), np.random.default_rng(3)
    table = Box(size=(2, 2, 0.1), position=(0, 0, -0.06))
    others = [random_obstacle(random) for _ in range(4)]
    near = [shape.model_copy(update={"position": (0.3, 0.2 * k, 0.4)}) for k, shape in
            enumerate(others)]  # fmt: skip
    obstacles = ObstacleSet((table, *near))
    allowed = chain_world(one, obstacles, 0.0).allowed
    ends = one.place(random.uniform(one.limits[:, 0], one.limits[:, 1], (40, 7)))
    distance, number = obstacle_distances(one, obstacles, ends, allowed=allowed)
    for k, capsule in enumerate(one.capsules):
        free = [
            j for j in range(5) if not any((capsule.link, j) == (of, it) for of, it, _ in allowed)
        ]
        assert np.isin(number[:, k], [-1, *free]).all()
        rest = ObstacleSet(tuple(obstacles[j] for j in free))
        least = rest.polyline_clearances(ends[:, k]) - one.radii[k]
        touching = least < 0
        np.testing.assert_allclose(distance[touching, k], least[touching], atol=1e-9)
        assert (distance[~touching, k] > 0).all()


@pytest.mark.slow
@pytest.mark.parametrize("name", of_each_kind(SHIPPED, "ur5e"))
def test_an_arm_on_its_table_is_planned_and_its_proof_holds(name: str) -> None:
    table = {"shape": "box", "size": [1.6, 1.6, 0.05], "position": [0, 0, -0.085]}
    box = {"shape": "box", "size": [0.1, 0.1, 0.3], "position": [0.45, 0, 0.2]}
    scene = Scene.from_dict({
        "version": 1,
        "unit": "m",
        "workspace": {"min": [-0.2, -0.6, 0.05], "max": [0.7, 0.6, 0.9]},
        "start": [0.35, -0.35, 0.3],
        "goal": [0.35, 0.35, 0.3],
        "obstacles": [table, box],
        "mesh": {"pitch": 0.1},
        "spline": {"clearance": 0.02},
        "arm": {"model": "urdf", "urdf": name, "base": [0, 0, 0]},
    })  # fmt: skip
    plan = Planner()(scene)
    assert plan.error is None
    data = json.loads(json.dumps(plan.to_dict()))
    allowed = [(one["link"], one["other"], one["reason"]) for one in data["arm"]["allowed"]]
    root = next(link for link, other, _ in allowed if other == "floor")
    assert (root, 0, "mount") in allowed
    assert not [one for one in allowed if one[1] == 1]
    verdict = verify(data)[-1]
    assert verdict.proven, verdict.reason
    assert "mount" in verdict.reason


@pytest.mark.parametrize(
    ("allowed", "value"),
    [
        ([["base_link"]], r"\['base_link'\]"),
        ([["nowhere", "base_link"]], "nowhere"),
        ([["base_link", 2]], "2"),
        ([["base_link", True]], "True"),
        ([[0, "base_link"]], "0"),
    ],
)
def test_pairs_that_are_none_are_refused(allowed: object, value: str) -> None:
    scene = load_scene("kitchen-ur5e")
    fewer = scene.replace(obstacles=scene.obstacles[:2])
    with pytest.raises(SceneError, match=rf"arm\.allowed.*{value}"):
        fewer.replace(arm={"allowed": allowed})
    assert fewer.replace(arm={"allowed": [["base_link", 1]]}).arm.allowed == (("base_link", 1),)


@settings(deadline=None)
@given(seeds)
def test_planner_and_verifier_find_the_same_links_joined(seed: int) -> None:
    random = np.random.default_rng(seed)
    text = random_robot(random).text
    robot = robot_from_archive(packed({"a.urdf": text}))
    bare = {name for name in robot.links if random.random() < 0.4}
    links = {n: replace(one, shapes=()) if n in bare else one for n, one in robot.links.items()}
    joints = [  # the own limits of what follows do not count
        replace(one, low=0.0, high=0.0)
        if one.follows is not None and random.random() < 0.5
        else one
        for one in robot.joints
    ]
    robot = replace(robot, links=links, joints=tuple(joints))
    free = [one.name for one in robot.joints if one.kind != "fixed" and one.follows is None]
    names = tuple(name for name in free if random.random() < 0.8)  # the others are held
    assume(names)
    above = {one.child: one for one in robot.joints}
    chain, exact = Chain.moved_by(robot, names), exact_joints(robot, names, (0, 0, 0), 1)
    frames = chain.frames
    for first, second in itertools.combinations(robot.links, 2):
        reason = tree_reason(chain, (first, second), (frames[first], frames[second]))
        assert (reason == "adjacent") == are_joined(robot, exact, first, second)
        if reason == "adjacent" and frames[first] != frames[second]:
            ways: list[set[str]] = [set(), set()]
            for way, name in zip(ways, (first, second), strict=True):
                while name in above:
                    way |= {name} if above[name].kind != "fixed" else set()
                    name = above[name].parent
            assert len(ways[0] ^ ways[1]) == 1


def test_what_is_fixed_beside_a_joint_is_no_neighbour_of_what_it_moves() -> None:
    robot = robot_from_archive(packed({"a.urdf": RAIL}))
    chain = Chain.moved_by(robot, ("rail", "turn"))
    frames = chain.frames

    def reason(*links: str) -> object:
        return tree_reason(chain, (links[0], links[1]), (frames[links[0]], frames[links[1]]))

    assert [one.name for one in joints_between(robot, "carriage", "lamp")] == ["rail", "turn"]
    locked = [
        replace(one, low=0.5, high=0.5) if one.name == "turn" else one for one in robot.joints
    ]
    (rail,) = joints_between(replace(robot, joints=tuple(locked)), "carriage", "lamp")
    assert rail.name == "rail"
    assert reason("base", "post") == reason("base", "carriage") == "adjacent"
    assert reason("base", "lamp") == "adjacent"  # only a link without a shape is between
    assert reason("post", "carriage") is reason("post", "lamp") is None


def test_a_link_without_a_shape_makes_no_neighbours_of_what_it_carries() -> None:
    text = RAIL.replace(link("base"), '<link name="base"/>')
    arm = urdf_arm(robot_from_archive(packed({"a.urdf": text})), "carriage", (0.0, 0.0, 0.0))
    links = [one.link for one in arm.capsules]
    kept = {frozenset((links[i], links[j])) for i, j in arm.pairs.tolist()}
    assert frozenset(("post", "carriage")) in kept
    assert not any({one.link, one.other} == {"post", "carriage"} for one in arm.allowed)


@pytest.mark.parametrize(("high", "always"), [(1.0206, False), (1.0194, True)])
def test_links_that_part_only_at_the_end_of_a_range_overlap_not_always(
    high: float, always: bool
) -> None:
    slide = f'<limit lower="-1" upper="{high}" velocity="1" effort="9"/>'
    text = urdf(
        link("slab").replace("0.1 0.1 0.3", "2 2 0.1"),
        '<link name="m"/>',
        link("pin").replace("0.1 0.1 0.3", "0.04 0.04 0.4"),
        joint("x", "slab", "m", "prismatic", "1 0 0", slide).replace("0 0 0.4", "0 0 0"),
        joint("y", "m", "pin", "prismatic", "0 1 0", slide.replace(f"{high}", "0.5")),
    ).replace('rpy="0.3 0.2 0.1"', "")
    text = text.replace('<origin xyz="0 0 0.4" ', '<origin xyz="0 0 0" ')
    arm = urdf_arm(robot_from_archive(packed({"a.urdf": text})), "pin", (0.0, 0.0, 0.0))
    reasons = [one.reason for one in arm.allowed if {one.link, one.other} == {"slab", "pin"}]
    assert reasons == (["always"] if always else [])
    # a joint that is held between them could part them
    wide = text.replace('upper="0.5"', 'upper="1.5"')
    arm = urdf_arm(robot_from_archive(packed({"a.urdf": wide})), "m", (0.0, 0.0, 0.0))
    assert not [one for one in arm.allowed if {one.link, one.other} == {"slab", "pin"}]
    passed = replace(arm.chain, limits=arm.chain.limits * 2.0)  # by a motion
    assert with_held(passed, "slab", "pin").limits[0].tolist() == passed.limits[0].tolist()


def test_a_held_joint_that_moves_both_links_otherwise_is_between_them() -> None:
    follows = '<mimic joint="g" multiplier="-1"/>'
    text = urdf(
        *map(link, "rst"),
        '<link name="m"/>',
        joint("g", "r", "s", "prismatic", "1 0 0"),
        joint("x", "r", "m", "prismatic", "0 1 0"),
        joint("f", "m", "t", "prismatic", "1 0 0", follows),
    )
    robot = robot_from_archive(packed({"a.urdf": text}))
    chain, exact = Chain.moved_by(robot, ("x",)), exact_joints(robot, ("x",), (0, 0, 0), 1)
    assert with_held(chain, "s", "t").names == ("x", "g")
    assert (wider := _with_held(robot, exact, "s", "t")) is not None
    assert {*wider.coordinates} == {"x", "g"}


@given(low=st.floats(-15, 15), long=st.floats(0.1, 20), factor=st.sampled_from([None, 2.0, 0.5]))
def test_random_poses_are_of_a_whole_turn_or_all_that_there_is(
    low: float, long: float, factor: float | None
) -> None:
    limit = f'<limit lower="{low!r}" upper="{low + long!r}" velocity="1" effort="9"/>'
    parts = [link("a"), link("b"), joint("p", "a", "b", extra=limit)]
    if factor is not None:
        wide = '<limit lower="-99" upper="99" velocity="1" effort="9"/>'
        follows = f'<mimic joint="p" multiplier="{factor}"/>{wide}'
        parts += [link("c"), joint("f", "b", "c", extra=follows)]
    chain = Chain.of(robot_from_archive(packed({"a.urdf": urdf(*parts)})), "b")
    ((begin, end),), ((lowest, highest),) = chain.usual_range(), chain.limits
    assert lowest <= begin < end <= highest
    turned = end - begin if factor is None else min(1.0, factor) * (end - begin)
    assert turned >= 2 * np.pi - 1e-9 or (begin, end) == (lowest, highest)
    exact = exact_chain(chain.robot, "b", (0, 0, 0), 1, (1, 0, 0, 0), {})
    assert [*zip(*usual_range(exact), strict=True)] == [pytest.approx((begin, end))]


def pin_in_tube(radius: float, name: str = "r") -> dict[str, str | bytes]:
    """Files of a robot with a pin in a tube, whose convex pieces fill it."""
    tube = trimesh.creation.annulus(radius, 0.25, 0.2)
    slide = '<limit lower="-0.17" upper="0.17" velocity="1" effort="9"/>'
    text = urdf(
        link("tube").replace('box size="0.1 0.1 0.3"', 'mesh filename="tube.stl"'),
        '<link name="m"/>',
        link("pin").replace("0.1 0.1 0.3", "0.04 0.04 0.2"),
        joint("x", "tube", "m", "prismatic", "1 0 0", slide).replace("0 0 0.4", "0 0 0"),
        joint("y", "m", "pin", "prismatic", "0 1 0", slide).replace("0 0 0.4", "0 0 0"),
    ).replace('rpy="0.3 0.2 0.1"', "")
    text = text.replace('<robot name="r">', f'<robot name="{name}">')
    return {"a.urdf": text, "tube.stl": tube.export(file_type="stl")}


@pytest.mark.parametrize(("radius", "always"), [(0.2, False), (0.01, True)])
def test_links_whose_bodies_overlap_always_may_touch_only_if_they_do(
    radius: float, always: bool
) -> None:
    robot = robot_from_archive(packed(pin_in_tube(radius)))
    arm = urdf_arm(robot, "pin", (0.0, 0.0, 0.0))
    reasons = [one.reason for one in arm.allowed if {one.link, one.other} == {"tube", "pin"}]
    assert reasons == (["always"] if always else [])
    chain = Chain.moved_by(robot, ("x", "y"))
    reasons = [one.reason for one in body_pairs(chain, robot_bodies(chain))[1]]
    assert reasons == (["always"] if always else [])


def scene_of_pin(archive: bytes) -> Scene:
    return Scene.from_dict(
        {
            "version": 1,
            "unit": "m",
            "workspace": {"min": [-1, -1, -1], "max": [1, 1, 1]},
            "start": {"joints": [0.0, 0.0]},
            "goal": {"joints": [0.17, 0.17]},
            "arm": {"model": "urdf", "urdf": "a.zip", "base": [0, 0, 0], "search": "joints"},
        },
        {"a.zip": archive},
    )


@pytest.mark.parametrize("upper", [6.2831853, 3.1415927])
def test_links_are_said_to_touch_always_only_where_the_motion_goes_too(upper: float) -> None:
    # a stick in a plate for half a turn, and after it in a pillar of the same link
    box = '<collision><origin xyz="{}"/><geometry><box size="{}"/></geometry></collision>'
    base = box.format("0 0.35 0.3", "1.4 0.7 0.1") + box.format("0 -0.45 0.3", "0.1 0.2 0.1")
    joint = (
        '<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/><origin xyz="0 0 {}"/>'
        '<axis xyz="0 0 1"/><limit lower="{}" upper="{}" velocity="2" effort="9"/></joint>'
    )
    text = urdf(
        f'<link name="base">{base}</link>',
        link("hub").replace("0.1 0.1 0.3", "0.05 0.05 0.05"),
        f'<link name="stick">{box.format("0.45 0 0", "0.3 0.1 0.02")}</link>',
        joint.format("turn", "revolute", "base", "hub", 0.3, 0, upper),
        joint.format("lift", "prismatic", "hub", "stick", 0, -0.2, 0.2),
    )
    scene = scene_of_pin(packed({"a.urdf": text}))
    verdict = certify(None, ("turn", "lift"), [0.0, 4.0], [[0.05, 0.0], [6.2, 0.0]], scene)
    assert verdict.state == "touches"
    assert {verdict.touches[0].link, verdict.touches[0].obstacle} == {"stick", "base"}


@pytest.mark.parametrize("down", [0.2, -0.2])
def test_a_link_that_is_below_the_floor_wherever_it_turns_is_told(down: float) -> None:
    plate = f'<collision><origin xyz="0.3 0 {0.3 - down}"/><geometry><box size="0.5 0.04 0.6"/>'
    shape = f'<link name="plate">{plate}</geometry></collision></link>'
    turn = joint("p", "a", "plate").replace(' rpy="0.3 0.2 0.1"', "").replace("0 0 0.4", "0 0 0")
    whole = {"version": 1, "unit": "cm", "workspace": {"min": [-99, -99, 0], "max": [99] * 3}}
    ends = {"start": {"joints": [0.0]}, "goal": {"joints": [1.0]}, "mesh": {"pitch": 50}}
    arm = {"model": "urdf", "urdf": "a.zip", "base": [0, 0, 0]}
    archive = packed({"a.urdf": urdf(link("a"), shape, turn)})
    scene = Scene.from_dict({**whole, **ends, "arm": arm}, {"a.zip": archive})
    verdict = certify(None, ("p",), [0.0, 1.0], [[0.0], [1.0]], scene)
    found = plan(scene)
    assert verdict.state == "clear"
    assert found.error is None
    for notes in (remarks(verdict), verdict.to_dict()["notes"], found.to_dict()["notes"]):
        told = ["plate reaches 0.2 m below the floor" in note for note in notes]
        assert any(told) == (down > 0)
    data = json.loads(json.dumps(verdict.to_dict()))
    for one in (data, json.loads(json.dumps(found.to_dict()))):
        checked = verify(one, scene.meshes)[-1]
        assert checked.proven
        assert checked.reason.endswith("; not compared with the floor: plate")
    data["allowed"] = [one for one in data["allowed"] if one["other"] != "floor"]
    assert "does not say that plate is not compared" in verify(data, scene.meshes)[-1].reason


def test_links_that_no_random_pose_shows_apart_have_to_touch_where_the_motion_begins(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for module in (allowed_pairs, convex_bodies):
        monkeypatch.setattr(module, "always_touch", lambda *_: True)
    scene = scene_of_pin(packed(pin_in_tube(0.2, "wrong")))
    found = plan(scene)
    assert isinstance(found.arm, UrdfArm)
    assert [one.reason for one in found.arm.allowed].count("always") == 1
    assert "proven clear" in str(found.error)

    verdict = certify(None, ("x", "y"), [0.0, 1.0], [[0.0, 0.0], [0.17, 0.17]], scene)
    assert verdict.state == "undecided"
    assert [{one.link, one.obstacle} for one in verdict.doubts] == [{"tube", "pin"}]


@pytest.mark.parametrize(("radius", "always"), [(0.2, False), (0.01, True)])
def test_a_certificate_that_says_always_is_refused_unless_the_links_touch(
    radius: float, always: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in (allowed_pairs, convex_bodies):
        monkeypatch.setattr(module, "always_touch", lambda *_: True)
    for other in (urdf_motion, certify_motion):
        monkeypatch.setattr(other, "_apart_though_allowed", lambda *_: ())
    archive = packed(pin_in_tube(radius, f"said {radius}"))
    scene = scene_of_pin(archive)
    files = MeshSource({"a.zip": archive})
    planned = plan(scene).to_dict()
    motion = certify(None, ("x", "y"), [0.0, 1.0], [[0.0, 0.0], [0.17, 0.17]], scene).to_dict()
    for data in (planned, motion):
        arm = verify(json.loads(json.dumps(data)), files)[-1]
        assert arm.proven == always
        assert always or "said to touch always, are apart" in arm.reason


PLATE = (
    '<link name="{0}"><collision><geometry><box size="0.4 0.4 0.1"/></geometry></collision></link>'
)


@pytest.mark.parametrize(("height", "close"), [(0.09, False), (0.0995, True), (0.11, False)])
def test_links_that_overlap_only_by_a_little_are_fitted_in_finer_pieces(
    height: float, close: bool
) -> None:
    turning = (
        '<joint name="{0}" type="revolute"><origin xyz="0 0 {1}"/><parent link="{2}"/>'
        '<child link="{3}"/><axis xyz="0 0 1"/><limit lower="-1" upper="1"/></joint>'
    )
    text = urdf(
        *map(PLATE.format, "ac"),
        '<link name="b"/>',
        turning.format("p", 0.0, "a", "b"),
        turning.format("q", height, "b", "c"),
    )
    robot = robot_from_archive(packed({"a.urdf": text}))
    chain = Chain.of(robot, "c")
    links = "ac" if close else ""
    assert finer_links._close_links(chain, {}) == frozenset(links)
    # their pieces are the plates themselves, so that finer ones are no smaller
    fits = finer_links._finer_links(robot, chain.names, tuple(chain.held.items()))
    assert fits == dict.fromkeys(links, "close")


@settings(deadline=None, max_examples=30)
@given(seeds)
def test_the_floor_may_be_touched_by_what_no_joint_brings_nearer_to_it(seed: int) -> None:
    random = np.random.default_rng(seed)
    name = str(random.choice([*SHIPPED, *OWN]))
    turned, leaning = tuple(random.normal(size=4).tolist()), (1.0, 3e-4, 0, 0)
    wxyz = [(1.0, 0, 0, 0), (0, 1.0, 0, 0), turned, leaning][seed % 4]
    robot, tip = some_arm(name).chain.robot, SHIPPED.get(name, "d")
    one = urdf_arm(robot, tip, (0.0, 0.0, 0.0), wxyz=wxyz)
    floor = float(random.uniform(-0.5, 0.5))
    low, high = one.chain.usual_range().T
    positions = np.tile(np.clip(0, low, high), (50, 1))
    positions[:, 0] = random.uniform(low[0], high[0], 50)
    up = one.chain.poses(positions)[:, 0, 2]
    standing = one.on_floor(floor)
    for capsule in one.capsules:
        heights = up[:, :3] @ capsule.points.T + up[:, 3:]
        if capsule.frame == 0 and capsule.link in standing:
            level = np.ptp(heights, axis=0).max() < 1e-5
            pieces = [k for k in one.capsules if k.link == capsule.link]
            least = [(up[:, :3] @ k.points.T).min(axis=1) - k.rounding for k in pieces]
            assert level or (np.min(least, axis=0) + up[:, 3] <= floor + 1e-3).all()
        assert capsule.frame <= 0 or capsule.link not in standing
        assert capsule.frame >= 0 or capsule.link in standing

    scene = Scene.from_dict({
        "version": 1,
        "unit": "m",
        "workspace": {"min": [-1, -1, floor], "max": [1, 1, 1]},
        "start": [0, 0, 0.9],
        "goal": [0.5, 0, 0.9],
        "arm": {"model": "urdf", "urdf": "ur5e", "base": [0, 0, 1]},
    })  # fmt: skip
    exact = exact_chain(robot, tip, (0, 0, 0), 1, wxyz)
    world: Any = SimpleNamespace(robot=robot, arm=scene.arm, workspace=scene.workspace)
    links = {capsule.link for capsule in one.capsules}
    assert {link for link in links if may_touch_floor(link, world, exact)} == {*standing}


@pytest.mark.parametrize(("axis", "level"), [("0 0 1", False), ("0 1 0", True)])
def test_a_joint_is_said_to_bring_a_link_no_nearer_only_where_it_keeps_heights(
    axis: str, level: bool
) -> None:
    turn = joint("p", "a", "b", axis=axis).replace(' rpy="0.3 0.2 0.1"', "")
    robot = robot_from_archive(packed({"a.urdf": urdf(link("a"), link("b"), turn)}))
    (note,) = floor_notes(Chain.of(robot, "b"), ["b"], 0.5)
    assert note.endswith("as it touches the floor in every pose.") == level
    assert note.endswith("p brings it no nearer.") != level


def test_what_held_links_touch_is_kept_in_one_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    held = [joint(f"h{name}", "a", name, axis=f"0 {k} 1") for k, name in enumerate("bcdefg")]
    parts = [  # side by side, a little apart from each other
        link(name).replace("<collision>", f'<collision><origin xyz="0.3{k} 0 0"/>')
        for k, name in enumerate("abcdefgt")
    ]
    text = urdf(*parts, *held, joint("p", "a", "t"))
    chain = Chain.of(robot_from_archive(packed({"a.urdf": text})), "t")
    for _ in range(2):
        notes = held_notes(chain, -9.0)
        assert len(notes) == 7
        assert notes[-1] == "So it is with 9 more."  # of the 15 pairs that the joints turn apart
        held_notes.cache_clear()
    assert len([*(tmp_path / "abi-visualiser" / "bodies").iterdir()]) == 1


@pytest.mark.parametrize(
    ("turned", "bent", "lifted"),
    [(0.0, 0.0, False), (1.3, -2.5, False), (0.0, -2.5, True)],
)
def test_what_held_joints_put_in_the_floor_a_table_or_the_robot_is_told(
    turned: float, bent: float, lifted: bool
) -> None:
    deep, inside = turned != 0, bent != 0
    part = (
        '<link name="{}"><collision><origin xyz="{} 0 {}"/><geometry><box size="{}"/></geometry>'
        "</collision></link>"
    )
    moved = (
        '<joint name="{}" type="revolute"><parent link="{}"/><child link="{}"/><origin xyz="{}"/>'
        '<axis xyz="0 {}"/><limit lower="-3" upper="3" velocity="2" effort="9"/></joint>'
    )
    lift = moved.replace("revolute", "prismatic").format("lift", "foot", "torso", "0 0 0.2", "0 1")
    text = urdf(
        *([part.format("foot", 0, -0.5, "0.3 0.3 1"), lift] if lifted else []),
        part.format("torso", 0, 0.5, "0.3 0.3 1"),
        part.format("0", 0.1, 0, "0.2 0.05 0.05"),
        part.format("lower", 0.25, 0, "0.4 0.05 0.05"),
        part.format("low", 0.5, 0, "0.8 0.05 0.05"),
        part.format("arm", 0.3, 0, "0.4 0.05 0.05"),
        moved.format("u", "torso", "0", "0 0.2 0.5", "0 1"),
        moved.format("l", "0", "lower", "0.25 0 0", "0 1"),
        moved.format("d", "torso", "low", "0 -0.3 0.5", "1 0"),
        moved.format("p", "torso", "arm", "0 -0.3 1.2", "0 1"),
    )
    held = {"d": turned, "l": bent}
    scene = Scene.from_dict(
        {
            "version": 1,
            "unit": "cm",
            "workspace": {"min": [-99, -99, 0], "max": [199] * 3},
            "start": {"joints": [0.0] * (1 + lifted)},
            "goal": {"joints": [1.0] * (1 + lifted)},
            "obstacles": [{"shape": "box", "size": [300, 300, 5], "position": [0, 0, -2.5]}],
            "mesh": {"pitch": 50},
            "arm": {
                "model": "urdf",
                "urdf": "a.zip",
                "tip": "arm",
                "base": [0] * 3,
                "gripper": held,
            },
        },
        {"a.zip": packed({"a.urdf": text})},
    )
    names = ("lift", "p")[1 - lifted :]
    verdict = certify(None, names, [0.0, 1.0], [[at] * len(names) for at in (0.0, 1.0)], scene)
    found = plan(scene)
    neighbours, others = (
        next(one for one in allowed_sentences(found) if one.startswith(begin))
        for begin in ("Neighbouring", "No planned joint moves them")
    )
    assert "torso and lower" in others  # two joints part them, which are held
    assert "torso and lower" not in neighbours
    assert "torso and 0" in neighbours
    for data in (verdict.to_dict(), found.to_dict()):
        told = [note for note in data["notes"] if note.endswith("is not compared.")]
        depth = 0.9 * np.sin(1.3) + 0.025 * np.cos(1.3) - 0.5
        sunk = f"low reaches {depth:.3g} m below the floor, where it is held, which"
        # what one joint joins is folded together, and is not so elsewhere
        both = [f"lower touches {name}, where it is held, which" for name in ("torso", "0")]
        through = "low is in obstacle 1, on which the robot stands, where it is held, which"
        which = [*[sunk] * deep, *both * inside, *[through] * deep]
        assert told == [f"{one} is not compared." for one in which]
        checked = verify(json.loads(json.dumps(data)), scene.meshes)[-1]
        assert checked.proven
        assert ("; not compared with the floor: arm, low" in checked.reason) == deep
        touching = "; touching where they are held: lower and torso, lower and 0"
        assert (touching in checked.reason) == inside
        stands = "; held in what the robot stands on: low in obstacle 1"
        assert checked.reason.endswith(stands) == deep
