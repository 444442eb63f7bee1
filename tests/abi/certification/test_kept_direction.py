"""The direction that a scene asks of the tool: samples never refute what is said to be kept."""

from __future__ import annotations

import copy
import json
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest
import scipy

from abi.arrays import FloatArray
from abi.certification.certify_motion import certify_motion
from abi.certification.kept_direction import KeptDirection, _angles, kept_direction
from abi.certification.motion import Motion
from abi.certification.read_message import read_message
from abi.certification.robot_motion import RobotMotion, robot_motion
from abi.certification.robot_scene import robot_scene
from abi.certification.verdict_words import direction_sentences
from abi.errors import AbiError
from abi.planner.planner import plan
from abi.scene.scene import Scene, load_scene
from abi.verify import held_direction
from abi.verify.exact.robot_chain import exact_joints
from abi.verify.exact_path import exact_path
from abi.verify.fault import Fault
from abi.verify.held_direction import check_held_in_motion
from abi.verify.verify import verify
from tests.thorough import of_each_kind

pytestmark = pytest.mark.slow
JOINTS = (
    *("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"),
    *("wrist_1_joint", "wrist_2_joint", "wrist_3_joint"),
)
DOWN = [0.2, -1.4, 1.9, -2.0708, -1.5708, 0.4]
"""With the tool of UR5e straight down."""


@cache
def alone() -> Scene:
    return robot_scene("ur5e")


def holding(**axis: Any) -> Scene:
    return alone().replace(arm={"axis": {"direction": [0.0, 0.0, -1.0], **axis}})


def nodding(degree: int, by: float) -> Motion:
    """The tool nods by an angle and back between three waypoints, at which it is down."""
    count = 3
    positions, rates = np.tile(DOWN, (count, 1)), np.zeros((count, 6))
    positions[:, 0] += [0.0, 0.4, 0.8]  # turns about the vertical, so it stays down
    if degree == 1:
        positions = np.insert(positions, 1, positions[:2].mean(axis=0), axis=0)
        positions[1, 3] += by
        return Motion(JOINTS, np.arange(4.0), positions)
    # from a speed u to rest a cubic is off by 4 u / 27 after a third, a quintic by 16 u / 81
    rates[0, 3] = 27 / 4 * by if degree == 3 else 81 / 16 * by
    still = np.zeros((count, 6)) if degree == 5 else None
    return Motion(JOINTS, np.arange(3.0), positions, rates, still)


def angle_off(motion: RobotMotion, scene: Scene, parameters: FloatArray) -> FloatArray:
    """Angle between the tool's z axis and straight down, [rad]."""
    chain, tip = motion.chain, scene.arm.tool
    frames = chain.poses(motion.positions_at(parameters))[:, chain.frames[tip]]
    z = frames[:, :, :3] @ chain.places[tip][:3, 2]
    return np.asarray(np.arctan2(np.hypot(z[:, 0], z[:, 1]), -z[:, 2]))


def judged(motion: Motion, scene: Scene) -> KeptDirection:
    found = kept_direction(robot_motion(motion, scene), scene)
    assert found is not None
    return found


@pytest.mark.parametrize("degree", [1, 3, 5])
def test_a_nod_between_waypoints_is_found(degree: int) -> None:
    scene = holding(tolerance=0.1)
    assert judged(nodding(degree, 0.099), scene).state == "kept"
    found = judged(nodding(degree, 0.2), scene)
    assert found.state == "left"
    assert found.angle == pytest.approx(0.2, rel=1e-3)
    ((first, last),) = found.stretches
    assert first < 1 < last if degree == 1 else first < 1 / 3 < last
    moved = robot_motion(nodding(degree, 0.2), scene)
    at = np.linspace(0.0, float(len(moved.points)), 4001)
    beyond = at[angle_off(moved, scene, at) > 0.1]  # a waypoint a second
    assert (first, last) == pytest.approx((beyond[0], beyond[-1]), abs=2e-3)


