"""``open`` and ``closed`` as positions of a gripper's joints."""

from __future__ import annotations

from typing import Any

import pytest

from abi.errors import SceneError
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.planner.task_plan import plan_tasks
from abi.robot.gripper import Opening, gripper_at
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.robot_files import load_robot, robot_from_archive
from abi.scene.scene import Scene
from abi.verify.verify import verify
from tests.abi.robot.robots import arm, packed

FINGER = (
    '<link name="{0}"><collision><geometry><box size="0.02 0.02 0.1"/></geometry></collision>'
    '</link><joint name="{0}_joint" type="prismatic"><origin xyz="{1} 0 0.2"/><parent link="d"/>'
    '<child link="{0}"/><axis xyz="{2} 0 0"/><limit lower="{3}" upper="{4}"/></joint>'
)
STATES = (
    '<robot name="r"><group_state name="Close" group="hand"><joint name="left_joint" value="0.01"/>'
    '</group_state><group_state name="open" group="arm"><joint name="p" value="1"/></group_state>'
    "</robot>"
)


def robot(srdf: str = "", axis: int = 1, extra: str = "") -> Robot:
    """An arm with two fingers, of which the left one opens along its axis or against it."""
    return robot_from_archive(archive(srdf, axis, extra))


def archive(srdf: str = "", axis: int = 1, extra: str = "") -> bytes:
    """The files of that robot."""
    left = FINGER.format("left", 0.02, axis, *((0.0, 0.05) if axis == 1 else (-0.05, 0.0)))
    right = FINGER.format("right", -0.02, -1, 0.0, 0.05)
    files: dict[str, str | bytes] = {"a.urdf": arm(("</robot>", f"{left}{right}{extra}</robot>"))}
    return packed(files | ({"a.srdf": srdf} if srdf else {}))


@pytest.mark.parametrize("axis", [1, -1])
def test_fingers_are_apart_where_it_is_open_whatever_their_axes(axis: int) -> None:
    opened = gripper_at("gripper", robot(axis=axis), "d", "open")
    closed = gripper_at("gripper", robot(axis=axis), "d", "closed")

    assert opened == {"left_joint": 0.05 * axis, "right_joint": 0.05}
    assert closed == {"left_joint": 0.0, "right_joint": 0.0}


def test_a_state_of_the_srdf_counts_where_it_names_joints_beside_the_arm() -> None:
    named = robot(STATES)
    assert gripper_at("gripper", named, "d", "closed") == {"left_joint": 0.01}
    assert gripper_at("gripper", named, "d", "open")["left_joint"] == 0.05


def test_the_state_of_another_hand_does_not_count() -> None:
    # as where two arms have a hand each, and the one of the other arm is told first
    state = '<group_state name="{0}" group="{1}"><joint name="{2}" value="{3}"/></group_state>'
    other = state.format("open", "other_hand", "other_joint", 0.03)
    own = state.format("open", "hand", "left_joint", 0.02)
    hand = robot(
        f"<robot name='r'>{other}{own}</robot>",
        extra=FINGER.format("other", 0.0, 1, 0.0, 0.05).replace(
            'parent link="d"', 'parent link="a"'
        ),
    )
    assert gripper_at("gripper", hand, "d", "open") == {"left_joint": 0.02}
    alone = robot(f"<robot name='r'>{other}</robot>")
    assert gripper_at("gripper", alone, "d", "open") == {"left_joint": 0.05, "right_joint": 0.05}


def test_several_states_of_a_hand_are_refused() -> None:
    state = (
        '<group_state name="open" group="{0}"><joint name="left_joint" value="{1}"/></group_state>'
    )
    twice = [state.format(group, at) for group, at in (("hand", 0.02), ("tool", 0.04))]
    with pytest.raises(SceneError, match="several states of that name"):
        gripper_at("gripper", robot(f"<robot name='r'>{''.join(twice)}</robot>"), "d", "open")


def test_an_end_in_a_state_has_its_gripper_as_that_says() -> None:
    joints = "".join(
        f'<joint name="{name}" value="{at}"/>'
        for name, at in {"p": 0.5, "q": -0.4, "s": 0.2, "left_joint": 0.03}.items()
    )
    ready = f'<robot name="r"><group_state name="ready" group="all">{joints}</group_state></robot>'
    files = {"a.zip": archive(ready)}
    data: dict[str, Any] = {
        "version": 1,
        "unit": "mm",
        "workspace": {"min": [-9e3] * 3, "max": [9e3] * 3},
        "mesh": {"pitch": 9e3},
        "start": {"state": "ready"},
        "arm": {"model": "urdf", "urdf": "a.zip", "tip": "d"},
    }
    with pytest.raises(
        SceneError, match=r"^arm\.start\.state is 'ready'; expected left_joint: 30 in"
    ):
        Scene.from_dict(data, files)
    legs = {"start": {"joints": [0, 0, 0]}, "tasks": [{}, {"goal": {"state": "ready"}}]}
    with pytest.raises(SceneError, match=r"^tasks\[1\]\.goal\.state"):
        Scene.from_dict(data | legs, files)
    # what is held elsewhere on purpose is told, also by a leg before
    for opening in (30.0, 50.0):
        arm = data["arm"] | {"gripper": {"left_joint": opening}}
        scene = Scene.from_dict(data | {"arm": arm}, files)
        assert scene.arm.gripper["left_joint"] == opening
        told = ["left_joint, which is held at 50 where" in note for note in scene.notes]
        assert any(told) == (opening == 50)
    # so is what stands above the base
    part = data["arm"] | {"gripper": {"left_joint": 30.0}, "base_link": "b"}
    notes = Scene.from_dict(data | {"arm": part}, files).notes
    assert "a.zip: The start is ready but for p, which base_link leaves out." in notes
    held = {"goal": {"joints": [0.1, 0, 0]}, "gripper": {"left_joint": 30.0}}
    Scene.from_dict(data | {**legs, "tasks": [{}, held, {"goal": {"state": "ready"}}]}, files)


