"""Plans whose tool keeps a direction for a part of the motion."""

from __future__ import annotations

import copy
import json
import math
from fractions import Fraction
from functools import cache, partial
from typing import Any

import numpy as np
import pytest

from abi.arrays import FloatArray
from abi.explain.diagnosis import explain
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.planner.plan import Plan
from abi.planner.planner import plan
from abi.planner.task_plan import plan_tasks
from abi.robot.urdf.tip_pose import tip_pose
from abi.scene.held_axis import HeldAxis
from abi.scene.scene import Scene, load_scene
from abi.verify.exact.robot_chain import exact_chain
from abi.verify.fault import Fault
from abi.verify.held_direction import check_held_at_samples, check_span
from abi.verify.verify import verify
from abi.verify.verify_tasks import check_tasks

DOWN = {"direction": [0.0, 0.0, -1.0], "tolerance": 0.1}
ALIGNED = [2.0, -1.4, 1.9, -2.0708, -1.5708, 0.4]
"""With the tool straight down."""
TURNED = [0.4, -1.7, 2.0, -1.2, -1.5, 0.0]


@cache
def kitchen() -> Scene:
    """The shipped kitchen with one obstacle, and any direction of the gripper."""
    scene = load_scene("kitchen-ur5e")
    return scene.replace(obstacles=scene.obstacles[2:3], arm={"axis": None})


@cache
def planned(begin: float, end: float, law: str = "three_phase") -> Plan:
    """From a pose that points down, or to one, to another one that does not."""
    ends = (ALIGNED, TURNED) if begin == 0 else (TURNED, ALIGNED)
    axis = {**DOWN, "from": begin, "to": end}
    start, goal = ({"joints": joints} for joints in ends)
    return plan(kitchen().replace(start=start, goal=goal, arm={"axis": axis}, motion={"law": law}))


def angle_off(found: Plan, joints: FloatArray) -> float:
    """Angle between the tip's z axis and straight down, from the robot's joints alone."""
    assert found.motion is not None
    arm = found.scene.arm
    named = dict(zip(found.motion.joints, joints.tolist(), strict=True))
    return math.acos(min(max(-float(tip_pose(arm.robot, arm.tool, named)[2, 2]), -1.0), 1.0))


def angles_off(found: Plan, part: tuple[float, float]) -> list[float]:
    """These angles at many moments of a part of the motion, most of them between samples."""
    assert found.motion is not None
    time, positions = found.motion.time, found.motion.positions
    moments = np.linspace(*part, 300) * time[-1]
    joints = np.stack([np.interp(moments, time, column) for column in positions.T], axis=1)
    return [angle_off(found, one) for one in joints]


def verdict(data: dict[str, Any]) -> Any:
    return next(one for one in verify(data) if one.curve == "arm")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("begin", "end", "law"),
    [(0.0, 0.5, "three_phase"), (0.6, 1.0, "three_phase"), (0.2, 0.8, "three_phase")],
)
def test_the_direction_is_kept_in_its_part_and_left_outside(
    begin: float, end: float, law: str
) -> None:
    found = planned(begin, end, law)
    assert found.error is None, found.error
    assert found.is_arm_clear
    off = max(angles_off(found, (begin, end)))
    assert off <= 0.1
    assert max(angles_off(found, (0, 1))) > 0.5
    (span,) = found.held_spans
    assert found.motion is not None
    assert (span.first, span.last) == pytest.approx(
        (begin * found.motion.time[-1], end * found.motion.time[-1])
    )
    assert off <= span.bound + 1e-9 <= 0.1
    written = json.loads(json.dumps(found.to_dict()))
    assert written["arm"]["axis"] == span._asdict()
    checked = verdict(written)
    assert checked.proven, checked.reason
    assert "within 0.1 rad of its direction" in checked.reason


@pytest.mark.slow
def test_what_is_planned_in_part_is_not_planned_as_a_whole() -> None:
    asked = planned(0.0, 0.5).scene.arm.held_axis
    assert asked is not None
    whole = plan(planned(0.0, 0.5).scene.replace(arm={"axis": DOWN}))
    assert whole.error is not None
    assert whole.error.kind == "direction_not_held"
    off = math.degrees(angle_off(planned(0.0, 0.5), np.array(TURNED)))
    assert f"At the goal the gripper is {off:.3g}° off" in whole.error.message
    assert whole.motion is None
    reason = explain(whole.scene, whole)
    assert reason is not None
    assert reason.change is not None
    assert "of the time works (tested)" in reason.hint
    assert plan(whole.scene.replace(**reason.change)).error is None