def test_only_the_part_that_is_asked_for_counts() -> None:
    nod = nodding(3, 0.2)  # within the first of two seconds
    assert judged(nod, holding(tolerance=0.1, **{"from": 0.5})).state == "kept"
    assert judged(nod, holding(tolerance=0.1, to=0.5)).state == "left"
    assert judged(nod, holding(tolerance=0.1, to=0.04)).state == "kept"
    untimed = Motion(JOINTS, nod.times, nod.positions, timed=False)
    assert judged(untimed, holding(tolerance=0.1)).state == "kept"
    assert judged(untimed, holding(tolerance=0.1, to=0.5)).state == "not judged"


@pytest.mark.parametrize("seed", of_each_kind(range(40), *range(6)))
def test_samples_never_refute_a_direction_that_is_kept(seed: int) -> None:
    random = np.random.default_rng(seed)
    count = int(random.integers(2, 6))
    positions = np.array(DOWN) + random.normal(scale=0.1, size=(count, 6))
    rates = random.normal(scale=0.2, size=(2, count, 6))
    times = np.cumsum(random.uniform(0.1, 1, count))
    speeds, growths = (rates[k] if seed % 3 > k else None for k in range(2))
    motion = Motion(JOINTS, times, positions, speeds, growths)
    begin, end = np.sort(random.uniform(size=2)).tolist()
    scene = holding(tolerance=0.1)
    moved = robot_motion(motion, scene)
    duration = motion.times[-1] - motion.times[0]
    times = motion.times[0] + duration * np.linspace(begin, end, 2001)
    off = angle_off(moved, scene, np.interp(times, motion.times, np.arange(float(count))))
    # a tolerance a little above the largest angle is proven, one a little below is not
    for factor, state in ((1.01, "kept"), (0.99, "left")):
        tolerance = float(factor * off.max())
        axis = {"tolerance": tolerance, "from": begin, "to": end}
        found = judged(motion, holding(**axis))
        assert found.state == state
        assert found.angle is not None
        assert (found.angle <= tolerance) == (state == "kept")
        for first, last in found.stretches:
            assert times[0] - 1e-12 <= first < last <= times[-1] + 1e-12
        outside = np.ones(len(times), dtype=bool)
        for first, last in found.stretches:
            outside &= (times < first - 1e-12) | (times > last + 1e-12)
        assert off[outside].max(initial=0.0) <= tolerance + 1e-9


def test_the_verdict_is_checked_again_in_exact_numbers() -> None:
    scene = holding(tolerance=0.1)
    verdict = certify_motion(nodding(3, 0.098), scene)
    assert verdict.direction is not None
    assert verdict.direction.state == "kept"
    assert "keeps its direction" in direction_sentences(verdict)[0]
    honest = verdict.to_dict()
    (checked,) = verify(honest)
    assert checked.proven, checked.reason
    assert "of its direction" in checked.reason
    # the same said of a motion that does not keep it
    liar = certify_motion(nodding(3, 0.102), scene).to_dict()
    assert liar["verdict"] == "clear"
    liar["direction"] = honest["direction"]
    assert "does not keep" in verify(liar)[0].reason


