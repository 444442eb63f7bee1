"""Poses of an arm that stands still are found once, not with every plan."""

from __future__ import annotations

from dataclasses import replace
from unittest.mock import MagicMock

from abi.planner.live_planner import LivePlanner
from abi.planner.planner import Planner
from abi.robot.kinematics.start_poses import first_poses
from abi.robot.urdf_arm import UrdfArm
from abi.scene.scene import load_scene
from app.layers.arm.arm_regions import arm_regions_layer
from app.layers.arm.urdf_poses import end_pose
from app.state.frame import Frame


def test_poses_of_a_drag_without_a_motion_are_found_once() -> None:
    kitchen, planner = load_scene("kitchen-ur5e"), LivePlanner()
    misses = []
    for height in (0.4, 0.45, 0.5):
        wall = {"shape": "box", "size": [0.06, 2, 2], "position": [0, 0.5, height]}
        made = planner.finish(kitchen.replace(obstacles=[wall]))
        assert made.motion is None
        assert isinstance(made.arm, UrdfArm)
        end_pose(made, made.arm, "start")
        misses.append(first_poses.cache_info().misses)
    assert misses == misses[:1] * 3


def test_regions_stay_while_the_start_is_dragged_and_follow_what_else_changes() -> None:
    scene = load_scene("kitchen-ur5e").replace(arm={"avoid": False})
    x, y, z = scene.start
    planner = Planner(compile=False)
    first = Frame(planner(scene), shown=frozenset({"shadow"}))
    moved = replace(first, plan=planner(scene.replace(start=[x, y, z + 0.01])))
    without = replace(first, plan=planner(scene.replace(obstacles=[])))
    layout = MagicMock()
    drawn = layout.client.scene.add_mesh_simple
    draw = arm_regions_layer(layout)
    counts = []
    for frame, interactive in (
        (first, False),
        (moved, True),
        (moved, False),
        (without, True),
    ):
        draw(replace(frame, interactive=interactive))
        counts.append(drawn.call_count)
    assert counts == [1, 1, 2, 3]
