"""What no check reads is named, and a change to anything else that a plan tells is found."""

from __future__ import annotations

import copy
import json
from typing import Any

import pytest

from abi import load_scene, plan
from abi.export.joint_trajectory import motion_state
from abi.verify.unchecked import unchecked
from abi.verify.verify import verify


@pytest.fixture(scope="module")
def told() -> dict[str, Any]:
    found = plan(load_scene("paper"))
    data: dict[str, Any] = json.loads(json.dumps(found.to_dict()))
    data["arm"]["state"] = motion_state(found)  # as in an exported plan
    return data


def test_what_is_named_changes_no_verdict(told: dict[str, Any]) -> None:
    verdicts, changed = verify(told), copy.deepcopy(told)
    assert all(one.proven for one in verdicts)
    names = unchecked(told)
    assert {"searches", "optimum", "arm.clearances", "bspline.length"} <= set(names)
    assert {"arm.within_limits", "arm.state"} <= set(names)
    changed["arm"] |= {"within_limits": False, "limits_passed": ["anything"]}
    for name in set(names) - {"arm.within_limits"}:
        section, _, field = name.partition(".")
        inner = changed[section] if field else changed
        inner[field or section] = "anything"
    assert verify(changed) == verdicts
    assert unchecked([told]) == ()
    # without a force on the slide nothing depends on the phases
    for force, unread in ((0.0, ("timing.t1",)), (1.0, ())):
        timed = {"scene": {"arm": {"forces": [0.0, force, 0.0]}}, "timing": {"t1": 1.0}}
        assert unchecked(timed) == unread
    assert unchecked({"legs": [told, told]}) == names


@pytest.mark.parametrize("name", ["tool", "peak_joint_speed", "within_limits", "allowed", "axis"])
def test_what_else_the_motion_tells_is_checked(told: dict[str, Any], name: str) -> None:
    changed = copy.deepcopy(told)
    arm = changed["arm"]
    if name == "tool":
        arm["tool"][7][0] += 1e-3
    elif name == "peak_joint_speed":
        arm[name] = [0.5 * one for one in arm[name]]
    else:
        arm[name] = {"allowed": [0], "axis": {}}.get(name, not arm[name])
    assert not verify(changed)[-1].proven
