"""Plans whose ends are joints or poses, and whose motion is sought in the space of the joints."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

import numpy as np
import pytest
import scipy

from abi.arrays import FloatArray
from abi.planner.plan import Plan
from abi.planner.planner import Planner, plan
from abi.robot.urdf.tip_pose import tip_pose
from abi.scene.scene import Scene, load_scene
from abi.verify.verify import verify

START = {
    "shoulder_pan_joint": 2.0,
    "shoulder_lift_joint": -1.4,
    "elbow_joint": 1.9,
    "wrist_1_joint": -2.2,
    "wrist_2_joint": -1.5,
    "wrist_3_joint": 0.4,
}
GOAL = [0.4, -1.7, 2.0, -2.2, -1.5, 0.0]


@cache
def kitchen() -> Scene:
    """The shipped kitchen, with any direction of the gripper."""
    return load_scene("kitchen-ur5e").replace(arm={"axis": None})


def planned(**changes: Any) -> Plan:
    found = plan(kitchen().replace(**changes))
    assert found.error is None, found.error
    return found


def in_tool(scene: Scene, joints: FloatArray) -> FloatArray:
    """Pose of the tool in the world, whose origin is the base, from the robot's joints alone."""
    pose = tip_pose(
        scene.arm.robot, scene.arm.tool, dict(zip(START, joints.tolist(), strict=True))
    ).copy()
    pose[:3, 3] += scene.arm.base
    return pose


@pytest.mark.slow
def test_a_plan_begins_and_ends_with_the_joints_that_are_asked_for() -> None:
    found = planned(start={"joints": START}, goal={"joints": GOAL})
    assert found.motion is not None
    assert found.motion.positions[0] == pytest.approx(list(START.values()), abs=1e-12)
    assert found.motion.positions[-1] == pytest.approx(GOAL, abs=1e-12)
    assert found.motion.within_limits

    written = json.loads(json.dumps(found.to_dict(full=True)))
    assert written["timing"]["curve"] == "joints"
    path, trees = written["joint_search"]["path"], written["joint_search"]["trees"]
    assert path[0] == pytest.approx(list(START.values()))
    assert path[-1] == pytest.approx(GOAL)
    assert [len(tree["tool"]) for tree in trees] == written["joint_search"]["nodes"]


@pytest.mark.slow
def test_a_verifier_is_not_satisfied_with_other_joints_than_those_asked_for() -> None:
    written = planned(start={"joints": START}, goal={"joints": GOAL}).to_dict()
    # the same place of the tool, as its last joint turns about its axis
    written["scene"]["arm"]["goal"] = {"joints": [*GOAL[:5], 0.5]}
    verdict = next(one for one in verify(written) if one.curve == "arm")
    assert not verdict.proven
    assert "joints" in verdict.reason


@pytest.mark.slow
def test_the_tool_ends_in_the_pose_that_is_asked_for() -> None:
    pose = in_tool(kitchen(), np.array(GOAL))
    x, y, z, w = scipy.spatial.transform.Rotation.from_matrix(pose[:3, :3]).as_quat()
    end = {"position": pose[:3, 3].tolist(), "wxyz": [float(part) for part in (w, x, y, z)]}
    found = planned(start={"joints": START}, goal=end)
    assert found.motion is not None
    assert in_tool(found.scene, found.motion.positions[-1]) == pytest.approx(pose, abs=1e-6)
    assert next(one for one in verify(found.to_dict()) if one.curve == "arm").proven


@pytest.mark.slow
def test_a_pose_is_reached_within_its_tolerances_where_it_cannot_be_reached_exactly() -> None:
    pose = in_tool(kitchen(), np.array(GOAL))
    outward = pose[:2, 3] / np.linalg.norm(pose[:2, 3])
    x, y, z, w = scipy.spatial.transform.Rotation.from_matrix(pose[:3, :3]).as_quat()
    reach = 0.96  # a little more than an arm that points down reaches at this height
    place = [*(reach * outward).tolist(), float(pose[2, 3])]
    exact = {"position": place, "wxyz": [float(part) for part in (w, x, y, z)]}
    wide = {"min": [-1.2, -1.2, 0.0], "max": [1.2, 1.2, 1.2]}
    scene = kitchen().replace(workspace=wide, obstacles=[], mesh={"pitch": 0.3})
    refused = plan(scene.replace(goal=exact))
    assert refused.error is not None
    assert refused.error.kind == "no_joint_motion"
    assert "goal" in refused.error.message
    tolerant = plan(scene.replace(goal=exact | {"position_tolerance": 0.2, "angle_tolerance": 0.5}))
    assert tolerant.motion is not None
    reached = in_tool(scene, tolerant.motion.positions[-1])
    assert np.linalg.norm(reached[:3, 3] - place) <= 0.2
    between = scipy.spatial.transform.Rotation.from_matrix(reached[:3, :3] @ pose[:3, :3].T)
    assert between.magnitude() <= 0.5


