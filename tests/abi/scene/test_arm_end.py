"""Ends of an arm that are more than a place of its tool: read, kept, or refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.errors import SceneError
from abi.robot.urdf_arm import urdf_arm
from abi.scene.arm_end import ENDS
from abi.scene.scene import Scene
from tests.abi.robot.robots import OWN, packed

SRDF = """<robot name="r">
<group name="arm"><joint name="p"/><joint name="q"/><joint name="s"/></group>
<group_state name="ready" group="arm"><joint name="p" value="0.5"/><joint name="q" value="-0.4"/>
<joint name="s" value="0.2"/></group_state></robot>"""
FILES = {
    f"{name}.zip": packed({"a.urdf": text, "a.srdf": SRDF})
    for name, text in OWN.items()
    if name != "linked"
}
NAMES = ("p", "q", "s")
angles = st.floats(-2, 2)


def scene(urdf: str = "sliding.zip", unit: str = "m", **fields: Any) -> Scene:
    size = 100 * {"m": 1, "cm": 100, "mm": 1000}[unit]
    data = {
        "version": 1,
        "unit": unit,
        "workspace": {"min": [-size] * 3, "max": [size] * 3},
        "mesh": {"pitch": size},
        **fields,
    }
    data["arm"] = {"model": "urdf", "urdf": urdf, "tip": "d", **data.get("arm", {})}
    return Scene.from_dict(data, FILES)


@pytest.mark.slow
@settings(max_examples=12)
@given(
    st.sampled_from([*FILES]),
    st.sampled_from(["m", "cm", "mm"]),
    st.tuples(angles, angles, angles),
    st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda wxyz: max(map(abs, wxyz)) > 0.1),
    st.sampled_from(ENDS),
)
def test_the_tool_of_given_joints_is_where_the_arm_puts_it(
    urdf: str, unit: str, joints: tuple[float, ...], wxyz: tuple[float, ...], end: str
) -> None:
    metres = {"m": 1.0, "cm": 0.01, "mm": 0.001}[unit]
    given_joints = [joints[0], joints[1], joints[2] / metres]
    base = [1 / metres, 2 / metres, 3 / metres]
    one = scene(
        urdf, unit, **{end: {"joints": given_joints}}, arm={"base": base, "base_wxyz": wxyz}
    )
    arm = urdf_arm(
        one.arm.robot, "d", one.arm.base, None, one.unit, one.arm.base_wxyz, one.arm.gripper
    )
    expected = arm.tool(np.array([given_joints]))[0]
    assert np.array(getattr(one, end)) == pytest.approx(expected, abs=1e-9 / metres)


@pytest.mark.parametrize(
    "end",
    [
        {"joints": [0.5, -0.4, 0.2]},
        {"joints": {"p": 0.5, "q": -0.4, "s": 0.2}},
        {"state": "ready"},
        {
            "position": [1, 2, 3],
            "wxyz": [0, 1, 0, 0],
            "position_tolerance": 0.01,
            "angle_tolerance": 0.1,
        },
    ],
)
def test_ends_are_kept_as_given_wherever_they_are_written(end: dict[str, Any]) -> None:
    one = scene(start=end)
    assert one == scene(arm={"start": end})
    assert hash(one) == hash(scene(arm={"start": end}))
    assert one.to_dict()["arm"]["start"] == end
    assert Scene.from_dict(one.to_dict(), FILES) == one
    assert one.replace(start=one.start) is one
    assert not any("Not used" in note for note in one.notes)
    follows = one.replace(motion={"curve": "bspline"}, arm={"avoid": False})
    told = "Not used, as the motion is sought among the joints: arm.avoid, motion.curve."
    assert told in follows.notes
    assert told not in follows.replace(start=[1.0, 2.0, 2.5]).notes
    # the tool's place alone would be kept there
    with pytest.raises(SceneError, match=r"^arm\.search is 'mesh'"):
        one.replace(arm={"search": "mesh"})


def test_a_list_of_joints_their_names_and_their_state_mean_the_same() -> None:
    places = [
        scene(start={"joints": [0.5, -0.4, 0.2]}).start,
        scene(start={"joints": {"s": 0.2, "q": -0.4, "p": 0.5}}).start,
        scene(start={"state": "ready"}).start,
        scene(arm={"start": [0.5, -0.4, 0.2]}).start,
    ]
    assert all(place == places[0] for place in places)


def test_an_end_that_is_moved_is_a_point_again_and_the_other_stays() -> None:
    one = scene(start={"joints": [0.5, -0.4, 0.2]}, goal={"state": "ready"})
    moved = one.replace(start=(1.0, 2.0, 3.0))
    assert moved.start == (1.0, 2.0, 3.0)
    assert moved.arm.start is None
    assert (moved.goal, moved.arm.goal) == (one.goal, one.arm.goal)


@pytest.mark.parametrize(
    ("end", "message"),
    [
        ({"joints": [0, 0]}, "joints is [0.0, 0.0]; expected 3 numbers, one for each of p"),
        ({"joints": {"x": 0}}, "joints is 'x'; expected a joint that is planned: p, q, s"),
        ({"joints": {"p": 0, "s": 0}}, "arm.start is 'p, s'; expected a position for q, too"),
        ({"joints": [0, 9, 0]}, "arm.start.joints.q is 9.0; expected -2 to 2 rad, the limits of q"),
        ({"joints": [0, 0, 9]}, "arm.start.joints.s is 9.0; expected -2 to 2, the limits of s"),
        ({"joints": ["a"]}, "arm.start.joints is ['a']; expected a number for each joint"),
        ({"joints": [float("nan")] * 3}, "expected a number for each joint"),
        ({"joints": [float("inf"), 10**400, 0]}, "expected a number for each joint"),
        ({"joints": [0, 10**400, 0]}, "expected a number for each joint"),
        ({"state": "home"}, "arm.start.state is 'home'; expected a state of its SRDF: ready"),
        ({}, "arm.start is {}; expected one of joints, state and position"),
        ({"state": "ready", "joints": [0, 0, 0]}, "expected one of joints, state and position"),
        ({"position": [0, 0, 0]}, "expected wxyz with position"),
        ({"state": "ready", "angle_tolerance": 0.1}, "wxyz and tolerances with position alone"),
        ({"joint": [0, 0, 0]}, "did you mean joints?"),
    ],
)  # fmt: skip
def test_what_is_no_end_is_named(end: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError) as caught:
        scene(start=end)
    assert message in str(caught.value)


def test_the_papers_arm_and_a_tool_outside_the_workspace_are_refused() -> None:
    with pytest.raises(SceneError, match="only of an arm from a URDF"):
        Scene.from_dict({"version": 1, "start": {"joints": [0, 0, 0]}})
    space = {"min": [3, 3, 3], "max": [9, 9, 9]}
    with pytest.raises(SceneError, match=r"arm.goal is 'the tool tip at .* in the workspace"):
        scene(start=[3, 3, 3], goal={"state": "ready"}, workspace=space, mesh={})
