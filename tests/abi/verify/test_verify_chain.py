"""Certificates of URDF arms are accepted in exact numbers, and what is damaged is refused."""

from __future__ import annotations

import copy
import json
import math
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from abi.arm_planning.certificates.separate_chain_kernels import separate_chain
from abi.certification.certify import certify
from abi.errors import AbiError
from abi.obstacles.pose import Quaternion
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.planner.planner import Planner, plan
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.robot_files import SHIPPED, load_robot, robot_from_archive
from abi.robot.urdf_arm import urdf_arm
from abi.scene.scene import Scene
from abi.verify.exact.chain import ExactChain
from abi.verify.exact.frame import ExactFrame, sine_and_cosine
from abi.verify.exact.robot_chain import exact_chain
from abi.verify.exact.solids import MovedHull, Vec3, dot, vector
from abi.verify.joint_motion import JointMotion
from abi.verify.verify import verify
from tests.abi.robot.robots import OWN, joint, link, packed, urdf
from tests.abi.verify.verdicts import NEAR, verdict_on

Data = dict[str, Any]


of_arm = partial(verdict_on, "arm")


@pytest.fixture(scope="module")
def honest() -> Data:
    separate_chain.compile()
    data: Data = json.loads(json.dumps(Planner()(NEAR).to_dict()))
    assert data["arm"]["certified"], data["arm"]["contacts"]
    return data


@given(st.fractions(-20, 20))
def test_sines_and_cosines_are_as_near_as_stated(angle: Fraction) -> None:
    sine, cosine, error = sine_and_cosine(angle)
    one = 1 << 200
    assert error < 1 << 80
    assert sine / one == pytest.approx(math.sin(angle), abs=1e-14)
    assert cosine / one == pytest.approx(math.cos(angle), abs=1e-14)
    # exactly, but for the errors of both
    assert abs(sine**2 + cosine**2 - one**2) <= 4 * error * one


def robot_of(name: str) -> tuple[Robot, str]:
    if name in SHIPPED:
        return load_robot(name, MeshSource()), SHIPPED[name]
    return robot_from_archive(packed({"a.urdf": OWN[name]})), "d"


def check_products(
    chain: ExactChain, frames: list[ExactFrame], random: np.random.Generator
) -> None:
    """Bounds of products hold those of the placed points, and are hardly wider."""
    motion, tiny = JointMotion(chain, ()), Fraction(1, 1 << 100)
    direction, *points = (vector(one) for one in random.normal(size=(4, 3)).tolist())
    for number in range(-1, len(frames)):
        placed = [(point, Fraction(0)) for point in points]
        if number >= 0:
            placed = [frames[number].place(point) for point in points]
        products = [dot(direction, place) for place, _ in placed]
        error = max(wrong for _, wrong in placed) * sum(map(abs, direction))
        low, high = motion.products(frames, MovedHull("", number, (*points,), tiny), direction)
        assert min(products) - tiny < low <= min(products) + error
        assert max(products) - error <= high < max(products) + tiny