@pytest.mark.slow
def test_a_second_leg_begins_where_the_first_one_ends() -> None:
    first = planned()
    assert first.motion is not None
    joints = first.motion.positions[-1]
    second = planned(start={"joints": joints.tolist()}, goal=[0.3, 0.6, 0.35])
    assert second.motion is not None
    assert np.abs(second.motion.positions[0] - joints).max() <= 1e-12


_WALLS: list[tuple[list[float], list[float], list[list[float]]]] = [
    ([-0.2, 0.15, 0.44], [0.2, 0.65, 0.28], [[0.15, 0.34, 0.41, 0.37, 0.19, 0.39],
     [0.45, 0.24, 0.32, -0.38, 0.5, 0.65], [0.42, 0.45, 0.35, -0.2, 0.56, 0.23],
     [0.42, 0.08, 0.42, -0.27, 0.33, 0.29]]),
    ([-0.03, 0.2, 0.4], [-0.17, 0.65, 0.36], [[0.12, 0.44, 0.24, -0.38, 0.26, 0.33],
     [0.06, 0.11, 0.18, -0.13, 0.36, 0.28], [0.19, 0.26, 0.21, 0.2, 0.57, 0.11],
     [0.12, 0.1, 0.21, -0.11, 0.55, 0.54]]),
]  # fmt: skip


@pytest.mark.slow
def test_where_the_mesh_has_no_motion_one_is_found_in_the_space_of_the_joints(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fallen_back, asked = 0, list[bool]()
    avoid = Planner._avoid

    def noted(*args: Any) -> Plan:
        asked.append(True)
        return avoid(*args)

    monkeypatch.setattr(Planner, "_avoid", noted)
    for start, goal, boxes in _WALLS:
        obstacles = [{"shape": "box", "size": row[:3], "position": row[3:]} for row in boxes]
        scene = kitchen().replace(start=start, goal=goal, obstacles=obstacles)
        on_mesh = plan(scene.replace(arm={"search": "mesh"}))
        planner = Planner()
        found = planner(scene)
        assert found.is_arm_clear
        if found.joint_search is not None:  # in haste it is sought there at once
            asked.clear()
            lower = {**obstacles[0], "position": (*boxes[0][3:5], boxes[0][5] - 1e-4)}
            dragged = scene.replace(obstacles=[lower, *obstacles[1:]])
            assert planner(dragged, chosen_only=True, hasty=True).is_arm_clear
            assert not asked
        assert (found.joint_search is None) == (on_mesh.error is None)
        fallen_back += found.joint_search is not None
    assert fallen_back


@pytest.mark.slow
def test_what_is_in_the_way_at_asked_joints_is_named() -> None:
    folded = [0.4, 0.9, 1.0, -2.2, -1.5, 0.0]
    wide = {"min": [-1.2, -1.2, -1.2], "max": [1.2, 1.2, 1.2]}
    scene = kitchen().replace(workspace=wide, mesh={"pitch": 0.3}, goal={"joints": folded})
    found = plan(scene)
    assert found.error is not None
    assert "In the pose asked for at the goal" in found.error.message
    assert found.motion is None


@pytest.mark.slow
def test_an_equal_scene_is_not_searched_again() -> None:
    planner = Planner()
    scene = kitchen().replace(start={"joints": START}, goal={"joints": GOAL})
    assert planner(scene).joint_search is planner(scene).joint_search


@pytest.mark.slow
def test_in_haste_a_path_is_kept_as_long_as_it_is_proven_clear() -> None:
    planner, scene = Planner(), kitchen().replace(start={"joints": START}, goal={"joints": GOAL})
    first = planner(scene)
    assert first.motion is not None
    tool = first.motion.tool
    above = tool[len(tool) // 2] + [0.0, 0.0, 0.4]

    def with_box(down: float) -> tuple[Scene, Plan]:
        place = (above - [0.0, 0.0, down]).tolist()
        boxes = [one.model_dump() for one in scene.obstacles]
        boxes.append({"shape": "box", "size": [0.06] * 3, "position": place})
        dragged = scene.replace(obstacles=boxes)
        return dragged, planner(dragged, chosen_only=True, hasty=True)

    near, kept = with_box(0.05)
    assert kept.joint_search is not None
    assert kept.joint_search.samples == 0
    assert len(kept.joint_search.trees[0].edges) == kept.joint_search.proofs
    assert verify(json.loads(json.dumps(kept.to_dict())), near.meshes)[-1].proven
    blocked, other = with_box(0.38)
    assert other.joint_search is None or other.joint_search.samples > 0
    rested, fresh = planner(blocked), plan(blocked)
    assert rested.joint_search is not None
    assert fresh.joint_search is not None
    assert rested.joint_search.path is not None
    np.testing.assert_array_equal(rested.joint_search.path, fresh.joint_search.path)
