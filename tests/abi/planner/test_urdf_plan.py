"""Plans for arms that a URDF describes: followed, proven clear, and the same in every unit."""

from __future__ import annotations

import itertools
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from abi import compiling
from abi.arm_planning.arm_errors import ArmNotClear
from abi.arm_planning.certificates.separate_chain_kernels import separate_chain
from abi.arm_planning.exclusion.node_configuration_kernels import (
    bound_configurations,
    spread,
    touching_configurations,
)
from abi.arm_planning.joint_rates import joint_rates
from abi.arrays import FloatArray
from abi.errors import AbiError, SceneError
from abi.export.formats import FORMATS
from abi.planner.arm_words import arm_result
from abi.planner.live_planner import LivePlanner
from abi.planner.plan import Plan
from abi.planner.planner import Planner
from abi.robot.kinematics.chain_kernels import chain_poses
from abi.robot.kinematics.follow_path_kernels import follow_path
from abi.robot.urdf.robot_files import SHIPPED
from abi.robot.urdf_arm import UrdfArm, urdf_arm
from abi.scene.scene import Scene, load_scene
from abi.verify.verify import verify
from tests.abi.robot.robots import arm, packed
from tests.thorough import of_each_kind

KITCHEN = load_scene("kitchen-ur5e")
ROOM = KITCHEN.replace(obstacles=KITCHEN.to_dict()["obstacles"][:3])
"""Without the rack, which is in the way of other arms."""


@pytest.fixture(scope="module", autouse=True)
def _compiled() -> None:
    compiling.all_kernels()
    for kernel in (
        follow_path,
        chain_poses,
        separate_chain,
        spread,
        touching_configurations,
        bound_configurations,
    ):
        kernel.compile()


@pytest.fixture(scope="module")
def kitchen() -> Plan:
    return Planner()(KITCHEN)


def link_points(one: UrdfArm, positions: FloatArray) -> FloatArray:
    """Corners of all links that move, at joint positions (k, n), [unit], world."""
    poses = one.chain.poses(positions / one.scales)
    found = []
    for link, frame in one.chain.frames.items():
        place = one.chain.places[link]
        for shape in one.chain.robot.links[link].shapes:
            if frame >= 0 and shape.kind == "mesh":
                own = shape.vertices[::7] @ shape.pose[:3, :3].T + shape.pose[:3, 3]
                own = own @ place[:3, :3].T + place[:3, 3]
                pose = poses[:, frame]
                found.append(np.einsum("kij,nj->kni", pose[:, :, :3], own) + pose[:, None, :, 3])
    return np.concatenate(found, axis=1) / one.metres


@pytest.mark.slow
def test_the_links_keep_what_is_proven_between_the_samples_too(kitchen: Plan) -> None:
    motion, clearance, one = kitchen.motion, kitchen.arm_clearance, kitchen.arm
    assert kitchen.error is None
    assert isinstance(one, UrdfArm)
    assert motion is not None
    assert clearance is not None
    assert clearance.certified

    random = np.random.default_rng(0)
    times = random.uniform(0, motion.time[-1], 300)
    positions = np.stack([np.interp(times, motion.time, q) for q in motion.positions.T], axis=1)
    points = link_points(one, positions).reshape(-1, 3)
    nearest = min(float(shape.signed_distance(points).min()) for shape in KITCHEN.obstacles)
    assert nearest >= clearance.distance > 0
    assert points[:, 2].min() >= -0.01  # only the capsules of what stands on the floor reach below