@pytest.mark.parametrize("wxyz", [(1.0, 0.0, 0.0, 0.0), (0.1, -0.5, 0.7, 0.5)])
@pytest.mark.parametrize("name", [*SHIPPED, *OWN])
def test_frames_and_levers_are_those_of_the_chain(name: str, wxyz: Quaternion) -> None:
    robot, tip = robot_of(name)
    one = urdf_arm(robot, tip, (10.0, -20.0, 5.0), None, "cm", wxyz)
    exact = exact_chain(robot, tip, (10.0, -20.0, 5.0), 100, wxyz)
    random = np.random.default_rng(2)
    for _ in range(3):
        positions = random.uniform(one.limits[:, 0], one.limits[:, 1])
        poses = one.chain.poses((positions / one.scales)[None])[0]
        frames = exact.place([Fraction(number) for number in positions.tolist()])
        check_products(exact, frames, random)
        for pose, frame in zip(poses, frames, strict=True):
            point = random.normal(size=3)
            found, error = frame.place(vector(point.tolist()))
            assert error < Fraction(1, 1 << 80)
            expected = pose[:, :3] @ point + 100 * pose[:, 3]
            np.testing.assert_allclose([float(part) for part in found], expected, atol=1e-11)
    for capsule, levers in zip(one.capsules, one.levers, strict=True):
        ends: list[Vec3] = [vector(end) for end in (capsule.ends * 100).tolist()]
        of_exact = [float(lever) for lever in exact.levers(ends, capsule.frame, -1)]
        np.testing.assert_allclose(of_exact, levers, rtol=1e-8)
    for (i, j), both in zip(one.pairs.tolist(), one.pair_levers, strict=True):
        meets = exact.meeting(one.capsules[i].frame, one.capsules[j].frame)
        total = np.zeros(len(one.joints))
        for capsule in (one.capsules[i], one.capsules[j]):
            ends = [vector(end) for end in (capsule.ends * 100).tolist()]
            total += [float(lever) for lever in exact.levers(ends, capsule.frame, meets)]
        np.testing.assert_allclose(total, both, rtol=1e-8)


def test_a_certificate_is_accepted(honest: Data) -> None:
    found = of_arm(honest)
    assert found.proven, found.reason
    assert "keep" in found.reason
    assert "directions" in found.reason


@pytest.mark.slow
@pytest.mark.parametrize(
    ("base", "wxyz"),
    [((0, 0.3, 0.9), (0, 1, 0, 0)), ((0, 0, 0.6), (1, -1, 0, 0))],
    ids=["ceiling", "wall"],
)
def test_an_arm_that_hangs_is_proven_where_it_hangs(
    base: tuple[float, ...], wxyz: tuple[float, ...]
) -> None:
    separate_chain.compile()
    scene = NEAR.replace(arm={"base": base, "base_wxyz": wxyz})
    data: Data = json.loads(json.dumps(Planner()(scene).to_dict()))
    assert data["arm"]["certified"], data["arm"]["contacts"]
    found = of_arm(data)
    assert found.proven, found.reason
    data["scene"]["arm"]["base_wxyz"] = [1, 0, 0, 0]
    refused = of_arm(data)
    assert not refused.proven
    assert "start" in refused.reason


@pytest.mark.parametrize("damage", ["gone", "turned", "shorter", "pose"])
def test_damaged_directions_are_refused(honest: Data, damage: str) -> None:
    data = copy.deepcopy(honest)
    planes = data["arm"]["certificate"]["planes"]
    chosen = int(np.random.default_rng(len(damage)).integers(len(planes)))
    plane = planes[chosen]
    if damage == "gone":
        del planes[chosen]
    elif damage == "turned":
        plane["direction"] = [-number for number in plane["direction"]]
    elif damage == "shorter":
        plane["t1"] = (plane["t0"] + plane["t1"]) / 2
    else:
        plane["at"] = plane["t1"] + 1.0
    assert not of_arm(data).proven


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("arm", "clearance"), 0.5),
        (("arm", "certificate", "margin"), -0.1),
        (("arm", "reachable"), False),
        (("arm", "certified"), False),
        (("scene", "arm", "base"), [0.1, 0, 0]),
        (("scene", "arm", "urdf"), "panda"),
        (("scene", "obstacles", 0, "position"), [0.4, 0.3, 0.3]),
        (("arm", "certificate", "capsules", 3, "radius"), 0.4),
        (("arm", "certificate", "capsules", 3, "joint"), 0),
        (("arm", "certificate", "capsules", 3, "link"), "wrist_1_link"),
        (("arm", "certificate", "positions", 12, 1), -6.0),
        (("arm", "certificate", "positions", 0), [0.0] * 6),
        (("arm", "positions", 0, 0), 0.0),
        (("arm", "joints", 0), "elbow_joint"),
        (("arm", "time", 1), 0.0),
        (("arm", "allowed"), []),
        (("arm", "apart_only"), [["tool0"]]),
        (("timing", "duration"), 99.0),
    ],
)
def test_a_changed_number_is_refused(honest: Data, path: tuple[Any, ...], value: Any) -> None:
    data = copy.deepcopy(honest)
    section = data
    for key in path[:-1]:
        section = section[key]
    assert section[path[-1]] != value
    section[path[-1]] = value
    assert not of_arm(data).proven


