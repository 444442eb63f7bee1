"""Verdicts on motions: no sample refutes a proof, and no plate between samples escapes it."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import abi
from abi.arrays import FloatArray
from abi.certification import exact_contact
from abi.certification.certify_motion import _what_fits, certify_motion
from abi.certification.clearance_proof import UndecidedPair, nearest
from abi.certification.joint_limits import _extremes, joint_limits
from abi.certification.motion import Motion
from abi.certification.read_motion import load_motion
from abi.certification.robot_motion import bezier_points, robot_motion
from abi.certification.robot_scene import robot_scene
from abi.certification.verdict import MotionVerdict
from abi.certification.verdict_words import limit_sentences
from abi.errors import AbiError, ArgumentError, SceneError
from abi.export.formats import FORMATS
from abi.planner.arm_words import UNPAIRED_SENTENCE
from abi.scene.scene import Scene, load_scene
from abi.verify.verify import verify
from tests.abi.robot.robots import LINKED_BIT, arm, joint, link, packed, urdf
from tests.thorough import of_each_kind

pytestmark = pytest.mark.slow
JOINTS = (
    *("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"),
    *("wrist_1_joint", "wrist_2_joint", "wrist_3_joint"),
)
UP = [0.0, -1.6, 1.2, -1.2, -1.57, 0.0]


def scene_with(obstacles: list[dict[str, Any]]) -> Scene:
    return robot_scene("ur5e").replace(obstacles=obstacles)


def swing(degree: int = 1) -> dict[str, FloatArray | None]:
    """A swing of the shoulder by half a turn over two waypoints."""
    positions = np.array([UP, UP])
    positions[0, 0], positions[1, 0] = -1.5, 1.5
    still = np.zeros((2, 6))
    return {
        "times": np.array([0.0, 2.0]),
        "positions": positions,
        "velocities": still if degree > 1 else None,
        "accelerations": still if degree > 3 else None,
    }


def verdict_of(scene: Scene, motion: dict[str, Any], **options: Any) -> MotionVerdict:
    return abi.certify(None, JOINTS, scene=scene, **motion, **options)


def tool_at(scene: Scene, share: float) -> FloatArray:
    """Place of the tool in the swing, [m]."""
    verdict = verdict_of(scene, swing())
    chain = verdict.problem.chain
    return np.asarray(
        chain.poses(verdict.problem.motion.positions_at(np.array([share])))[0, -1, :, 3]
    )


@pytest.mark.parametrize("degree", [1, 3, 5])
def test_a_plate_that_a_thousand_samples_miss_is_found(degree: int) -> None:
    empty = scene_with([])
    x, y, z = tool_at(empty, 0.5123456).tolist()
    # a leaf that stands in the way of the tool, far thinner than the step between samples
    plate = {"shape": "box", "size": [0.3, 1e-5, 0.3], "position": [x, y, z]}
    scene = scene_with([plate])
    verdict = verdict_of(scene, swing(degree))
    assert verdict.state == "touches"
    first = verdict.touches[0]
    assert first.obstacle == 0
    assert 0 < first.first < 2
    states = [one.state for one in verdict.stretches]
    assert "touches" in states
    assert states[0] == states[-1] == "clear"
    just, before = verdict.problem.motion, first.first - 1e-4
    assert just.time_at(0.5) == 1.0
    touches = partial(exact_contact.touches, verdict.problem)
    assert touches(first.first / 2 + 1e-7, first.link, 0)
    assert not touches(before / 2, first.link, 0)


def test_a_clear_motion_is_proven_and_its_certificate_verified() -> None:
    box = {"shape": "box", "size": [0.2, 0.2, 0.2], "position": [-0.7, 0.0, 0.3]}
    ball = {"shape": "sphere", "radius": 0.1, "position": [0.0, 0.0, 1.6]}
    scene = scene_with([box, ball])
    verdict = verdict_of(scene, swing(5))
    assert verdict.state == "clear"
    assert verdict.clearance > 0
    distance, _ = nearest(verdict.problem, np.linspace(0, 1, 2001))
    assert verdict.clearance <= distance
    data = json.loads(json.dumps(verdict.to_dict(), allow_nan=False))
    planes = data["certificate"]["planes"]
    planes.append(planes[0] | {"t0": 1, "t1": 1, "at": 1})  # of the end alone
    (proof,) = verify(data)
    assert proof.proven, proof.reason


def test_a_way_narrower_than_what_quick_bodies_leave_is_proven() -> None:
    motion = swing() | {"positions": np.array([UP, UP]) + np.outer([-0.001, 0.001], [1] + [0] * 5)}
    ceiling = {"shape": "box", "size": [2, 2, 0.1], "position": [0.0, 0.0, 3.0]}
    problem = verdict_of(scene_with([ceiling]), motion).problem
    # as the shoulder turns about the vertical, no link gets higher than at first
    least = min(
        exact_contact.distance(problem, 0.0, link, 0)
        for link, frame in problem.chain.frames.items()
        if frame > 0 and problem.chain.robot.links[link].shapes
    )
    gap = 5e-4
    ceiling["position"] = [0.0, 0.0, 3.0 - least + gap]
    verdict = verdict_of(scene_with([ceiling]), motion)
    assert verdict.state == "clear"
    assert 0 < verdict.clearance <= gap
    (proof,) = verify(verdict.to_dict())
    assert proof.proven, proof.reason


@cache
def beside_a_box() -> dict[str, Any]:
    """A certificate that proves the swing clear."""
    box = {"shape": "box", "size": [0.2, 0.2, 0.2], "position": [-0.7, 0.0, 0.3]}
    data: dict[str, Any] = verdict_of(scene_with([box]), swing()).to_dict()
    (proof,) = verify(json.loads(json.dumps(data)))
    assert proof.proven, proof.reason
    return data


def damaged(kind: str, data: dict[str, Any]) -> dict[str, Any]:
    """A certificate that proves nothing any more."""
    data = json.loads(json.dumps(data))
    certificate = data["certificate"]
    if kind == "motion":
        data["motion"]["positions"][1][1] += 2.0
    elif kind == "plane":
        del certificate["planes"][0]
    elif kind == "direction":
        certificate["planes"][0]["direction"] = [-x for x in certificate["planes"][0]["direction"]]
    elif kind == "body":
        certificate["bodies"][-1]["points"] = certificate["bodies"][-1]["points"][:4]
    elif kind == "pair":
        certificate["pairs"].pop()
    elif kind in ("adjacent", "srdf", "always", "mount"):
        first, last = (certificate["bodies"][k]["link"] for k in (0, -1))
        numbers = [k for k, one in enumerate(certificate["bodies"]) if one["link"] in (first, last)]
        certificate["pairs"] = [one for one in certificate["pairs"] if not {*one} <= {*numbers}]
        data["allowed"].append({"link": first, "other": last, "reason": kind})
    elif kind == "stretch":
        data["stretches"][-1]["state"] = "touches"
    elif kind in ("first", "last"):
        data["stretches"][0][kind] += 0.1
    elif kind == "interpolation":
        data["interpolation"] = "quintic"
    elif kind == "sentence":
        data["sentence"] = data["sentence"].replace("keep 0.", "keep 1.")
    elif kind == "unit":
        data["sentence"] = data["sentence"].replace(" m ", " km ")
    elif kind == "number":
        data["sentence"] = data["sentence"].replace("keep 0.", "keep 1-2 and 0.")
    elif kind == "words":
        data["sentence"] = data["sentence"].replace("its moving links", "the whole robot")
    elif kind == "twice":
        data["allowed"].append(data["allowed"][0])
    elif kind == "names":
        data["motion"]["joints"] = [[name] for name in data["motion"]["joints"]]
    elif kind == "contact":
        data["touches"].append({"link": "forearm_link", "obstacle": 0})
    elif kind == "margin":
        certificate["margin"] = data["clearance"] = data["clearance"] + 0.05
    else:
        data["scene"]["obstacles"][0]["position"][0] += 0.45
    return dict(data)


@pytest.mark.parametrize(
    "kind",
    [
        *("motion", "plane", "direction", "body", "pair", "margin", "obstacle"),
        *("stretch", "first", "last", "interpolation", "sentence", "contact"),
        *("unit", "number", "names", "words", "twice"),
        *("adjacent", "srdf", "always", "mount"),
    ],
)
def test_a_damaged_certificate_is_refused(kind: str) -> None:
    (proof,) = verify(damaged(kind, beside_a_box()))
    assert not proof.proven


def test_limits_are_found_where_polynomials_are_largest() -> None:
    motion = swing(3)
    motion["times"] = np.array([0.0, 1.0])
    verdict = verdict_of(scene_with([]), motion, acceleration=5.0)
    passed = {one.quantity: one for one in verdict.limits.passed}
    # from rest to rest, a cubic is fastest in its middle: 1.5 times the mean speed of 3 rad/s
    assert passed["speed"].value == pytest.approx(4.5)
    assert passed["speed"].time == pytest.approx(0.5)
    assert passed["acceleration"].value == pytest.approx(18.0)
    assert verdict.limits.peaks["acceleration"] is not None
    straight = verdict_of(scene_with([]), swing())
    assert straight.limits.peaks["acceleration"] is None


def test_a_motion_is_largest_where_it_is_also_if_its_polynomials_are_of_less_degree() -> None:
    random, polynomial = np.random.default_rng(0), np.polynomial.Polynomial
    shares = np.linspace(0.0, 1.0, 801)
    for degree in (2, 2, 3, 4) * 30:
        way, span = polynomial(random.normal(size=degree + 1)), float(random.uniform(0.1, 9.0))
        ends = np.array([0.0, span])
        q, v, a = (way.deriv(k)(ends / span)[:, None] / span**k for k in range(3))
        # what a controller makes of a parabola's ends is a cubic whose last coefficient is rounding
        motion = Motion(("a",), ends, q, v, None if degree == 2 else a)
        points = bezier_points(motion)[0, :, 0]
        for order in range(2):
            most = float(np.abs(way.deriv(order)(shares)).max())
            assert np.abs(_extremes(points)[1]).max() >= most * (1 - 1e-9)
            points = len(points[1:]) * np.diff(points)


def test_a_link_inside_a_mesh_from_the_first_waypoint_on_is_told(tmp_path: Any) -> None:
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.4)
    content = ball.export(file_type="stl")
    assert isinstance(content, bytes)
    x, y, z = tool_at(scene_with([]), 0.0).tolist()
    mesh = {"shape": "mesh", "file": "ball.stl", "unit": "m", "position": [x, y, z]}
    scene = robot_scene("ur5e").replace(files={"ball.stl": content}, obstacles=[mesh])
    still = swing()
    assert still["positions"] is not None
    still["positions"] = np.repeat(still["positions"][:1], 2, axis=0)
    verdict = verdict_of(scene, still)
    assert verdict.state == "touches"
    assert verdict.touches[0].first == 0.0


def test_what_would_decide_names_what_is_larger_than_its_shape() -> None:
    import trimesh

    content = trimesh.creation.icosphere(subdivisions=1, radius=0.1).export(file_type="stl")
    assert isinstance(content, bytes)
    place = {"position": [2.0, 2.0, 2.0]}
    box = {"shape": "box", "size": [0.1, 0.1, 0.1], **place}
    mesh = {"shape": "mesh", "file": "ball.stl", "unit": "m", **place}
    scene = robot_scene("ur5e").replace(files={"ball.stl": content}, obstacles=[box, mesh])
    scene = scene.replace(arm={"attached": {**box, "position": [0.0, 0.0, 0.2]}})
    problem = verdict_of(scene, swing()).problem
    told = {
        (link, other): _what_fits(
            problem,
            UndecidedPair(link, other, np.zeros((1, 3)), np.ones(1, dtype=bool), spent=False),
        )
        for link in ("held_object", "wrist_3_link")
        for other in (0, 1, "forearm_link")
    }
    assert told["held_object", 1] == "Smaller triangles of obstacle 2 would decide it."
    assert "fit wrist_3_link more closely would" in told["wrist_3_link", 0]
    assert "or smaller triangles of obstacle 2" in told["wrist_3_link", 1]
    assert "fit forearm_link more" in told["held_object", "forearm_link"]
    assert "fit wrist_3_link and forearm_link" in told["wrist_3_link", "forearm_link"]


@pytest.mark.parametrize(
    ("place", "size", "state"),
    [((0.0, 0.0, -0.06), 0.1, "clear"), ((0.12, 0.0, 0.0), 0.12, "touches")],
)
def test_what_stands_still_may_touch_only_what_it_stands_on(
    place: tuple[float, float, float],
    size: float,
    state: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    base = robot_scene("ur5e").arm.base
    at = [float(one + way) for one, way in zip(base, place, strict=True)]
    verdict = verdict_of(
        scene_with([{"shape": "box", "size": [size] * 3, "position": at}]), swing()
    )
    assert verdict.state == state
    assert all(one.link.startswith("base") for one in verdict.touches)
    if verdict.touches:  # what the scene lets touch is told
        pairs = [[one.link, 0] for one in verdict.touches]
        let = verdict_of(verdict.scene.replace(arm={"allowed": pairs}), swing())
        assert let.state == "clear"
        data = json.loads(json.dumps(let.to_dict()))
        told = verify(data, let.scene.meshes)[-1]
        assert told.proven
        assert f"allowed to touch are {pairs[0][0]} and obstacle 1" in told.reason
        data["allowed"] = [one for one in data["allowed"] if one["reason"] != "asked"]
        assert "stands in obstacle 1" in verify(data, let.scene.meshes)[-1].reason
    # the verifier finds by itself what was not compared
    monkeypatch.setattr("abi.certification.certify_motion._standing_in", lambda *_: ([], []))
    scene = verdict.scene
    checked = verify(verdict_of(scene, swing()).to_dict(), scene.meshes)[-1]
    assert checked.proven == (state == "clear")
    assert ("stands in obstacle 1" in checked.reason) == (state == "touches")


@pytest.mark.parametrize(
    ("face", "state"), [(0.99, "touches"), (0.999, "undecided"), (1.003, "clear")]
)
def test_a_round_table_is_clear_of_a_wall_only_if_its_whole_rim_is(face: float, state: str) -> None:
    # the wall faces the middle between two of the corners by which a cylinder is compared
    turned, far, aside = math.pi / 48, face + 0.1, 1.07
    x, y = math.cos(turned), math.sin(turned)
    place = [far * x - aside * y, far * y + aside * x, 0.2]
    wxyz = [math.cos(turned / 2), 0, 0, math.sin(turned / 2)]
    wall = {"shape": "box", "size": [0.2, 4.0, 4.0], "position": place, "wxyz": wxyz}
    round_one = '<collision><geometry><cylinder radius="1" length="0.1"/></geometry></collision>'
    text = urdf(f'<link name="a">{round_one}</link>', link("b"), joint("j", "a", "b"))
    data = {"version": 1, "unit": "m", "obstacles": [wall]}
    data |= {"arm": {"model": "urdf", "urdf": "r.zip", "base": [0, 0, 0.2], "tip": "b"}}
    scene = Scene.from_dict(data, {"r.zip": packed({"r.urdf": text})})
    verdict = abi.certify(None, ("j",), scene=scene, times=[0, 2], positions=[[0.0], [1.0]])
    assert verdict.state == state
    assert state != "clear" or verify(verdict.to_dict(), scene.meshes)[-1].proven


def test_a_held_rod_is_kept_apart_from_the_wrist_that_it_turns_beside() -> None:
    rod = {"shape": "box", "size": [0.03, 0.03, 0.5], "position": [0.1, 0.0, 0.0]}
    scene = scene_with([]).replace(arm={"attached": rod})
    motion = swing()
    motion["positions"] = np.array([[*UP[:5], -3.0], [*UP[:5], 3.0]])
    verdict = verdict_of(scene, motion)
    assert verdict.state == "touches"
    assert verdict.touches[0].link == "held_object"
    reasons = {one.reason for one in verdict.problem.allowed if "held_object" in one}
    assert reasons == {"grasp"}


def test_a_torque_between_far_waypoints_is_found() -> None:
    first, last = (np.array([0, angle, 0, 0, 0, 0]) for angle in (-np.pi / 4, 7 * np.pi / 4))
    peaks = []
    for count in (2, 801):  # stretched out level, where its weight pulls most, on the way
        positions, times = np.linspace(first, last, count), np.linspace(0, 600, count)
        speeds = np.tile((last - first) / 600, (count, 1))
        motion = robot_motion(Motion(JOINTS, times, positions, speeds), scene_with([]))
        peak = joint_limits(motion).peaks["torque"]
        assert peak is not None
        peaks.append(peak)
    np.testing.assert_allclose(peaks[0], peaks[1], rtol=2e-3, atol=1e-3)


def test_a_straight_motion_whose_speed_jumps_is_not_said_to_keep_torques() -> None:
    """Stretched out level, an arm that is too weak for its own weight is told of all the same."""
    positions = np.array([[0, angle, 0, 0, 0, 0] for angle in (0.0, 0.03, 0.0, 0.0)])
    times = np.array([0.0, 0.01, 0.02, 9.0])
    verdict = certify_motion(Motion(JOINTS, times, positions), scene_with([]))
    assert {"torque", "acceleration"} <= {*verdict.limits.to_dict()["not_judged"]}
    assert not any("torque" in one for one in limit_sentences(verdict) if "keep" in one)
    moves = verdict.problem.motion
    weak = replace(moves.chain, efforts=0.01 * moves.chain.efforts)
    passed = joint_limits(replace(moves, chain=weak)).passed
    assert "torque" in {one.quantity for one in passed}


NO_NUMBERS: dict[str, dict[str, Any]] = {
    "masked": {"positions": np.ma.masked_equal([[0.0] * 6, [0.1] * 6], 0.1)},
    "masked velocities": {"velocities": np.ma.masked_equal(np.zeros((2, 6)), 0)},
    "complex": {"positions": np.zeros((2, 6)) + 1j},
    "flags": {"positions": np.zeros((2, 6)) > 1},
    "texts": {"positions": np.zeros((2, 6)).astype(str)},
    "dates": {"times": np.array(["2020-01-01", "2020-01-02"], dtype="datetime64[s]")},
    "intervals as places": {"positions": np.zeros((2, 6), dtype="timedelta64[s]")},
    "gaps": {"positions": np.array([[0.0] * 6, [None] * 6])},
}


@pytest.mark.parametrize("changed", NO_NUMBERS.values(), ids=NO_NUMBERS)
def test_what_is_no_array_of_numbers_is_refused(changed: dict[str, Any]) -> None:
    given = {"times": [0, 1], "positions": np.zeros((2, 6)), **changed}
    with pytest.raises(AbiError, match="which are no numbers"):
        abi.certify("ur5e", JOINTS, **given)


@pytest.mark.parametrize("unit", ["s", "ms", "ns"])
def test_intervals_of_time_are_in_their_own_unit(unit: str) -> None:
    seconds = np.array([0, 2, 3]).astype("timedelta64[s]")
    given = [seconds.astype(f"timedelta64[{unit}]"), np.array([0, 2, 3.0], dtype=object)]
    for times in given:
        motion = Motion(JOINTS, times, np.zeros((3, 6)))
        assert motion.times.tolist() == [0.0, 2.0, 3.0]


@pytest.mark.parametrize(
    "changed",
    [
        {"start": {JOINTS[0]: math.nan}},
        {"start": {JOINTS[0]: None}},
        {"start": {JOINTS[0]: "0.4"}},
        {"acceleration": math.nan},
        {"acceleration": -1.0},
        {"clearance": math.nan},
    ],
)
def test_arguments_that_are_no_numbers_are_refused(changed: dict[str, Any]) -> None:
    with pytest.raises(ArgumentError, match=next(iter(changed))):
        abi.certify("ur5e", JOINTS, [0, 1], np.zeros((2, 6)), **changed)


def test_a_beam_that_the_first_joint_swings_into_the_floor_touches_it(tmp_path: Path) -> None:
    beam = (
        '<link name="beam"><collision><origin xyz="0.6 0 0"/><geometry><box size="1.2 0.1 0.1"/>'
        "</geometry></collision></link>"
    )
    path = tmp_path / "beam.urdf"
    path.write_text(urdf(link("base"), beam, joint("pitch", "base", "beam", axis="0 1 0")))
    place = robot_scene(path)
    scene = place.replace(
        workspace={"min": [-2, -2, 0], "max": [2, 2, 2]}, start=[0, 0, 0], goal=[0, 0, 1]
    )
    corners = np.array([[1.2, y, z] for y in (-0.05, 0.05) for z in (-0.05, 0.05)])
    for angle, state in ((-1.0, "clear"), (0.7, "touches"), (2.2, "touches")):
        verdict = abi.certify(None, ["pitch"], [0, 1], [[0.0], [angle]], scene)
        assert verdict.state == state
        if state == "touches":
            first = verdict.touches[0]
            assert first.obstacle == "floor"
            angles = np.linspace(0.0, angle, 2001)
            frames = verdict.problem.chain.poses(angles[:, None])[:, -1]
            ends = corners @ frames[:, 2, :3].T + frames[:, 2, 3]
            # where it is deepest, also if that is the end
            assert first.depth == pytest.approx(-ends.min(), rel=2e-3)
            assert first.time == pytest.approx(ends.min(axis=0).argmin() / 2000, abs=0.05)
            assert first.last == 1.0
        else:
            (proof,) = verify(json.loads(json.dumps(verdict.to_dict())), scene.meshes)
            assert proof.proven, proof.reason


@pytest.mark.parametrize("meshed", [True, False])
def test_a_robot_alone_has_no_floor_in_its_reach(tmp_path: Path, meshed: bool) -> None:
    far = '<limit lower="40" upper="41" velocity="1" effort="9"/>'
    slide = joint("s", "a", "b", "prismatic", "0 0 -1", far)
    rod = link("b").replace('box size="0.1 0.1 0.3"', 'mesh filename="rod.stl"')
    turn = joint("s", "a", "b", axis="0 1 0")
    parts = (link("a"), rod, turn) if meshed else (link("a"), link("b"), slide)
    trimesh.creation.box((0.1, 0.1, 30.0)).export(tmp_path / "rod.stl")
    (tmp_path / "a.urdf").write_text(urdf(*parts))
    ends = [[0.0], [2.0]] if meshed else [[40.0], [45.0]]  # past the limit of a slide, too
    verdict = abi.certify(tmp_path / "a.urdf", ["s"], [0, 1], ends)
    assert verdict.state == "clear"
    assert not any("floor" in note for note in verdict.to_dict()["notes"])


def test_a_robot_alone_may_slide_without_limits(tmp_path: Path) -> None:
    far = '<limit lower="-1000" upper="1000" velocity="1" effort="9"/>'
    links, names = "abcdefg", [f"s{k}" for k in range(6)]
    ends = zip(names, links[:-1], links[1:], strict=True)
    slides = [joint(*one, "prismatic", "0 0 1", far) for one in ends]
    (tmp_path / "a.urdf").write_text(urdf(*map(link, links), *slides))
    stages = np.array([np.arange(1.0, 7.0), np.arange(1.1, 7.1)])
    assert abi.certify(tmp_path / "a.urdf", names, [0, 1], stages).state == "clear"


@pytest.mark.parametrize("arm", [{}, {"model": "urdf", "urdf": "ur5e"}, {"a3": 1.1}])
def test_a_robot_stands_where_the_scene_says_whatever_its_own_arm_is(arm: dict[str, Any]) -> None:
    box = {"shape": "box", "size": [0.2, 0.2, 0.2], "position": [1.0, 0.0, 0.6]}
    data = {
        **{"version": 1, "unit": "m", "workspace": {"min": [-1] * 3, "max": [2] * 3}},
        **{"start": [0, 0, 0], "goal": [1, 1, 1], "obstacles": [box]},
    }
    for base, state in (((1.0, 0.0, 0.0), "touches"), ((0.0, 0.0, 0.0), "clear")):
        scene = Scene.from_dict({**data, "arm": {**arm, "base": base}})
        upright = [[0.0, -1.5708, 0.0, -1.5, 0.0, 0.0], [0.3, -1.5708, 0.0, -1.5, 0.0, 0.0]]
        verdict = abi.certify("ur5e", JOINTS, [0, 2], upright, scene)
        assert verdict.state == state
        stands = f"The robot stands at ({base[0]:g}, 0, 0) m."
        assert stands in verdict.problem.motion.notes
    unsaid = abi.certify("ur5e", JOINTS, [0, 2], upright, Scene.from_dict(data))
    assert "The robot stands at (0, 0, 0) m." in unsaid.problem.motion.notes


def test_another_robot_takes_the_place_of_a_scenes_own(tmp_path: Path) -> None:
    for name, size in (("old", "0.1 0.1 0.3"), ("new", "0.1 0.1 0.9")):
        (tmp_path / name).mkdir()
        text = arm(('<box size="0.1 0.1 0.3"/>', f'<box size="{size}"/>'))
        (tmp_path / name / "arm.urdf").write_text(text)
    (tmp_path / "all.zip").write_bytes(packed({"x/a.urdf": arm(), "x/b.urdf": LINKED_BIT}))
    of_its_own = {
        **{"model": "urdf", "urdf": "arm.urdf", "tip": "c", "base": [1, 0, 0], "search": "joints"},
        **{"allowed": [["a", "c"]], "gripper": {"s": 1.0}, "start": [0.0, 0.0]},
    }
    room = {"min": [-3] * 3, "max": [3] * 3}
    data = {"version": 1, "unit": "m", "workspace": room, "arm": of_its_own}
    scene = Scene.from_dict({**data, "goal": [0, 0, 1]}, tmp_path / "old")
    assert robot_scene(tmp_path / "old" / "arm.urdf", scene) is scene
    for place in (tmp_path / "new" / "arm.urdf", tmp_path / "all.zip" / "x" / "b.urdf", "ur5e"):
        found = robot_scene(place, scene)
        assert found.arm.robot == robot_scene(place).arm.robot
        assert found.arm.base == (1, 0, 0)
        assert (found.arm.allowed, found.arm.gripper, found.arm.start) == ((), {}, None)
    held = {"shape": "box", "size": [0.1, 0.1, 0.1]}
    with pytest.raises(SceneError, match=r"arm.attached .* none where another robot"):
        robot_scene("ur5e", scene.replace(arm={"attached": held}))


def test_a_continuous_joint_may_have_turned_before(tmp_path: Path) -> None:
    path = tmp_path / "turn.urdf"
    turn = joint("turn", "b", "c", "continuous", "0 1 0", '<limit velocity="1" effort="9"/>')
    path.write_text(urdf(*map(link, "abcd"), joint("p", "a", "b"), turn, joint("q", "c", "d")))
    ball = {"shape": "sphere", "radius": 0.1, "position": [0.5, 0.5, 1.0]}
    scene = robot_scene(path).replace(obstacles=[ball])
    positions = np.array([[0.1, -0.2, 0.1], [0.3, 0.5, -0.4]])
    found = []
    for turns in (0, 1, -2):
        turned = positions + np.array([0.0, 2 * np.pi * turns, 0.0])
        verdict = abi.certify(None, ["p", "turn", "q"], [0, 2], turned, scene)
        assert verdict.limits.passed == ()
        assert verdict.state == "clear"
        found.append(verdict.clearance)
        (proof,) = verify(json.loads(json.dumps(verdict.to_dict())), scene.meshes)
        assert proof.proven, proof.reason
    np.testing.assert_allclose(found, found[0], atol=1e-9)
    for far, is_told in ((3.0, False), (6.0, True)):
        way = np.array([[0.1, far, 0.1], [0.3, 0.0, -0.4]])
        notes = abi.certify(None, ["p", "turn", "q"], [0, 9], way, scene).to_dict()["notes"]
        assert any("turn turns by 6 rad" in note for note in notes) == is_told


@pytest.mark.parametrize(
    "wrong", [{"scene": "kitchen-ur5e"}, {"start": [("p", 1.0)]}, {"joints": None}, {"joints": "p"}]
)
def test_arguments_of_another_kind_are_refused_by_their_names(wrong: dict[str, Any]) -> None:
    given = {"joints": JOINTS, "times": [0, 1], "positions": [UP, UP], "scene": scene_with([])}
    with pytest.raises(ArgumentError) as refusal:
        abi.certify(None, **(given | wrong))  # type: ignore[arg-type]
    assert refusal.value.field == next(iter(wrong))


def test_degrees_are_suspected_only_where_angles_are_large() -> None:
    scene = scene_with([])
    small = np.array([UP, UP])
    small[1, 2] = 5.5  # past 3.14, and no angle that a file in degrees has much less than
    verdict = verdict_of(scene, {"times": [0, 9], "positions": small})
    assert [one.quantity for one in verdict.limits.passed if one.joint == JOINTS[2]] == ["position"]
    small[1, 2] = 40
    with pytest.raises(AbiError, match="would fit in degrees"):
        verdict_of(scene, {"times": [0, 9], "positions": small})


@pytest.mark.parametrize(
    "name", of_each_kind(["two-boxes", "drag-a-box", "arm-in-the-way"], "two-boxes")
)
def test_an_exported_plan_of_the_papers_arm_is_clear_but_for_links_that_it_does_not_compare(
    name: str, tmp_path: Path
) -> None:
    scene = load_scene(name)
    plan = abi.plan(scene)
    for file, kind in (("m.yaml", "ros"), ("arm.zip", "urdf-zip"), ("arm.urdf", "urdf")):
        (tmp_path / file).write_bytes(FORMATS[kind].write(plan, file))
    zipped, alone = (robot_scene(tmp_path / file, scene) for file in ("arm.zip", "arm.urdf"))
    motion = load_motion(tmp_path / "m.yaml", zipped.arm.robot)
    assert any(UNPAIRED_SENTENCE in note for note in motion.notes)
    assert certify_motion(motion, zipped).state == "clear"
    pairs = zipped.arm.robot.may_touch
    touching = {
        frozenset((one.link, one.obstacle)) for one in certify_motion(motion, alone).touches
    }
    assert frozenset(("rod", "upper_arm")) in touching
    assert touching <= pairs
    assert all(pair & {"elbow", "upper_arm"} for pair in pairs)