def test_torques_are_those_of_the_samples_in_any_unit(kitchen: Plan) -> None:
    motion, rates, one = kitchen.motion, kitchen.joint_rates, kitchen.arm
    assert isinstance(one, UrdfArm)
    assert motion is not None
    assert rates is not None
    assert rates.torques is not None
    data = kitchen.to_dict(full=True)["arm"]
    efforts = [joint.effort for joint in one.chain.joints]

    assert data["joint_torque_limits"] == efforts
    np.testing.assert_array_equal(np.abs(data["torques"]).max(axis=0), data["peak_joint_torque"])
    np.testing.assert_allclose(
        data["peak_joint_speed"], np.abs(rates.speeds).max(axis=0), 0.05, 1e-9
    )
    # so slow that only the weight counts, which is the slope of the potential energy
    still = joint_rates(one, replace(motion, time=motion.time * 1e4), 8.0)
    centimetres = urdf_arm(one.chain.robot, one.tip, (0.0, 0.0, 0.0), unit="cm")
    again = joint_rates(centimetres, replace(motion, time=motion.time * 1e4), 8.0)
    assert still.torques is not None
    assert again.torques is not None
    np.testing.assert_allclose(still.torques, again.torques, atol=1e-9)
    assert np.abs(still.torques - rates.torques).max() > 0.1
    assert np.abs(still.torques[:, 0]).max() < 1e-6  # its axis is upright


def test_every_limit_that_a_joint_passes_is_told(kitchen: Plan) -> None:
    assert kitchen.limits_passed == ()
    assert kitchen.to_dict()["arm"]["within_limits"]

    fast = {"speed": 20.0, "acceleration": 1000.0, "deceleration": 1000.0, "law": "three_phase"}
    made = Planner()(KITCHEN.replace(obstacles=[], motion=fast))
    data = made.to_dict(full=True)["arm"]
    passed = {(one["quantity"], one["joint"]): one for one in data["limits_passed"]}
    assert not data["within_limits"]
    for quantity in ("speed", "acceleration", "torque"):
        rows = zip(
            data["joints"],
            data[f"peak_joint_{quantity}"],
            data[f"joint_{quantity}_limits"],
            strict=True,
        )
        for joint, peak, limit in rows:
            one = passed.pop((quantity, joint), None)
            assert (one is not None) == (peak > 1.001 * limit), (quantity, joint)
            if one is not None:
                assert one["since"] <= one["time"]
                assert (abs(one["value"]), abs(one["limit"])) == pytest.approx((peak, limit), 1e-9)
                assert one["value"] * one["limit"] > 0
    assert not passed

    assert arm_result(made) == "joint limit passed ✗"
    for name in ("ros", "urscript", "mcap", "html"):
        told = FORMATS[name].limits_warning(kitchen)
        # what is between its points is told where a file has accelerations
        assert bool(told) == told.startswith("Quintic polynomials") == (name == "ros")
        warning = FORMATS[name].limits_warning(made)
        assert "motion.law: slowed" in warning
        words = warning.split(" limit of ")[0].encode()
        assert words.endswith((b"its speed", b"its torque"))
        assert words in FORMATS[name].write(made, "motion")
    slow = Planner()(made.scene.replace(motion={**fast, "law": "slowed"}))
    assert all(one.quantity == "torque" for one in slow.limits_passed)


def boxes(*rows: tuple[float, ...]) -> list[dict[str, Any]]:
    """Boxes by their sizes and positions."""
    return [{"shape": "box", "size": row[:3], "position": row[3:]} for row in rows]