def test_a_motion_whose_end_is_not_written_is_refused() -> None:
    scene = NEAR.replace(motion={"samples": 6}, arm={"axis": None})
    data: Data = json.loads(json.dumps(Planner()(scene).to_dict()))
    assert of_arm(data).proven
    for key in ("positions", "tool"):
        data["arm"][key] = data["arm"][key][:-1:2]
    data["arm"]["time"] = [moment * 5 / 4 for moment in data["arm"]["time"][:-1:2]]
    assert "positions are not those of the motion" in of_arm(data).reason


def test_a_direction_that_is_held_must_be_claimed(honest: Data) -> None:
    data = copy.deepcopy(honest)
    data["scene"]["arm"]["axis"] = [0.0, 1.0, 0.0]
    for claim in (data["arm"]["axis"], None):
        data["arm"]["axis"] = claim
        assert "direction" in of_arm(data).reason
        assert not of_arm(data).proven


def test_links_without_a_capsule_are_refused(honest: Data) -> None:
    data = copy.deepcopy(honest)
    certificate = data["arm"]["certificate"]
    certificate["capsules"].pop()
    last = len(certificate["capsules"])
    certificate["planes"] = [
        one for one in certificate["planes"] if one["capsule"] < last and one.get("other") != last
    ]
    certificate["pairs"] = [pair for pair in certificate["pairs"] if last not in pair]
    assert "has no capsule" in of_arm(data).reason


@pytest.mark.parametrize(
    ("entry", "reason"),
    [
        (("base_link_inertia", 0, "mount"), "obstacle 1"),
        (("wrist_3_link", "floor", "mount"), "the floor"),
        (("wrist_3_link", 1, "asked"), "obstacle 2"),
        (("shoulder_link", "wrist_3_link", "adjacent"), "no pair"),
        (("shoulder_link", "wrist_3_link", "srdf"), "no pair"),
        (("shoulder_link", "wrist_3_link", "asked"), "no pair"),
        (("shoulder_link", "wrist_3_link", "always"), "apart in some pose"),
        (("shoulder_link", "tool0", "always"), "tool0 has no shape"),
        (("shoulder_link", "nowhere", "adjacent"), "nothing that is there"),
        (("shoulder_link", 99, "mount"), "nothing that is there"),
    ],
)
def test_a_contact_that_may_not_be_left_out_is_refused(
    honest: Data, entry: tuple[str, str | int, str], reason: str
) -> None:
    data = copy.deepcopy(honest)
    allowed = data["arm"]["certificate"]["allowed"]
    allowed.append(dict(zip(("link", "other", "reason"), entry, strict=True)))
    found = of_arm(data)
    assert not found.proven
    assert reason in found.reason


def test_a_pair_that_nothing_keeps_apart_is_missed(honest: Data) -> None:
    for name in ("pairs", "allowed"):
        data = copy.deepcopy(honest)
        data["arm"]["certificate"][name].pop(0)
        assert not of_arm(data).proven


def test_links_that_the_scene_lets_touch_are_left_out() -> None:
    scene = NEAR.replace(arm={"allowed": [["shoulder_link", "wrist_3_link"], ["forearm_link", 1]]})
    data: Data = json.loads(json.dumps(Planner()(scene).to_dict()))
    found = of_arm(data)
    assert found.proven, found.reason
    assert "2 asked" in found.reason


