"""The tool that is taken where nobody names one is before a gripper, never in it."""

from __future__ import annotations

import numpy as np
import pytest

from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.robot_files import SHIPPED, load_robot, robot_from_archive
from abi.robot.urdf.usual_tip import usual_tip
from abi.scene.scene import Scene
from tests.abi.robot.robots import LIMIT, OWN, follows, joint, link, packed, urdf

ARM = (
    *map(link, ("base", "l1", "l2", "l3", "hand")),
    *(joint("j1", "base", "l1"), joint("j2", "l1", "l2", axis="1 0 0"), joint("j3", "l2", "l3")),
    joint("flange", "l3", "hand", "fixed", extra=""),
)


def robot_of(*more: str) -> Robot:
    return robot_from_archive(packed({"a.urdf": urdf(*ARM, *more)}))


def row(name: str, parent: str, count: int, kind: str = "revolute", extra: str = LIMIT) -> str:
    """Joints one behind the other."""
    links = [parent, *(f"{name}{k}" for k in range(count))]
    joints = (joint(f"{name}_{k}", links[k], links[k + 1], kind, extra=extra) for k in range(count))
    return "".join([*map(link, links[1:]), *joints])


@pytest.mark.parametrize(
    "gripper",
    [
        row("left", "hand", 1, "prismatic") + row("right", "hand", 1, "prismatic"),
        row("left", "hand", 1) + row("right", "hand", 1, extra=LIMIT + follows("left_0", -1)),
        row("left", "hand", 1) + row("right", "l3", 1),
        row("a", "hand", 2) + row("b", "hand", 2) + row("thumb", "hand", 1),
        row("a", "hand", 2) + row("b", "hand", 2) + row("c", "hand", 2),
        row("jaw", "hand", 1),
        row("gripper_finger", "hand", 1),
    ],
    ids=["slides", "follower", "from both", "linkage", "three fingers", "one jaw", "one finger"],
)
def test_a_gripper_is_not_planned(gripper: str) -> None:
    robot = robot_of(gripper)
    assert usual_tip(robot) == "hand"
    section = {"model": "urdf", "urdf": "a.zip"}
    source = MeshSource({"a.zip": robot.archive})
    scene = Scene.from_dict({"version": 1, "arm": section}, source)
    (note,) = scene.notes
    assert note.startswith("a.zip: The tool tip is hand; j1, j2, j3 are planned, held: ")
    held = [one.name for one in robot.joints if one.name[0] != "j" or "jaw" in one.name]
    masters = [k for k in held if k not in ("flange", "right_0")] or ["right_0"]
    assert all(f"{name} at 0" in note for name in masters)


def test_the_joint_of_a_gripper_is_held_where_the_scene_says() -> None:
    robot = robot_of(row("left", "hand", 1, "prismatic"), row("right", "hand", 1))
    arm = {"model": "urdf", "urdf": "a.zip", "gripper": {"left_0": 50, "right_0": 0.25}}
    source = MeshSource({"a.zip": robot.archive})
    scene = Scene.from_dict({"version": 1, "unit": "cm", "arm": arm}, source)
    assert "held: left_0 at 0.5 m, right_0 at 0.25 rad." in scene.notes[0]


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        (row("w", "hand", 3), "w2"),
        (row("wrist", "hand", 2) + row("camera", "hand", 1), "wrist1"),
        (row("left", "base", 4) + row("right", "base", 4), "right3"),
        (row("gripper_roll", "hand", 1), "gripper_roll0"),
        # a linkage that follows the arm is no second finger
        (row("w", "hand", 1) + row("rod", "hand", 1, extra=LIMIT + follows("j2")), "w0"),
        (row("left", "base", 7) + row("right", "base", 7) + row("rest", "right6", 1), "rest0"),
    ],
    ids=["wrist", "camera", "two arms", "roll", "linkage", "two long arms"],
)
def test_what_is_no_gripper_is_planned(more: str, expected: str) -> None:
    assert usual_tip(robot_of(more)) == expected


@pytest.mark.parametrize("name", ["linked", "sliding"])
def test_an_arm_without_a_gripper_keeps_its_last_link(name: str) -> None:
    assert usual_tip(robot_from_archive(packed({"a.urdf": OWN[name]}))) == "d"


def test_the_hand_of_a_shipped_arm_is_found() -> None:
    robots = {name: load_robot(name, MeshSource()) for name in SHIPPED}
    assert usual_tip(robots["panda"]) == "panda_hand_tcp"
    assert np.isfinite([len(usual_tip(robot)) for robot in robots.values()]).all()