PANEL = boxes((0.29, 0.18, 0.08, 0.02, 0.42, 0.23))
THREE = boxes(
    (0.27, 0.22, 0.11, 0.07, 0.71, 0.56),
    (0.09, 0.28, 0.11, 0.11, 0.4, 0.57),
    (0.09, 0.15, 0.05, -0.05, 0.44, 0.5),
)
TWO = boxes((0.13, 0.16, 0.26, 0.18, 0.36, 0.62), (0.24, 0.18, 0.13, -0.04, 0.55, 0.16))
DOWN = (0.0, 0.0, -1.0)
CROWDED: list[tuple[str, Any, list[dict[str, Any]]]] = [
    ("ur5e", DOWN, THREE),
    ("panda", None, PANEL),
    ("xarm7", None, TWO),
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "axis", "obstacles"), of_each_kind(CROWDED, CROWDED[0]))
def test_links_that_would_touch_are_led_around(
    name: str, axis: tuple[float, float, float] | None, obstacles: list[dict[str, Any]]
) -> None:
    scene = KITCHEN.replace(obstacles=obstacles, arm={"urdf": name, "axis": axis})
    planner = Planner()
    tool, whole = planner(scene.replace(arm={"avoid": False})), planner(scene)

    assert tool.error is None
    assert tool.arm_clearance is not None
    assert tool.arm_clearance.contacts
    assert whole.error is None
    assert whole.tool_only is not None
    assert whole.arm_clearance is not None
    assert whole.arm_clearance.certified
    motion, one = whole.motion, whole.arm
    assert isinstance(one, UrdfArm)
    assert motion is not None
    assert np.abs(motion.tool - motion.target).max() < 1e-4 * one.reach
    random = np.random.default_rng(0)
    times = random.uniform(0, motion.time[-1], 300)
    positions = np.stack([np.interp(times, motion.time, q) for q in motion.positions.T], axis=1)
    points = link_points(one, positions).reshape(-1, 3)
    nearest = min(float(shape.signed_distance(points).min()) for shape in scene.obstacles)
    assert nearest >= whole.arm_clearance.distance
    verdicts = {one.curve: one for one in verify(json.loads(json.dumps(whole.to_dict())))}
    assert verdicts["arm"].proven, verdicts["arm"].reason


def test_a_drag_keeps_to_its_start_pose_and_rests_on_what_a_fresh_plan_has(kitchen: Plan) -> None:
    live = LivePlanner()
    aside = KITCHEN.to_dict()["obstacles"]
    aside[0]["position"][2] += 0.01
    begun = live(KITCHEN.replace(obstacles=aside))
    assert not begun.partial
    dragged = live(KITCHEN)
    assert dragged.partial
    assert dragged.arm_clearance is not None
    assert dragged.arm_clearance.certified
    poses, quadratics = [], []
    finished = live.finish(KITCHEN)
    for plan in (begun, dragged, finished, kitchen):
        assert plan.motion is not None
        assert plan.quadratic is not None
        poses.append(plan.motion.positions)
        quadratics.append(plan.quadratic)
    assert np.array_equal(poses[0][0], poses[1][0])
    assert not finished.partial
    assert np.array_equal(poses[2], poses[3])
    # one that the arm does not follow is not sought in haste
    assert [one.holds for one in quadratics] == [True, False, True, True]


def test_a_direction_held_at_samples_is_bounded_between_them(kitchen: Plan) -> None:
    (span,), motion, one = kitchen.held_spans, kitchen.motion, kitchen.arm
    assert motion is not None
    assert isinstance(one, UrdfArm)
    times = np.linspace(0, motion.time[-1], 4001)
    positions = np.stack([np.interp(times, motion.time, q) for q in motion.positions.T], axis=1)
    down = -one.chain.poses(positions / one.scales)[:, -1, 2, 2]
    off = np.arccos(np.minimum(down, 1.0)).max()
    assert span.angle < 1e-7
    assert off <= span.bound < span.tolerance == 0.01
    data = json.loads(json.dumps(kitchen.to_dict()))
    assert data["arm"]["axis"]["bound"] == span.bound
    (reason,) = [one.reason for one in verify(data) if one.curve == "arm"]
    assert "within 0.01 rad of its direction from 0 to 1 of the time" in reason
    data["arm"]["axis"]["tolerance"] = 1e-6  # less is not checked, and so not confirmed
    assert not next(one.proven for one in verify(data) if one.curve == "arm")