def test_a_leg_holds_what_the_legs_before_held_and_it_does_not_name() -> None:
    held = {"left_joint": 0.03, "right_joint": 0.01}
    scene = Scene.from_dict(
        {
            "version": 1,
            "unit": "m",
            "workspace": {"min": [-9] * 3, "max": [9] * 3},
            "mesh": {"pitch": 3},
            "start": {"joints": [0, 0, 0]},
            "arm": {
                "model": "urdf",
                "urdf": "a.zip",
                "tip": "d",
                "base": [0, 0, 1],
                "gripper": held,
            },
            "tasks": [
                {"goal": {"joints": [0.1, 0, 0]}},
                {"goal": {"joints": [0.2, 0, 0]}, "gripper": {"right_joint": 0.04}},
                {"goal": {"joints": [0.1, 0, 0]}},
            ],
        },
        {"a.zip": archive()},
    )
    made = plan_tasks(scene)
    legs = made.legs
    assert made.error is None
    assert [leg.scene.arm.gripper["right_joint"] for leg in legs] == [0.01, 0.04, 0.04]
    assert all(leg.scene.arm.gripper["left_joint"] == 0.03 for leg in legs)
    assert all(one.proven for one in verify(made.to_dict(), scene.meshes))


def test_what_the_first_leg_does_not_name_stays_as_the_arm_holds_it() -> None:
    joint = '<joint name="left_joint" value="0.02"/>'
    state = f'<group_state name="open" group="hand">{joint}</group_state>'
    files = {"a.zip": archive(f"<robot name='r'>{state}</robot>")}
    data: dict[str, Any] = {
        "version": 1,
        "unit": "mm",
        "workspace": {"min": [-9e3] * 3, "max": [9e3] * 3},
        "mesh": {"pitch": 9e3},
        "start": {"joints": [0, 0, 0]},
        "arm": {"model": "urdf", "urdf": "a.zip", "tip": "d", "gripper": {"right_joint": 40.0}},
    }
    scene = Scene.from_dict(data | {"goal": {"joints": [0.1, 0, 0]}}, files)
    named: dict[str, float] = {"left_joint": 20.0}
    goal = {"joints": [0.1, 0, 0]}
    for gripper in (named, "open"):
        leg = {"goal": goal, "gripper": gripper}
        changed = scene.replace(tasks=[leg])
        assert changed.arm.gripper == pytest.approx({"right_joint": 40.0} | named)
        assert changed.tasks[0].gripper is None
        assert Scene.from_dict(data | {"tasks": [leg]}, files) == changed
        assert Scene.from_dict(changed.to_dict(), files) == changed
        # in whichever of the two a word is, and where both name a joint
        for own in (named | {"right_joint": 40.0}, "open"):
            arm = data["arm"] | {"gripper": own}
            both = Scene.from_dict(data | {"arm": arm, "tasks": [leg]}, files)
            assert both.arm.gripper["left_joint"] == pytest.approx(20)
        arm = data["arm"] | {"gripper": {"left_joint": 30.0}}
        with pytest.raises(SceneError, match=r"^tasks\[0\]\.gripper is .* left_joint at 30, as in"):
            Scene.from_dict(data | {"arm": arm, "tasks": [leg]}, files)
        # a change from Python says anew what it names
        assert scene.replace(arm={"gripper": {"left_joint": 30.0}}, tasks=[leg]).arm.gripper == (
            pytest.approx(named)
        )


def test_an_arm_without_a_gripper_says_so() -> None:
    with pytest.raises(SceneError, match="behind the planned ones"):
        gripper_at("arm.gripper", load_robot("ur5e", MeshSource()), "tool0", "open")


@pytest.mark.parametrize(("opening", "at"), [("open", 40.0), ("closed", 0.0)])
def test_a_scene_and_its_legs_say_it_in_one_word(opening: Opening, at: float) -> None:
    data: dict[str, Any] = {
        "version": 1,
        "unit": "mm",
        "workspace": {"min": [0, -500, 0], "max": [800, 500, 1000]},
        "start": {"joints": [0, -0.785, 0, -2.356, 0, 1.571, 0.785]},
        "goal": [500, 0, 500],
        "mesh": {"pitch": 200},
        "arm": {"model": "urdf", "urdf": "panda", "base": [0, 0, 0], "gripper": opening},
        "tasks": [{}, {"goal": [500, 100, 500], "gripper": opening}],
    }
    scene = Scene.from_dict(data)
    assert scene.arm.gripper == pytest.approx({"panda_finger_joint1": at})
    assert scene.tasks[1].gripper == scene.arm.gripper
    assert Scene.from_dict(scene.to_dict()) == scene
    with pytest.raises(SceneError, match=r"arm\.gripper"):
        Scene.from_dict(data | {"arm": {"gripper": opening}, "tasks": []})
