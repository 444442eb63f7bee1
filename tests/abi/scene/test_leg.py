"""Wrong legs of a sequence are found as the scene is read, under their own names."""

from __future__ import annotations

from typing import Any

import pytest

from abi.errors import SceneError
from abi.scene.scene import Scene, load_scene

POSE = {"position": [0.5, 4, 0.3], "wxyz": [0, 1, 0, 0]}


@pytest.mark.parametrize(
    ("change", "field", "expected"),
    [
        ({"goal": [0.5, 4, 0.3]}, "goal", "between −0.5 and 0.6 m"),
        ({"goal": POSE}, "goal", "between −0.5 and 0.6 m"),
        ({"goal": {"joints": [0] * 3}}, "goal.joints", "7 numbers"),
        ({"goal": {"joints": [9] * 7}}, "goal.joints.panda_joint1", "the limits of panda_joint1"),
        ({"goal": {"state": "x"}}, "goal.state", "a state of its SRDF"),
        ({"gripper": {"panda_finger_joint1": 9}}, "gripper.panda_finger_joint1", "0 to 0.04 m"),
    ],
)
def test_a_wrong_leg_is_named(change: dict[str, Any], field: str, expected: str) -> None:
    data = load_scene("pick-and-place").to_dict()
    data["tasks"][3] |= change
    with pytest.raises(SceneError) as refused:
        Scene.from_dict(data)
    assert refused.value.field == f"tasks[3].{field}"
    assert expected in refused.value.expected


def test_legs_that_begin_in_joints_are_not_sought_on_a_mesh_of_places() -> None:
    scene = load_scene("pick-and-place").replace(start=[0.5, 0.0, 0.5])
    with pytest.raises(SceneError, match="auto or joints where joints or poses are asked for"):
        scene.replace(arm={"search": "mesh", "start": None, "goal": None})
