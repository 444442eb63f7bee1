"""Motions from further first poses, or drawn to other poses at the goal."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from abi import compiling
from abi.arm_planning.arm_errors import ArmNotClear
from abi.arm_planning.branch.arm_branch import ArmBranch
from abi.arm_planning.urdf_arm_model import UrdfArmModel
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.planner import Planner
from abi.robot.urdf_arm import UrdfArm
from abi.scene.scene import Scene
from abi.tet_mesh.tet_mesh import tetrahedralise
from abi.verify.verify import verify
from tests.abi.robot.robots import arm
from tests.thorough import of_each_kind

Ends = tuple[tuple[float, float, float], tuple[float, float, float]]

BOX = {"shape": "box", "size": (0.118, 0.27, 0.066), "position": (0.079, -0.003, 0.377)}
SHELF = {"shape": "box", "size": (0.282, 0.188, 0.095), "position": (0.461, 0.17, 0.385)}
LAMP = {"shape": "box", "size": (0.227, 0.106, 0.113), "position": (-0.355, 0.218, 0.574)}
DOWN = (0.0, 0.0, -1.0)
CASES: tuple[tuple[str, Any, Ends, list[Any]], ...] = (
    ("panda", None, ((0.449, 0.195, 0.205), (0.084, -0.425, 0.254)), [SHELF]),
    ("panda", DOWN, ((-0.204, 0.406, 0.452), (0.465, 0.325, 0.457)), [LAMP]),
    ("xarm7", None, ((0.543, -0.235, 0.554), (-0.233, 0.347, 0.372)), [BOX]),
)


@pytest.fixture(scope="module", autouse=True)
def _compiled() -> None:
    compiling.compile()


def scene_of(name: str, axis: Any, ends: Ends, obstacles: list[Any]) -> Scene:
    """A scene in metres with a shipped arm in its middle."""
    return Scene.from_dict(
        {
            "version": 1,
            "unit": "m",
            "workspace": {"min": (-0.8, -0.8, 0.0), "max": (0.8, 0.8, 1.1)},
            "mesh": {"lattice": "bcc", "pitch": 0.13},
            "obstacles": obstacles,
            "start": ends[0],
            "goal": ends[1],
            "spline": {"clearance": 0.02},
            "arm": {
                **{"model": "urdf", "urdf": name, "base": (0.0, 0.0, 0.0)},
                **{"clearance": 0.01, "axis": axis, "search": "mesh"},
            },
        }
    )


def no_others(*_: Any) -> tuple[Iterator[ArmBranch], str]:
    return iter(()), ""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "axis", "ends", "obstacles"), of_each_kind(CASES, CASES[1], CASES[2])
)
def test_a_motion_that_the_first_poses_do_not_lead_to_is_found_and_proven(
    name: str, axis: Any, ends: Ends, obstacles: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = scene_of(name, axis, ends, obstacles)
    planner = Planner()
    made, again = planner(scene), Planner()(scene)
    motion, one, clearance = made.motion, made.arm, made.arm_clearance
    assert made.error is None
    assert isinstance(one, UrdfArm)
    assert motion is not None
    assert again.motion is not None
    assert clearance is not None

    np.testing.assert_array_equal(again.motion.positions, motion.positions)
    assert np.abs(motion.tool - motion.target).max() < 1e-4 * one.reach
    np.testing.assert_allclose(motion.tool[[0, -1]], ends, atol=1e-4 * one.reach)
    assert (motion.positions >= one.limits[:, 0] - 1e-12).all()
    assert (motion.positions <= one.limits[:, 1] + 1e-12).all()
    assert np.abs(np.diff(motion.positions, axis=0)).max() < 0.2
    if axis is not None:
        poses = one.chain.poses(motion.positions)
        np.testing.assert_allclose(poses[:, -1, :, 2], np.tile(axis, (len(poses), 1)), atol=1e-5)
    assert clearance.certified
    assert clearance.distance >= scene.arm.clearance
    verdicts = {one.curve: one for one in verify(json.loads(json.dumps(made.to_dict())))}
    assert verdicts["arm"].proven, verdicts["arm"].reason

    monkeypatch.setattr(UrdfArmModel, "other_branches", no_others)
    before = Planner()(scene).error
    assert isinstance(before, ArmNotClear)

    # in haste no others are looked for while the last one leads to a motion
    x, y, z = obstacles[0]["position"]
    dragged = scene.replace(obstacles=[{**obstacles[0], "position": (x, y, z + 1e-4)}])
    hasty = planner(dragged, chosen_only=True, hasty=True)
    assert hasty.is_arm_clear, hasty.error


@pytest.mark.slow
def test_a_goal_that_no_pose_reaches_clear_is_said_with_the_number_of_poses() -> None:
    name, axis, (start, goal), _ = CASES[2]
    x, y, z = goal
    walls = [
        {"shape": "box", "size": (0.2, 0.2, 0.02), "position": (x, y, z + side)}
        for side in (0.06, -0.06)
    ]
    error = Planner()(scene_of(name, axis, (start, goal), walls)).error

    assert isinstance(error, ArmNotClear)
    assert error.where == "goal"
    assert "poses found at the goal none keeps the arm clear." in error.message


def test_an_arm_without_joints_to_spare_has_no_other_poses(tmp_path: Path) -> None:
    (tmp_path / "own.urdf").write_text(arm())
    data = {"version": 1, "unit": "m", "arm": {"model": "urdf", "urdf": "own.urdf"}}
    scene = Scene.from_dict(data, tmp_path)
    model = UrdfArmModel(scene.arm, scene.unit)
    mesh = tetrahedralise(scene.workspace, scene.mesh)
    obstacles = ObstacleSet(scene.obstacles)
    collision_world = model.collision_world(obstacles, 0.0)

    assert len(model.arm.joints) <= 3
    others, note = model.other_branches(scene, collision_world, mesh, 0.01)
    assert list(others) == []
    assert note == ""


def test_a_branch_that_is_named_is_the_one_among_all() -> None:
    name, axis, ends, _ = CASES[0]
    scene = scene_of(name, axis, ends, [LAMP])
    model = UrdfArmModel(scene.arm, scene.unit)
    mesh, solids = tetrahedralise(scene.workspace, scene.mesh), ObstacleSet(scene.obstacles)
    asked = scene, model.collision_world(solids, 0.0), mesh, 0.01

    branches = model.branches(*asked)
    assert len(branches) > 1
    for one in branches:
        (alone,) = model.branches(*asked, one.name)
        assert alone.configurations is one.configurations
    assert model.branches(*asked, "From pose 99 at the start") == ()
    in_turn = [one.name for one in model.branches_in_turn(*asked)]
    assert sorted(in_turn) == sorted(one.name for one in model.branches(*asked))
