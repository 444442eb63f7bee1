"""The arm's certificates are accepted in exact numbers, and what is damaged is refused."""

from __future__ import annotations

import copy
import json
import math
from collections.abc import Callable
from fractions import Fraction
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from abi import Scene, load_scene, plan
from abi.arm_planning.motion import arm_clearance
from abi.arm_planning.paper_arm_model import paper_arm
from abi.curves.bspline import clamped
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.triangle_mesh.repair import clean
from abi.scene.arm_settings import ArmSettings
from abi.verify.arm_capsules import capsules_of, check_bend
from abi.verify.exact.paper_arm import ExactArm
from abi.verify.fault import Fault
from abi.verify.verify import verify
from tests.abi import meshes
from tests.abi.verify.verdicts import verdict_on

Data = dict[str, Any]


def written(**arm: Any) -> Data:
    scene = Scene.from_dict(
        {
            "version": 1,
            "obstacles": [
                {"shape": "box", "size": [1.5, 1.5, 1.5], "position": [3, 3.6, 2.4]},
                {"shape": "cylinder", "radius": 0.4, "height": 1, "position": [1, 5, 5]},
            ],
            "start": [0.5, 1, 1],
            "goal": [3.4, 4.6, 3.6],
            "motion": {"samples": 25},
            "arm": arm,
        }
    )
    data: Data = json.loads(json.dumps(plan(scene).to_dict(), allow_nan=False))
    assert data["arm"]["certified"], data["arm"]["contacts"]
    return data


of_arm = partial(verdict_on, "arm")


@pytest.fixture(scope="module")
def honest() -> Data:
    return written()


@pytest.mark.slow
def test_a_certificate_is_accepted_with_and_without_a_moving_slide(honest: Data) -> None:
    pushed = written(forces=[0.5, 0.2, 0.6])
    for data in (honest, pushed, written(forces=[0.0, -0.05, 0.0], q5=0.3)):
        found = of_arm(data)
        assert found.proven, found.reason
        assert "keep" in found.reason
    hasty = copy.deepcopy(pushed)
    hasty["timing"]["duration"] /= 2
    hasty["arm"]["time"] = [time / 2 for time in hasty["arm"]["time"]]
    hasty["arm"]["peak_joint_speed"] = [2 * one for one in hasty["arm"]["peak_joint_speed"]]
    assert "three phases" in of_arm(hasty).reason
    for name in ("speed", "acceleration", "deceleration"):
        slower = copy.deepcopy(pushed)
        slower["scene"]["motion"] |= {name: 0.01, "law": "slowed"}
        assert "speed is larger, or grows faster" in of_arm(slower).reason
    pushed["scene"]["arm"]["forces"][1] = 3.0
    assert not of_arm(pushed).proven


@pytest.mark.slow
@pytest.mark.parametrize("size", [[1.9, 1.9, 1.9], [1.7, 1.6, 1.8]])
def test_a_right_proof_is_accepted_where_the_curve_turns_and_the_slide_moves(
    size: list[float],
) -> None:
    """There the check knows the time least well, and so where the slide is."""
    box = {"shape": "box", "size": size, "position": [3, 3, 3]}
    found = of_arm(plan(load_scene("paper").replace(obstacles=[box])).to_dict())
    assert found.proven, found.reason


def backwards(rows: list[list[float]]) -> None:
    rows.reverse()


def one_joint_off(rows: list[list[float]]) -> None:
    rows[7][1] += 1e-4


def longer(rows: list[list[float]]) -> None:
    for row in rows:
        row[4] += 0.01


def two_exchanged(rows: list[list[float]]) -> None:
    rows[18], rows[22] = rows[22], rows[18]


def mirrored(rows: list[list[float]]) -> None:
    for row in rows:
        row[:3] = [row[0] + math.pi, -row[1], -row[2]]


