"""What is read of SRDF files: pairs, groups and named states, each as far as the robot has it."""

from __future__ import annotations

import copy
import math
import pickle
import tracemalloc
from pathlib import Path

import pytest

from abi.errors import SceneError
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.robot_files import load_robot, robot_from_archive
from abi.scene.scene import Scene, load_scene
from tests.abi.robot.robots import arm, joint, link, packed, urdf


def with_srdf(*parts: str) -> Robot:
    text = f'<robot name="r">{"".join(parts)}</robot>'
    return robot_from_archive(packed({"a.urdf": arm(), "a.srdf": text}))


def test_groups_are_chains_links_joints_and_other_groups() -> None:
    robot = with_srdf(
        '<group name="arm"><chain base_link="a" tip_link="c"/></group>',
        '<group name="last"><link name="d"/><joint name="none"/></group>',
        '<group name="both"><group name="arm"/><group name="last"/></group>',
        '<group name="one"><joint name="q"/></group>',
    )
    assert dict(robot.groups) == {
        "arm": ("p", "q"),
        "last": ("s",),
        "both": ("p", "q", "s"),
        "one": ("q",),
    }


def test_states_hold_positions_within_the_limits() -> None:
    robot = with_srdf(
        '<group_state name="home" group="arm"><joint name="p" value="0.5"/>'
        '<joint name="q" value=" 7 "/><joint name="elsewhere" value="1"/></group_state>',
        '<group_state name="empty" group="arm"/>',
        '<group_state name="wide" group="arm"><joint name="p" value="1 2"/></group_state>',
    )
    assert robot.states == {"home": {"p": 0.5, "q": 2.0}}
    assert any("home" in note for note in robot.notes)
    assert "The limit counts where a state of its SRDF is beyond: q of home." in robot.notes
    for copied in (copy.deepcopy(robot), pickle.loads(pickle.dumps(robot))):
        assert copied.states == robot.states
        assert copied.groups == dict(robot.groups)


def test_whole_turns_of_a_joint_without_limits_are_left_off_in_states() -> None:
    turn = joint("p", "a", "b", "continuous")
    srdf = '<robot name="r"><group_state name="far" group="g"><joint name="p" value="-20"/>'
    files: dict[str, str | bytes] = {"a.srdf": f"{srdf}</group_state></robot>"}
    files["a.urdf"] = urdf(link("a"), link("b"), turn)
    robot = robot_from_archive(packed(files))
    assert robot.states["far"]["p"] == pytest.approx(-20 + 6 * math.pi)
    assert any("Whole turns are left off" in note for note in robot.notes)
    # but not where a slide follows
    slide = (
        '<mimic joint="p" multiplier="0.05"/><limit lower="-9" upper="9" effort="1" velocity="1"/>'
    )
    rack = joint("s", "b", "c", "prismatic", extra=slide)
    files["a.urdf"] = urdf(*map(link, "abc"), turn, rack)
    geared = robot_from_archive(packed(files))
    assert geared.states == {}
    assert any("Left out of its SRDF" in note and "far" in note for note in geared.notes)


def test_states_of_one_name_are_told_apart_by_their_groups() -> None:
    robot = with_srdf(
        '<group_state name="up" group="left"><joint name="p" value="0.5"/></group_state>',
        '<group_state name="up" group="right"><joint name="p" value="-0.5"/></group_state>',
        '<group_state name="low" group="left"><joint name="p" value="9"/></group_state>',
        '<group_state name="low" group="left"><joint name="p" value="0"/></group_state>',
    )
    assert "The last one counts where its SRDF has a state twice: low of left." in robot.notes
    found = {name: positions["p"] for name, positions in robot.states.items()}
    assert found == {"left/up": 0.5, "right/up": -0.5, "low": 0.0}


