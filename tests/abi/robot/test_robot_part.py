"""An arm from one of its links on, as chain, scene, plan, certificate and file."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
import pytest
import yourdfpy

from abi.errors import SceneError
from abi.export.formats import FORMATS
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.planner.planner import Planner
from abi.robot.kinematics.chain import Chain
from abi.robot.urdf.robot import bases_to, part_from
from abi.robot.urdf.robot_files import SHIPPED, load_robot, robot_from_archive
from abi.robot.urdf.urdf_files import description_of
from abi.robot.urdf_arm import UrdfArm
from abi.scene.scene import Scene, load_scene
from abi.verify.verify import verify
from tests.abi.robot.robots import LINKED_BIT, arm, joint, link, packed, urdf

# two arms on one column, of which the right one has a joint more
TWO_ARMS = urdf(
    *map(link, ("column", "l1", "l2", "r1", "r2", "r3")),
    joint("turn", "column", "l1"),
    joint("l", "l1", "l2", axis="1 0 0"),
    joint("r", "column", "r1", axis="1 0 0"),
    joint("s", "r1", "r2", axis="0 1 0"),
    joint("t", "r2", "r3", axis="1 0 0"),
    '<transmission name="x"><joint name="turn"/></transmission>',
)


@pytest.mark.parametrize("name", SHIPPED)
def test_an_arm_from_any_base_moves_as_in_the_whole(name: str) -> None:
    robot = load_robot(name, MeshSource())
    whole = Chain.of(robot, SHIPPED[name])
    low, high = whole.limits.T
    positions = np.random.default_rng(0).uniform(low, high, (6, len(low)))
    standing = whole.poses(positions)
    bases = bases_to(robot, SHIPPED[name])
    assert bases[0] == robot.root
    for base in bases:
        part = part_from(robot, base)
        chain = Chain.of(part, SHIPPED[name])
        columns = [whole.names.index(one) for one in chain.names]
        frame = np.tile(np.eye(4), (len(positions), 1, 1))
        if whole.frames[base] >= 0:
            frame[:, :3] = standing[:, whole.frames[base]]
        frame = frame @ whole.places[base]
        tips = frame[:, :3, :3] @ chain.poses(positions[:, columns])[:, -1]
        tips[..., 3] += frame[:, :3, 3]
        np.testing.assert_allclose(tips, standing[:, -1], atol=1e-12)
        assert set(chain.frames) == set(part.links)


def test_bases_that_do_not_work_are_told_from_those_that_do() -> None:
    def scene(**change: str) -> Scene:
        section = {"model": "urdf", "urdf": "two.zip", **change}
        source = MeshSource({"two.zip": packed({"two.urdf": TWO_ARMS})})
        return Scene.from_dict({"version": 1, "arm": section}, source)

    assert scene().arm.tool == "r3"
    assert scene(base_link="l1").arm.tool == "l2"
    assert [*scene(base_link="r1").arm.robot.links] == ["r1", "r2", "r3"]
    told = "as r1 does not carry them: column, l1, l2."
    assert any(told in note for note in scene(base_link="r1").notes)
    for wrong in ({"base_link": "r1", "tip": "l2"}, {"base_link": "x", "tip": "l2"}):
        with pytest.raises(SceneError, match=r"arm\.base_link .*move l2: column, l1\."):
            scene(**wrong)
    with pytest.raises(SceneError, match=r"arm\.base_link is 'r3'; .*move r3: column, r1, r2\."):
        scene(base_link="r3")
    again = scene(base_link="r1", tip="r3")
    assert Scene.from_dict(again.to_dict(), again.meshes) == again
    assert again != scene(tip="r3")
    assert again.arm.robot != scene(tip="r3").arm.robot


def test_no_joint_follows_one_that_is_left_out() -> None:
    robot = robot_from_archive(packed({"a.urdf": LINKED_BIT}))
    assert bases_to(robot, "d") == ("a",)
    assert bases_to(robot_from_archive(packed({"a.urdf": arm()})), "d") == ("a", "b", "c")


def test_a_base_that_follows_a_planned_joint_is_refused() -> None:
    follows = '<mimic joint="p"/><limit lower="-2" upper="2" velocity="1" effort="9"/>'
    lift = joint("lift", "root", "a", "prismatic", extra=follows)
    text = arm().replace("</robot>", link("root") + lift + "</robot>")
    with pytest.raises(SceneError, match="lift above it follows p"):
        Scene.from_dict(
            {
                "version": 1,
                "unit": "m",
                "arm": {"model": "urdf", "urdf": "a.zip", "base_link": "a"},
            },
            {"a.zip": packed({"a.urdf": text})},
        )


def test_a_scene_with_a_base_link_is_saved_and_opened(tmp_path: Path) -> None:
    content = packed({"a.urdf": arm()})
    section = {"model": "urdf", "urdf": "a.zip", "base_link": "b"}
    scene = Scene.from_dict({"version": 1, "arm": section}, MeshSource({"a.zip": content}))
    (tmp_path / "scene.zip").write_bytes(scene.pack())
    assert load_scene(tmp_path / "scene.zip") == scene


def test_the_file_of_a_part_has_only_that_part() -> None:
    robot = robot_from_archive(packed({"two.urdf": TWO_ARMS}))
    assert description_of(robot) == TWO_ARMS
    read = yourdfpy.URDF.load(io.BytesIO(description_of(part_from(robot, "r1")).encode()))
    assert read.base_link == "r1"
    assert {*read.link_map} == {"r1", "r2", "r3"}
    chain = Chain.of(part_from(robot, "r1"), "r3")
    read.update_cfg(dict(zip(chain.names, (0.3, -0.7), strict=True)))
    tip = chain.poses(np.array([[0.3, -0.7]]))[0, -1]
    np.testing.assert_allclose(read.get_transform("r3")[:3], tip, atol=1e-12)


@pytest.mark.slow
def test_a_plan_from_another_base_is_proven_and_exported() -> None:
    kitchen = load_scene("kitchen-ur5e")
    # the fixed joint between them turns by half a turn about z
    on_link = kitchen.replace(arm={"base_link": "base_link_inertia", "base_wxyz": (0, 0, 0, 1)})
    whole, part = Planner()(kitchen), Planner()(on_link)
    assert whole.motion is not None
    assert part.motion is not None
    assert isinstance(part.arm, UrdfArm)
    assert part.arm.chain.robot.root == "base_link_inertia"
    np.testing.assert_allclose(part.motion.positions, whole.motion.positions, atol=1e-6)

    data = json.loads(json.dumps(part.to_dict()))
    assert data["arm"]["certified"]
    assert next(one for one in verify(data) if one.curve == "arm").proven
    data["scene"]["arm"]["base_link"] = "shoulder_link"
    assert not next(one for one in verify(data) if one.curve == "arm").proven
    packed_arm = robot_from_archive(FORMATS["urdf-zip"].write(part, "arm.zip"))
    assert packed_arm.root == "base_link_inertia"
    assert packed_arm.links.keys() == part.arm.chain.robot.links.keys()