@pytest.mark.parametrize("degree", [1, 3, 5])
def test_another_direction_or_part_than_the_scene_s_is_refused(
    degree: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = holding(tolerance=0.1)
    verdict = certify_motion(nodding(degree, 0.098), scene)
    data = verdict.to_dict()
    chain = exact_joints(scene.arm.robot, JOINTS, scene.arm.base, 1, scene.arm.base_wxyz)
    path = exact_path(data["motion"], [1] * len(JOINTS))
    assert "of its direction" in check_held_in_motion(data, scene, chain, path)
    # with a tenth of a milliradian of room no turn, but how far the axis leaves its chord tells
    near = certify_motion(nodding(degree, 0.0999), scene).to_dict()
    monkeypatch.setattr(held_direction, "_MOST_STRETCHES", 48)
    own = exact_path(near["motion"], [1] * len(JOINTS))
    assert "of its direction" in check_held_in_motion(near, scene, chain, own)
    monkeypatch.setattr(held_direction, "_MOST_STRETCHES", 3)
    with pytest.raises(Fault, match="too little room"):
        check_held_in_motion(data, scene, chain, path)
    monkeypatch.undo()
    silent = {**data, "direction": None}
    assert "not said to be kept" in check_held_in_motion(silent, scene, chain, path)
    assert check_held_in_motion(silent, alone().replace(arm={"axis": None}), chain, path) == ""
    for damage in ({"tolerance": 0.2}, {"last": 1.0}):
        wrong = {**data, "direction": data["direction"] | damage}
        with pytest.raises(Fault):
            check_held_in_motion(wrong, scene, chain, path)
    with pytest.raises(Fault, match="not the scene's"):
        check_held_in_motion(data, alone(), chain, path)


@pytest.mark.parametrize("degree", [1, 3, 5])
def test_between_its_ends_an_axis_is_no_farther_off_than_its_bow(degree: int) -> None:
    random = np.random.default_rng(degree)
    scene = alone()
    chain = exact_joints(scene.arm.robot, JOINTS, scene.arm.base, 1, scene.arm.base_wxyz)
    for size in (0.001, 0.003, 0.01):
        points = random.uniform(-3, 3, len(JOINTS)) + size * random.normal(size=(degree + 1, 6))
        path = [tuple([Fraction(one) for one in row] for row in points.tolist())]
        begin, end = Fraction(1, 8), Fraction(7, 8)
        bow = held_direction._bow(chain, scene.arm.tool, path, begin, end)
        assert bow is not None
        shares = np.linspace(0.125, 0.875, 101)
        curve = scipy.interpolate.BPoly(points[:, None], [0, 1])(shares)
        moves = robot_motion(Motion(JOINTS, np.array([0.0, 1.0]), points[[0, -1]]), scene)
        for direction in random.normal(size=(20, 3)):
            angles = _angles(moves.chain, scene.arm.tool, direction, curve)
            farthest = max(angles[0], angles[-1])
            assert farthest > 1.5 or angles.max() <= farthest + float(bow) + 1e-9


def test_a_planned_motion_keeps_what_its_scene_holds_exactly() -> None:
    scene = load_scene("kitchen-ur5e")
    assert scene.arm.exact_axis is not None
    found = plan(scene)
    assert found.motion is not None
    positions = found.motion.positions
    turned = Motion(found.motion.joints, found.motion.time, positions)
    assert judged(turned, scene).state == "kept"
    # all samples are read of its JSON, from its certificate or in full
    for data in (found.to_dict(), found.to_dict(full=True)):
        read = read_message(json.loads(json.dumps(data)), ())
        assert (read.positions == positions).all()
        np.testing.assert_allclose(read.times, found.motion.time, atol=1e-12)
        early, last = data["arm"]["time"][1] / 2, data["arm"]["positions"][-1]
        for name, value in (("time", early), ("positions", last)):
            other = copy.deepcopy(data)
            other["arm"][name][1] = value
            with pytest.raises(AbiError, match="not those of its certificate"):
                read_message(other, ())
        data["arm"] |= {"certificate": None, "certified": False}
        if data["arm"]["positions"] == positions.tolist():
            assert "NOT proven" in read_message(data, ()).notes[0]
        else:
            with pytest.raises(AbiError, match="only some of the samples"):
                read_message(data, ())
    off = positions.copy()
    off[200, 4] += 0.02
    assert judged(Motion(found.motion.joints, found.motion.time, off), scene).state == "left"
    assert kept_direction(robot_motion(turned, scene), scene.replace(arm={"axis": None})) is None