@pytest.mark.slow
def test_a_start_that_points_elsewhere_is_told_of() -> None:
    scene = kitchen().replace(start={"joints": TURNED}, goal={"joints": ALIGNED})
    refused = plan(scene.replace(arm={"axis": {**DOWN, "to": 0.5}}))
    assert refused.error is not None
    assert refused.error.message.startswith("At the start the gripper is")


@pytest.mark.slow
def test_a_verifier_refuses_a_part_a_tolerance_or_a_time_that_is_not_kept() -> None:
    honest = json.loads(json.dumps(planned(0.0, 0.5).to_dict()))
    axis = honest["scene"]["arm"]["axis"]
    data = copy.deepcopy(honest)
    data["scene"]["arm"]["axis"] = {**axis, "to": 0.999}
    data["arm"]["axis"]["last"] = 0.999 * data["timing"]["duration"]
    checked = verdict(data)
    assert not checked.proven
    assert "does not keep its direction" in checked.reason

    for claim, reason in (
        ({"first": 0.1}, "at other times"),
        ({"last": 2 * honest["arm"]["axis"]["last"]}, "at other times"),
        ({"tolerance": 0.5 * axis["tolerance"]}, "within another angle"),
    ):
        told = {**honest["arm"], "axis": {**honest["arm"]["axis"], **claim}}
        assert reason in verdict({**honest, "arm": told}).reason
    duration = honest["timing"]["duration"]
    unasked = planned(0.0, 0.5).scene.replace(arm={"axis": None})
    check_span({"axis": None}, unasked, duration)
    with pytest.raises(Fault, match="asks for none"):
        check_span(honest["arm"], unasked, duration)
    with pytest.raises(Fault, match="does not say"):
        check_span({"axis": None}, planned(0.0, 0.5).scene, duration)

    # the other ways to be wrong by the check of the direction alone
    scene, section = planned(0.0, 0.5).scene, honest["arm"]
    chain = exact_chain(scene.arm.robot, scene.arm.tool, scene.arm.base, 1)
    rows = [[*map(Fraction, row)] for row in section["certificate"]["positions"]]
    check = partial(check_held_at_samples, chain=chain, tip=scene.arm.tool, rows=rows)
    check(HeldAxis.model_validate(axis), section=section)
    for change in ({"tolerance": 0.001}, {"direction": [0.0, 0.3, -1.0]}, {"to": 0.999}):
        with pytest.raises(Fault, match="does not keep its direction"):
            check(HeldAxis.model_validate({**axis, **change}), section=section)
    later = [moment**2 for moment in section["time"]]
    for damage, reason in (({"time": later}, "not uniform"), ({"time": later[1:]}, "not those of")):
        with pytest.raises(Fault, match=reason):
            check(HeldAxis.model_validate(axis), section={**section, **damage})


@pytest.mark.slow
def test_points_are_reached_with_the_tool_as_it_has_to_point_there() -> None:
    found = plan(kitchen().replace(arm={"axis": {**DOWN, "from": 0.5}}))
    assert found.error is None, found.error
    assert max(angles_off(found, (0.5, 1))) <= 0.1
    assert found.motion is not None
    assert found.motion.tool[[0, -1]] == pytest.approx(
        np.array([found.scene.start, found.scene.goal]), abs=1e-5
    )


@pytest.mark.slow
def test_each_leg_keeps_its_own_direction() -> None:
    back = {"goal": {"joints": ALIGNED}, "axis": {**DOWN, "from": 0.7}}
    tasks = [{"goal": {"joints": TURNED}, "axis": {**DOWN, "to": 0.5}}, back]
    found = plan_tasks(kitchen().replace(start={"joints": ALIGNED}, tasks=tasks))
    assert found.error is None, found.error
    first, second = found.legs
    assert max(angles_off(first, (0, 0.5))) <= 0.1
    assert max(angles_off(second, (0.7, 1))) <= 0.1
    whole = found.joined
    assert whole.motion is not None
    begins = found.begins
    assert [span.first for span in whole.held_spans] == pytest.approx(
        [0.0, begins[1] + 0.7 * (begins[2] - begins[1])]
    )
    written = json.loads(json.dumps(found.to_dict()))
    assert all(one.proven for one in verify(written)), verify(written)
    written["legs"][1]["scene"]["arm"]["axis"] = None
    source = MeshSource.of(None)
    with pytest.raises(Fault, match="another direction"):
        check_tasks(written, Scene.from_dict(written["scene"], source), source)


def test_where_the_joints_are_at_the_goal_already_no_part_is_sought() -> None:
    start = planned(0.0, 0.5).scene.arm.start
    held = {"axis": {**DOWN, "to": 0.5}, "goal": start}
    scene = planned(0.0, 0.5).scene.replace(arm=held)
    error = plan(scene).error
    assert error is not None
    assert "at the goal already" in error.message
