"""Links beside the arm that follow its joints: nothing is proven that they run through."""

from __future__ import annotations

import io
import json
import re
from typing import Any

import numpy as np
import pytest
import yourdfpy

from abi.arrays import FloatArray
from abi.certification.certify import certify
from abi.errors import SceneError
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.planner.plan import Plan
from abi.planner.planner import Planner
from abi.robot.urdf_arm import UrdfArm
from abi.scene.scene import Scene
from abi.verify.verify import Verdict, verify
from tests.abi.robot.robots import follows, urdf

Data = dict[str, Any]


def link(name: str, size: str, z: float) -> str:
    return (
        f'<link name="{name}"><collision><origin xyz="0 0 {z}"/>'
        f'<geometry><box size="{size}"/></geometry></collision></link>'
    )


def turning(name: str, parent: str, child: str, xyz: str, axis: str, extra: str = "") -> str:
    limit = '<limit lower="-2.5" upper="2.5" velocity="2" effort="9"/>'
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}"/><axis xyz="{axis}"/>{limit}{extra}</joint>'
    )


def crane(swings: str, *more: str) -> str:
    """An arm of three joints with a boom at the side of its turret."""
    return urdf(
        link("foot", "0.1 0.1 0.1", 0.05),
        link("turret", "0.06 0.06 0.06", 0.0),
        link("upper", "0.04 0.04 0.4", 0.2),
        link("fore", "0.04 0.04 0.4", 0.2),
        link("boom", "0.03 0.03 0.5", -0.3),
        '<link name="tool"/>',
        turning("turn", "foot", "turret", "0 0 0.6", "0 0 1"),
        turning("lift", "turret", "upper", "0 0 0.05", "0 1 0"),
        turning("bend", "upper", "fore", "0 0 0.4", "0 1 0"),
        '<joint name="end" type="fixed"><parent link="fore"/><child link="tool"/>'
        '<origin xyz="0 0 0.4"/></joint>',
        turning("swing", "turret", "boom", "0 0.2 0.05", "0 1 0", swings),
        *more,
    )


def scene(text: str, **changes: Any) -> Scene:
    """The tool goes from left to right in front of the arm, the obstacle is behind it."""
    data = {
        "version": 1,
        "unit": "m",
        "workspace": {"min": [-0.8, -0.8, 0], "max": [0.8, 0.8, 1.6]},
        "start": [0.45, 0, 1.05],
        "goal": [0.62, 0, 0.72],
        "mesh": {"pitch": 0.2},
        "spline": {"clearance": 0.01},
        "arm": {"model": "urdf", "urdf": "crane.urdf", "tip": "tool", "base": [0, 0, 0]},
        **changes,
    }
    return Scene.from_dict(data, MeshSource({"crane.urdf": text.encode()}))


def planned(one: Scene) -> tuple[Plan, Data]:
    plan = Planner()(one)
    data: Data = json.loads(json.dumps(plan.to_dict(full=True)))
    return plan, data


def verdict(data: Data, text: str) -> Verdict:
    source = MeshSource({"crane.urdf": text.encode()})
    return next(one for one in verify(data, source) if one.curve == "arm")


STANDS = follows("grip", 1.0, 1.2)
HELD = turning("grip", "fore", "jaw", "0 0 0.45", "1 0 0") + link("jaw", "0.02 0.02 0.05", 0.03)


def boom_points(text: str, plan: Plan) -> FloatArray:
    """Points along the middle of the boom at all samples of a motion, by yourdfpy."""
    robot = yourdfpy.URDF.load(io.BytesIO(text.encode()))
    assert plan.motion is not None
    along = np.column_stack([np.zeros((30, 2)), np.linspace(-0.55, -0.05, 30)])
    found = []
    for row in plan.motion.positions:
        robot.update_cfg(dict(zip(plan.motion.joints, row.tolist(), strict=True)))
        pose = robot.get_transform("boom")
        found.append(along @ pose[:3, :3].T + pose[:3, 3])
    return np.array(found)


