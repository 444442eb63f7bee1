"""Poses of an arm that stands still are found once, not with every plan."""

from __future__ import annotations

import pytest

from abi.arm.urdf_arm import UrdfArm
from abi.arrays import FloatArray
from abi.planner.live_planner import LivePlanner
from abi.scene.scene import load_scene
from app.layers.urdf_poses import first_pose


def test_poses_of_a_drag_without_a_motion_are_found_once(monkeypatch: pytest.MonkeyPatch) -> None:
    kitchen, planner = load_scene("kitchen-ur5e"), LivePlanner()
    asked: list[FloatArray] = []
    find = UrdfArm.first_poses

    def note(arm: UrdfArm, point: FloatArray) -> tuple[FloatArray, ...]:
        asked.append(point)
        return find(arm, point)

    for height in (0.4, 0.45, 0.5):
        wall = {"shape": "box", "size": [0.06, 2, 2], "position": [0, 0.5, height]}
        made = planner.finish(kitchen.replace(obstacles=[wall]))
        assert made.motion is None
        assert isinstance(made.arm, UrdfArm)
        with monkeypatch.context() as patched:
            patched.setattr(UrdfArm, "first_poses", note)
            first_pose(made, made.arm)
    assert len(asked) == 1