def turned_around(rows: list[list[float]]) -> None:
    for row in rows[len(rows) // 2 :]:
        row[0] += 2 * math.pi


def turned_over(rows: list[list[float]]) -> None:
    for row in rows[len(rows) // 3 :]:
        row[1] -= 2 * math.pi


DAMAGES = (backwards, one_joint_off, longer, two_exchanged, mirrored, turned_around, turned_over)


@pytest.mark.parametrize("damage", DAMAGES)
def test_joints_that_do_not_lead_the_tool_along_the_curve_are_refused(
    honest: Data, damage: Callable[[list[list[float]]], None]
) -> None:
    data = copy.deepcopy(honest)
    damage(data["arm"]["positions"])
    data["arm"]["peak_joint_speed"] = [1e6] * 6
    assert not of_arm(data).proven


@pytest.mark.slow
def test_damage_is_refused(honest: Data) -> None:
    random = np.random.default_rng(1)
    planes = len(honest["arm"]["certificate"]["planes"])
    for damage in ("gone", "turned", "shorter", "pose"):
        chosen = int(random.integers(planes))
        data = copy.deepcopy(honest)
        plane = data["arm"]["certificate"]["planes"][chosen]
        if damage == "gone":
            del data["arm"]["certificate"]["planes"][chosen]
        elif damage == "turned":
            plane["direction"] = [-number for number in plane["direction"]]
        elif damage == "shorter":
            plane["t1"] = (plane["t0"] + plane["t1"]) / 2
        else:
            plane["at"] = plane["t1"] + 1.0
        assert not of_arm(data).proven, damage


@pytest.mark.slow
@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("arm", "clearance"), 0.5),
        (("arm", "certificate", "margin"), -0.1),
        (("arm", "elbow"), "down"),
        (("arm", "elbow"), "both"),
        (("arm", "reachable"), False),
        (("arm", "certified"), False),
        (("scene", "arm", "base"), [3.6, -3, 0]),
        (("scene", "obstacles", 0, "position"), [3, 3, 3.2]),
        (("arm", "certificate", "capsules", 5, "radius"), 1.2),
        (("scene", "start"), [0.5, 1, 1.001]),
        (("scene", "goal"), [3.4, 4.6, 3.599]),
        (("timing", "curve"), "quadratic"),
        (("timing", "duration"), 99.0),
        (("arm", "time", -1), 99.0),
        (("arm", "joints"), ["q1", "q3", "q2", "q4", "q5", "q6"]),
        (("arm", "positions"), [[0.0] * 6] * 25),
        (("arm", "positions", 7), [0.0] * 6),
        (("arm", "positions", 7), [0.0] * 5),
    ],
)
def test_a_changed_number_is_refused(honest: Data, path: tuple[Any, ...], value: Any) -> None:
    data = copy.deepcopy(honest)
    section = data
    for key in path[:-1]:
        section = section[key]
    section[path[-1]] = value
    assert not of_arm(data).proven


def test_no_link_may_be_left_out(honest: Data) -> None:
    links = {one["link"] for one in honest["arm"]["certificate"]["capsules"]}
    assert len(links) == 7
    for link in links:
        data = copy.deepcopy(honest)
        certificate = data["arm"]["certificate"]
        certificate["capsules"] = [one for one in certificate["capsules"] if one["link"] != link]
        certificate["planes"] = []
        found = of_arm(data)
        assert not found.proven
        assert f"{link} has no capsule" in found.reason


@pytest.mark.parametrize(
    ("field", "value", "reason"),
    [
        ("radius", 1e-6, "leave a gap along the column"),
        ("neighbour", True, "free to touch"),
        ("grips", True, "free to touch"),
        ("body", "slide", "has no link"),
        ("link", "gripper", "has no link"),
    ],
)
def test_no_capsule_may_be_less_than_its_link(
    honest: Data, field: str, value: object, reason: str
) -> None:
    data = copy.deepcopy(honest)
    for capsule in data["arm"]["certificate"]["capsules"]:
        capsule[field] = value
    found = of_arm(data)
    assert not found.proven
    assert reason in found.reason


def test_the_gripper_begins_beyond_the_sleeve(honest: Data) -> None:
    data = copy.deepcopy(honest)
    for one in data["arm"]["certificate"]["capsules"]:
        one["low"] *= 0.5 if one["link"] == "gripper" else 1.0
    assert "gripper begins too near" in of_arm(data).reason


def test_many_seams_are_a_gap(honest: Data) -> None:
    data = copy.deepcopy(honest)
    capsules = data["arm"]["certificate"]["capsules"]
    column = [one for one in capsules if one["body"] == "column"]
    settings = data["scene"]["arm"]
    seam = (settings["a1"] + settings["a2"]) / 51
    points = [{"low": k * seam, "high": k * seam, "radius": 1e-6} for k in range(52)]
    data["arm"]["certificate"]["capsules"] = [
        *(one for one in capsules if one["body"] != "column"),
        *(one | point for one in column for point in points),
    ]
    assert "leave a gap along the column" in of_arm(data).reason


