"""Repair of motions: the new motion is proven, and differs only where the old one was not."""

from __future__ import annotations

import re

import numpy as np
import pytest

from abi.certification.certify_motion import certify_motion
from abi.certification.checked_plan import checked_plan
from abi.certification.motion import Motion
from abi.certification.read_motion import joint_names
from abi.certification.repair import repair
from abi.certification.robot_scene import robot_scene
from abi.errors import AbiError
from abi.scene.scene import Scene

pytestmark = pytest.mark.slow
ALONE = robot_scene("ur5e")
COUNT = 13


def swing(degree: int) -> Motion:
    """A swing of the shoulder over waypoints, from rest to rest at each where there are speeds."""
    positions = np.tile([0.0, -1.6, 1.2, -1.2, -1.57, 0.0], (COUNT, 1))
    positions[:, 0] = np.linspace(-1.5, 1.5, COUNT)
    still = np.zeros_like(positions)
    rates = still if degree > 1 else None, still if degree > 3 else None
    return Motion(joint_names(ALONE.arm.robot), np.linspace(0, 6, COUNT), positions, *rates)


def with_plate() -> Scene:
    """A thin plate in the way of the tool, halfway."""
    problem = certify_motion(swing(1), ALONE).problem
    chain, at = problem.chain, np.array([(COUNT - 1) / 2 + 0.1])
    place = chain.poses(problem.motion.positions_at(at))[0, -1, :, 3].tolist()
    return ALONE.replace(
        obstacles=[{"shape": "box", "size": [0.15, 1e-4, 0.15], "position": place}]
    )


@pytest.mark.parametrize("degree", [1, 5])
def test_a_repaired_motion_is_proven_and_as_before_elsewhere(degree: int) -> None:
    before = certify_motion(swing(degree), with_plate())
    assert before.state == "touches"
    shown = checked_plan(before)
    assert shown.motion is not None
    assert shown.arm_clearance is not None
    assert {one.link for one in shown.arm_clearance.contacts} == {o.link for o in before.touches}

    found, words = repair(before)
    assert found.state == "clear"
    assert checked_plan(found).is_arm_clear
    old, new = swing(degree), found.problem.motion.motion
    told = re.fullmatch(r"Repaired from (\S+) s to (\S+) s: (\S+) s, \+(\d+) % of way .*", words)
    assert told is not None
    first, last, longer, farther = map(float, told.groups())
    assert first < before.touches[0].first < last
    assert np.ptp(new.times) == pytest.approx(np.ptp(old.times) + longer, abs=0.006)
    assert farther > 0
    head, tail = old.times <= first, old.times >= last
    np.testing.assert_array_equal(new.positions[: head.sum()], old.positions[head])
    np.testing.assert_array_equal(new.positions[-tail.sum() :], old.positions[tail])
    np.testing.assert_allclose(np.diff(new.times)[: head.sum() - 1], 0.5)
    if degree > 1:
        assert new.velocities is not None
        assert not found.limits.passed


def test_what_begins_where_it_touches_is_not_repaired() -> None:
    late = swing(1)
    half = Motion(late.joints, late.times[: COUNT // 2 + 1], late.positions[: COUNT // 2 + 1])
    scene = with_plate()
    x, y, z = scene.obstacles[0].position
    wall = {"shape": "box", "size": [0.3, 0.3, 0.3], "position": [x, y, z]}
    verdict = certify_motion(half, scene.replace(obstacles=[wall]))
    assert verdict.state == "touches"
    with pytest.raises(AbiError, match="ends where it is not proven clear"):
        repair(verdict)