def test_what_no_first_pose_can_pass_is_said_with_a_link() -> None:
    lid = boxes((0.2, 0.2, 0.02, 0.42, 0.45, 0.28))
    made = Planner()(KITCHEN.replace(obstacles=lid))

    assert isinstance(made.error, ArmNotClear)
    assert made.error.where == "goal"
    assert isinstance(made.arm, UrdfArm)
    links = {one.link.replace("_", " ") for one in made.arm.capsules}
    assert any(f"the {link} touches obstacle 1 at the goal" in made.error.message for link in links)
    assert "elbow" not in made.error.message + made.error.hint
    assert made.motion is not None  # the tool's own, drawn with what touches in red
    assert made.arm_clearance is not None
    worst = made.arm_clearance.contacts[0]
    assert worst.certain != worst.apart  # it is decided whether the link itself touches


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "axis"),
    of_each_kind(
        itertools.product(SHIPPED, (None, DOWN)), ("ur5e", None), ("panda", DOWN), ("xarm7", DOWN)
    ),
)
def test_shipped_arms_follow_the_curve(name: str, axis: tuple[float, float, float] | None) -> None:
    scene = ROOM.replace(arm={"urdf": name, "axis": axis})
    made = Planner()(scene)
    motion, one = made.motion, made.arm

    assert made.error is None
    assert isinstance(one, UrdfArm)
    assert motion is not None
    assert np.abs(motion.tool - motion.target).max() < 1e-4 * one.chain.table.reach
    assert (motion.positions >= one.limits[:, 0] - 1e-12).all()
    assert (motion.positions <= one.limits[:, 1] + 1e-12).all()
    if axis is not None:
        poses = one.chain.poses(motion.positions)
        np.testing.assert_allclose(poses[:, -1, :, 2], np.tile(axis, (len(poses), 1)), atol=1e-5)
    data = made.to_dict(full=True)
    assert data["arm"]["joints"] == list(one.joints)
    assert len(data["arm"]["capsules"]) == len(one.capsules)
    assert json.loads(json.dumps(data)) == data


def scaled(factor: float, unit: str) -> Scene:
    """The kitchen in another unit."""
    data: dict[str, Any] = KITCHEN.to_dict()
    data["unit"] = unit
    for section, fields in (
        ("workspace", ("min", "max")),
        ("mesh", ("pitch",)),
        ("spline", ("clearance",)),
        ("motion", ("speed", "acceleration", "deceleration", "jerk")),
        ("arm", ("base", "clearance")),
    ):
        for name in fields:
            data[section][name] = (np.array(data[section][name]) * factor).tolist()
    for name in ("start", "goal"):
        data[name] = [x * factor for x in data[name]]
    for obstacle in data["obstacles"]:
        for name in {"size", "position", "radius", "height"} & obstacle.keys():
            obstacle[name] = (np.array(obstacle[name]) * factor).tolist()
    return Scene.from_dict(data)


def test_metres_and_centimetres_give_the_same_motion(kitchen: Plan) -> None:
    other = Planner()(scaled(100, "cm"))

    assert other.error is None
    assert kitchen.motion is not None
    assert other.motion is not None
    # roundings of the searches for path and curve are not the same
    assert other.motion.time[-1] == pytest.approx(kitchen.motion.time[-1], rel=1e-3)
    np.testing.assert_allclose(other.motion.positions, kitchen.motion.positions, atol=1e-3)
    assert kitchen.arm_clearance is not None
    assert other.arm_clearance is not None
    # how much of it is proven depends on roundings of the search for a proof
    assert other.arm_clearance.distance == pytest.approx(
        100 * kitchen.arm_clearance.distance, rel=0.02
    )


def test_out_of_reach_is_said() -> None:
    made = Planner()(KITCHEN.replace(arm={"base": (3.0, 0.0, 0.0)}))

    assert made.error is not None
    assert made.error.kind == "out_of_reach"
    assert "cannot follow the curve" in made.error.message
    assert made.motion is not None
    assert not made.motion.reachable