def test_what_of_an_srdf_is_not_used_or_not_driven_is_told() -> None:
    robot = with_srdf(
        '<virtual_joint name="v" type="planar" parent_frame="world" child_link="a"/>',
        '<passive_joint name="q"/><passive_joint name="elsewhere"/>',
        '<group name="arm"><joint name="p"/></group>',
    )
    assert "Not used of its SRDF: virtual_joint." in robot.notes
    (passive,) = (note for note in robot.notes if "nothing drives" in note)
    assert passive.endswith(": q.")
    assert not any("SRDF" in note for note in with_srdf("<group/>").notes)


def test_a_state_that_is_no_number_is_refused() -> None:
    with pytest.raises(SceneError, match=r"value.*fast"):
        with_srdf('<group_state name="a" group="b"><joint name="p" value="fast"/></group_state>')


def test_all_pairs_of_a_link_may_be_disabled_but_for_some() -> None:
    robot = with_srdf(
        '<disable_default_collisions link="d"/><enable_collisions link1="d" link2="a"/>'
    )
    assert robot.may_touch == {frozenset("db"), frozenset("dc")}


def test_links_that_a_robot_has_not_take_no_room_for_each_link_that_it_has() -> None:
    robot, count = with_srdf(), 5_000
    lines = (f'<disable_default_collisions link="none{k}"/>' for k in range(count))
    text = f'<robot name="r">{"".join(lines)}</robot>'
    files = packed({"a.urdf": arm(), "a.srdf": text})
    tracemalloc.start()
    assert robot_from_archive(files).may_touch == robot.may_touch
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 800 * count


def test_an_srdf_of_another_robot_is_told_of() -> None:
    text = '<robot name="other"><disable_collisions link1="a" link2="c"/></robot>'
    robot = robot_from_archive(packed({"a.urdf": arm(), "a.srdf": text}))
    assert robot.may_touch == {frozenset("ac")}
    assert any("'other'" in note for note in robot.notes)
    assert not any("of a robot" in note for note in with_srdf().notes)


def test_a_scene_names_the_srdf_that_counts(tmp_path: Path) -> None:
    for name, pair in (("one", "ac"), ("two", "bd")):
        text = f'<disable_collisions link1="{pair[0]}" link2="{pair[1]}"/>'
        (tmp_path / f"{name}.srdf").write_text(f'<robot name="r">{text}</robot>')
    (tmp_path / "r.urdf").write_text(arm())
    inside: dict[str, str | bytes] = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    (tmp_path / "r.zip").write_bytes(packed(inside))
    for file in ("r.urdf", "r.zip"):
        source = MeshSource(folder=tmp_path)
        assert not load_robot(file, source).may_touch
        assert load_robot(file, source, srdf="two.srdf").may_touch == {frozenset("bd")}
        (tmp_path / "s.json").write_text(
            f'{{"version": 1, "arm": {{"model": "urdf", "urdf": "{file}", "srdf": "one.srdf"}}}}'
        )
        scene = load_scene(tmp_path / "s.json")
        assert scene.arm.robot.may_touch == {frozenset("ac")}
        (tmp_path / "packed.zip").write_bytes(scene.pack())
        again = load_scene(tmp_path / "packed.zip")
        assert again == scene
        assert again.arm.robot.may_touch == {frozenset("ac")}
        assert scene.replace(arm={"base": (0, 0, 0)}).arm.robot.may_touch == {frozenset("ac")}


@pytest.mark.parametrize(
    ("urdf", "srdf", "expected"),
    [
        ("r.urdf", "none.srdf", "none"),
        ("r.urdf", "r.urdf", "ends in .srdf"),
        ("ur5e", "none.srdf", "shipped"),
    ],
)
def test_an_srdf_that_is_not_there_is_refused(
    tmp_path: Path, urdf: str, srdf: str, expected: str
) -> None:
    (tmp_path / "r.urdf").write_text(arm())
    data = {"version": 1, "arm": {"model": "urdf", "urdf": urdf, "srdf": srdf}}
    with pytest.raises(SceneError, match=rf"arm\.srdf.*{expected}"):
        Scene.from_dict(data, tmp_path)