@pytest.mark.parametrize("gantry", [False, True])
def test_a_tip_in_its_only_joint_is_at_the_start_and_the_goal_up_to_rounding(gantry: bool) -> None:
    box = '<collision><geometry><box size="0.1 0.1 0.3"/></geometry></collision>'
    text = (
        f'<robot name="r"><link name="a"/><link name="b">{box}</link><joint name="p" '
        'type="revolute"><parent link="a"/><child link="b"/><origin xyz="0.1 0.3 0.7" rpy="1 2 3"/>'
        '<axis xyz="0.6 0 0.8"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>'
        "</robot>"
    )
    base = [3.3, 1.7, 45.1]
    ends: dict[str, Any] = {"start": {"joints": {"p": -1.0}}, "goal": {"joints": {"p": -0.2}}}
    if gantry:  # slides that all stand in one point
        slide = '<limit lower="0" upper="90" velocity="1" effort="1"/>'
        joints = [
            joint(a + b, a, b, "prismatic", axis, slide)
            for (a, b), axis in (("ab", "1 0 0"), ("bc", "0 0.8 0.6"), ("cd", "0 -0.6 0.8"))
        ]
        text = urdf(*(f'<link name="{name}"/>' for name in "abc"), link("d"), *joints)
        text = text.replace('0 0 0.4" rpy="0.3 0.2 0.1', "0 0 0")
        # and that are at 0 where the motion begins
        ends = {"start": base, "goal": [120.0, 60.0, 130.0]}
    files = {"r.urdf": text.encode()}
    scene = Scene.from_dict(
        {
            "version": 1,
            "unit": "cm",
            "workspace": {"min": [-200, -200, 0], "max": [200, 200, 200]},
            "mesh": {"pitch": 40},
            **ends,
            "arm": {"model": "urdf", "urdf": "r.urdf", "base": base, "axis": None},
        },
        MeshSource(files),
    )
    data: Data = Planner()(scene).to_dict()
    assert data["error"] is None
    verdicts = verify(json.loads(json.dumps(data)), MeshSource(files))
    assert next(one for one in verdicts if one.curve == "arm").proven
    if gantry:  # far limits let no tip be farther from its goal
        data["scene"]["goal"][0] += 0.1
        assert "not at the goal" in verdict_on("arm", data, MeshSource(files)).reason


@pytest.mark.parametrize("holds", [False, True])
def test_lines_stand_for_a_robot_without_shapes_whatever_it_holds(holds: bool) -> None:
    bare = [f'<link name="{name}"/>' for name in "abcd"]
    joints = [joint(name, *pair) for name, pair in zip("pqs", ("ab", "bc", "cd"), strict=True)]
    ball = {"shape": "sphere", "radius": 0.02, "position": [0, 0, 0.3]}
    held = {"attached": ball} if holds else {}
    room = {"min": [-3] * 3, "max": [3] * 3}
    scene = Scene.from_dict(
        {
            **{"version": 1, "unit": "m", "workspace": room, "mesh": {"pitch": 2}},
            **{"start": {"joints": [0, 0, 0]}, "goal": {"joints": [0.3, 0.1, 0]}},
            "obstacles": [{"shape": "box", "size": [0.1, 0.1, 0.1], "position": [2, 2, 2]}],
            "arm": {"model": "urdf", "urdf": "a.urdf", "base": [0, 0, 0], **held},
        },
        {"a.urdf": urdf(*bare, *joints).encode()},
    )
    found = plan(scene)
    assert found.error is None
    assert "lines from joint to joint" in " ".join(scene.notes)
    data: dict[str, Any] = json.loads(json.dumps(found.to_dict()))
    assert verify(data, scene.meshes)[-1].proven
    motion = data["arm"]["positions"], data["arm"]["time"]
    with pytest.raises(AbiError, match="has a collision shape"):
        certify(None, ("p", "q", "s"), motion[1], motion[0], scene)

    # a line that is left out
    certificate = data["arm"]["certificate"]
    lines = [k for k, one in enumerate(certificate["capsules"]) if one["link"] == "c"]
    nowhere = [0.0, 0.0, 0.0]
    certificate["capsules"][lines[0]] |= {"from": nowhere, "to": nowhere, "points": [nowhere] * 2}
    assert "no lines stand" in verify(data, scene.meshes)[-1].reason