def test_an_arm_is_proven_clear_only_where_what_follows_its_joints_is() -> None:
    text = crane(follows("lift"))
    free, data = planned(scene(text))
    assert data["arm"]["certified"], (data["arm"]["contacts"], free.error)
    assert verdict(data, text).proven, verdict(data, text).reason
    points = boom_points(text, free)
    assert np.ptp(points[:, 0], axis=0).max() > 0.1
    # around the end of the boom in the middle of the motion, far from everything else
    ball = {"shape": "sphere", "radius": 0.05, "position": points[len(points) // 2, 0].tolist()}
    other, blocked = planned(scene(text, obstacles=[ball]))
    if blocked["arm"] is not None and blocked["arm"]["certified"]:
        gaps = np.linalg.norm(boom_points(text, other) - ball["position"], axis=2)
        assert gaps.min() > 0.05
    data["scene"]["obstacles"] = [ball]
    assert not verdict(data, text).proven


def test_a_link_stands_at_the_offset_to_a_joint_that_rests() -> None:
    text = crane(STANDS, HELD)
    free, data = planned(scene(text))
    assert data["arm"]["certified"], (data["arm"]["contacts"], free.error)
    boom = next(one for one in data["arm"]["capsules"] if one["link"] == "boom")
    ball = {"shape": "sphere", "radius": 0.02, "position": np.mean(boom["to"], axis=0).tolist()}
    _, blocked = planned(scene(text, obstacles=[ball]))
    assert not blocked["arm"]["certified"]
    assert not verdict(blocked, text).proven


def test_joints_that_are_held_elsewhere_move_what_follows_them() -> None:
    text = crane(STANDS, HELD)
    at_rest, held = (
        planned(scene(text)),
        planned(scene(text, arm={**scene(text).arm.model_dump(), "gripper": {"grip": -0.9}})),
    )
    assert isinstance(held[0].arm, UrdfArm)
    assert held[0].arm.chain.held == {"grip": -0.9, "swing": pytest.approx(0.3)}
    assert held[1]["arm"]["certified"]
    assert verdict(held[1], text).proven
    # the same capsules for other joints are no proof
    held[1]["scene"]["arm"]["gripper"] = {"grip": 0.9}
    assert "not where its joints take it" in verdict(held[1], text).reason
    assert at_rest[1]["arm"]["certificate"]["capsules"] != held[1]["arm"]["certificate"]["capsules"]
    saved = held[0].scene
    assert Scene.from_dict(saved.to_dict(), saved.meshes) == saved


@pytest.mark.parametrize(
    ("gripper", "expected"),
    [
        ({"grip": 3.0}, r"arm\.gripper\.grip is 3\.0; expected -2\.5 to 2\.5 rad"),
        ({"lift": 0.0}, r"arm\.gripper is 'lift'; expected a joint that is not planned: grip"),
        ({"swing": 0.0}, r"arm\.gripper is 'swing'"),
        ({"other": 0.0}, r"arm\.gripper is 'other'"),
        ({"grip": "open"}, r"arm\.gripper\.grip is 'open'; expected a number"),
        ([], r"arm\.gripper is .*; expected a mapping"),
    ],
)
def test_positions_that_no_joint_can_be_held_at_are_refused(gripper: Any, expected: str) -> None:
    arm = {"model": "urdf", "urdf": "crane.urdf", "tip": "tool", "gripper": gripper}
    with pytest.raises(SceneError, match=expected):
        scene(crane(STANDS, HELD), arm=arm)


def test_a_joint_that_follows_itself_is_refused() -> None:
    with pytest.raises(SceneError, match="moves by itself"):
        scene(crane(follows("swing")))


@pytest.mark.parametrize(
    "base", ["", '<collision><geometry><sphere radius="0.05"/></geometry></collision>']
)
def test_lines_stand_for_the_links_of_a_robot_of_which_nothing_that_moves_has_a_shape(
    base: str,
) -> None:
    text = re.sub("<collision>.*?</collision>", "", crane(follows("lift")))
    text = text.replace('<link name="foot">', f'<link name="foot">{base}', 1)
    one = scene(text)
    assert any("lines from joint to joint" in note for note in one.notes)
    free, data = planned(one)
    assert data["arm"]["certified"], free.error
    assert verdict(data, text).proven, verdict(data, text).reason
    capsules = [one for one in data["arm"]["capsules"] if one["link"] != "foot"]
    assert [capsule["link"] for capsule in capsules] == ["turret", "turret", "upper", "fore"]
    (fore,) = (np.array([c["from"], c["to"]]) for c in capsules if c["link"] == "fore")
    np.testing.assert_allclose(fore[1], data["arm"]["tool"], atol=1e-9)
    at = (fore[0, 50] + fore[1, 50]) / 2
    ball = {"shape": "sphere", "radius": 0.1, "position": at.tolist()}
    _, blocked = planned(
        scene(text, obstacles=[ball], arm={**one.arm.model_dump(), "avoid": False})
    )
    assert not blocked["arm"] or not blocked["arm"]["certified"]


@pytest.mark.parametrize("factor", [3.0, -3.0, 0.5])
def test_a_joint_is_no_faster_than_what_follows_it_may_be(factor: float) -> None:
    text = crane(follows("lift", factor))
    limit = min(2.0, 2.0 / abs(factor))
    one = scene(text, motion={"law": "time_optimal", "acceleration": 50})
    plan, _ = planned(one)
    assert plan.motion is not None
    fastest = np.abs(plan.motion.joint_velocities).max(axis=0)
    assert fastest[1] <= limit * (1 + 1e-6)

    rows = [[0.0, 0.0, 0.0], [0.0, 0.2, 0.0]]
    times = np.array([0.0, 0.2 / limit])
    for pace, passed in ((0.99, [("speed", "lift")]), (1.01, [])):
        verdict = certify(None, ("turn", "lift", "bend"), pace * times, rows, one)
        assert [(each.quantity, each.joint) for each in verdict.limits.passed] == passed


def test_a_verdict_tells_what_is_taken_of_the_files_as_a_plan_does() -> None:
    text = crane(follows("lift", 3.0))
    one = scene(text)
    rows = [[0.0, 0.0, 0.0], [0.0, 0.2, 0.0]]
    told = certify(None, ("turn", "lift", "bend"), [0.0, 9.0], rows, one).to_dict()["notes"]
    (past,) = (note for note in one.notes if "past its own limits" in note)
    assert past in told