def test_arms_are_found_beside_the_scene_and_stay_with_it(tmp_path: Path) -> None:
    (tmp_path / "arms").mkdir()
    (tmp_path / "arms" / "own.urdf").write_text(arm())
    (tmp_path / "own.zip").write_bytes(packed({"own.urdf": arm()}))
    data = {"version": 1, "unit": "m", "arm": {"model": "urdf", "urdf": "arms/own.urdf"}}
    scene = Scene.from_dict(data, tmp_path)
    zipped = Scene.from_dict({**data, "arm": {"model": "urdf", "urdf": "own.zip"}}, tmp_path)

    assert scene.arm.tool == zipped.arm.tool == "d"
    moved = scene.replace(arm={"base": (1.0, 0.0, 0.0)})
    assert moved.arm.robot == scene.arm.robot
    assert Scene.from_dict(scene.to_dict(), scene.meshes) == scene
    uploaded = KITCHEN.replace({"x.zip": scene.arm.robot.archive}, arm={"urdf": "x.zip"})
    assert uploaded.arm.robot.links.keys() == scene.arm.robot.links.keys()


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"urdf": "robot"}, "one of ur5e, panda, xarm7"),
        ({"urdf": "../ur5e.urdf"}, "inside the scene's folder"),
        ({"urdf": "none.zip"}, "file"),
        ({"tip": "hand"}, "tool0"),
        ({"tip": "base_link"}, "joints move"),
        ({"axis": (0.0, 0.0, 0.0)}, "a direction"),
    ],
)
def test_a_wrong_arm_is_refused_by_its_field(change: dict[str, Any], expected: str) -> None:
    with pytest.raises(SceneError, match=expected) as refusal:
        KITCHEN.replace(arm=change)
    assert refusal.value.field.startswith("arm.")


def test_a_program_for_the_ur_passes_the_proven_poses_at_their_pace_or_slower(
    kitchen: Plan,
) -> None:
    motion = kitchen.motion
    assert motion is not None
    # as fast as no controller goes: its way is the same
    fast = replace(kitchen, motion=replace(motion, time=motion.time / 50))
    for made in (kitchen, fast):
        text = FORMATS["urscript"].write(made, "motion.script").decode()
        lines = re.findall(r"servoj\(\[(.*?)\], t=([\d.]+)\)", text)
        sent = np.array([pose.split(",") for pose, _ in lines], dtype=float)
        np.testing.assert_allclose(sent, motion.positions[1:], atol=1e-8)
        assert min(float(step) for _, step in lines) >= 0.008
    assert "slowed down from" in text

    text = FORMATS["urscript"].write(kitchen, "motion.script").decode()
    poses = re.findall(r"servoj\(\[(.*?)\], t=([\d.]+)\)", text)
    times = np.cumsum([float(step) for _, step in poses])
    found = np.array([pose.split(",") for pose, _ in poses], dtype=float)

    assert text.startswith("# SAFETY")
    assert "proven clear" in text
    assert times[-1] >= motion.time[-1] * (1 - 1e-3)
    pace = times * motion.time[-1] / times[-1]
    expected = [np.interp(pace, motion.time, q) for q in motion.positions.T]
    np.testing.assert_allclose(found, np.stack(expected, axis=1), atol=1e-4)
    (start,) = re.findall(r"movej\(\[(.*?)\]", text)
    np.testing.assert_allclose(
        np.array(start.split(","), dtype=float), motion.positions[0], atol=1e-6
    )


def test_a_program_for_the_ur_is_for_no_other_arm() -> None:
    for scene in (load_scene("paper"), KITCHEN.replace(arm={"urdf": "panda"})):
        with pytest.raises(AbiError, match="Universal Robots"):
            FORMATS["urscript"].write(Planner()(scene), "motion.script")


@pytest.mark.parametrize(
    "name", ["csv", "json", "ros", "ros-json", "spline", "moveit", "mcap", "urdf-zip"]
)
def test_the_other_formats_hold_other_arms(kitchen: Plan, name: str) -> None:
    content = FORMATS[name].write(kitchen, FORMATS[name].file)

    assert content
    if name in ("csv", "ros", "ros-json", "json"):
        assert b"shoulder_pan_joint" in content