@given(st.lists(st.floats(0.05, 20.0), min_size=5, max_size=5))
def test_capsules_of_every_arm_leave_no_gap_and_limit_its_elbow(lengths: list[float]) -> None:
    names = ("a1", "a2", "a3", "a4", "a5")
    arm = paper_arm(ArmSettings(**dict(zip(names, lengths, strict=True))), "cm")
    a1, a2, a3, a4, a5 = map(Fraction, lengths)
    exact = ExactArm((Fraction(0),) * 3, a1 + a2, a3, a4 + a5, 1)
    written = json.loads(json.dumps(arm.proof_data()))
    capsules, bend = capsules_of(written, exact, a4), float(arm.limits[2, 1])
    assert len(capsules) == len(arm.capsules)
    check_bend([[0.0, 0.0, -bend]], capsules, a4)
    with pytest.raises(Fault, match="may touch"):
        check_bend([[0.0, 0.0, bend], [0.0, 0.0, bend + 1e-4]], capsules, a4)


@pytest.mark.filterwarnings("error")
def test_a_curve_that_leaves_the_numbers_is_refused(honest: Data) -> None:
    data = copy.deepcopy(honest)
    data["scene"]["motion"]["curve"] = data["timing"]["curve"] = "bspline"
    knots = data["bspline"]["knots"]
    knots[data["bspline"]["degree"] + 1] = 5e-324
    assert not of_arm(data).proven


def test_a_claim_without_a_certificate_is_refused(honest: Data) -> None:
    data = copy.deepcopy(honest)
    data["arm"]["certificate"] = None
    assert "no certificate" in of_arm(data).reason


@pytest.mark.slow
def test_one_direction_serves_for_many_triangles_of_a_mesh() -> None:
    ball = MeshShape.of(clean(*meshes.sphere(4, 1.2)), "ball.stl", position=(3.0, 3.0, 3.0))
    scene = Scene.from_dict(
        {
            "version": 1,
            "start": [0.2, 0.2, 0.2],
            "goal": [5.8, 5.8, 5.8],
            "mesh": {"pitch": 0.8},
            "spline": {"clearance": 0.1},
        }
    ).replace(obstacles=(ball,))
    data: Data = json.loads(json.dumps(plan(scene).to_dict(full=True), allow_nan=False))
    planes = data["arm"]["certificate"]["planes"]
    of_ball = [k for k, one in enumerate(planes) if one["obstacle"] == 0]
    assert len(of_ball) < len(ball.surface.faces) / 4

    found = verify(data, scene.meshes)[2]
    assert found.curve == "arm"
    assert found.proven

    lost = planes[of_ball[len(of_ball) // 2]]
    planes[:] = [
        one for one in planes if (one["t0"], one["capsule"]) != (lost["t0"], lost["capsule"])
    ]
    assert not verify(data, scene.meshes)[2].proven


def test_the_tool_of_a_certified_arm_stays_above_the_floor(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = Scene.from_dict(
        {
            "version": 1,
            "start": [1.4298487936373712, 0.018822964115170704, 0.0],
            "goal": [5.107284445362757, 4.400139424911729, 0.0],
            "obstacles": [
                {
                    "shape": "box",
                    "size": [1.4896403623836987, 1.0350383512211558, 1.396376178987936],
                    "position": [2.4655089163352777, 1.3880784714660122, 2.379340540167939],
                }
            ],
            **{"spline": {"degree": 4, "clearance": 0.3}, "quadratic": {"mode": "pieces"}},
            "mesh": {"pitch": 0.7},
        }
    )
    found = plan(scene)
    assert found.arm_clearance is not None
    assert found.motion is not None
    assert not found.arm_clearance.certified or found.motion.tool[:, 2].min() > -1e-9

    monkeypatch.setattr(arm_clearance, "_dips", lambda *_: [])
    found = plan(scene)
    assert found.motion is not None
    assert found.motion.tool[:, 2].min() < -0.1
    data: Data = json.loads(json.dumps(found.to_dict()))
    assert data["arm"]["certified"]
    assert "the tool gets below the floor" in of_arm(data).reason


@given(
    st.lists(st.floats(-1, 1), min_size=3, max_size=5), st.floats(-0.5, 0.5), st.floats(0.5, 2.0)
)
def test_how_deep_the_tool_dips_is_found_between_the_samples(
    heights: list[float], floor: float, size: float
) -> None:
    points = size * np.column_stack([np.arange(len(heights)), 0 * np.array(heights), heights])
    curve = clamped(points, len(heights) - 1)
    lowest = curve(np.linspace(0.0, 1.0, 2001))[:, 2].min()
    assume(abs(lowest - floor) > 1e-3)
    motion: Any = SimpleNamespace(
        curve=curve, tool=curve(np.linspace(0.0, 1.0, 5)), time=np.linspace(0.0, 1.0, 5)
    )
    found = arm_clearance._dips(motion, paper_arm(ArmSettings()), floor)
    assert bool(found) == (lowest < floor)
    if found:
        assert found[0].depth == pytest.approx(floor - lowest, abs=1e-5)
