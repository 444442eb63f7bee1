"""Limits of speed and acceleration that a motion passes have to be told."""

from __future__ import annotations

import copy
import json
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.planner.planner import Planner
from abi.verify.exact.robot_chain import exact_chain
from abi.verify.fault import Fault
from abi.verify.joint_rates import check_rates
from tests.abi.verify.verdicts import NEAR, verdict_on
from tests.thorough import examples

ASKED = NEAR.motion.joint_acceleration
CHAIN = exact_chain(NEAR.robot, NEAR.arm.tool, (0, 0, 0), 1, (1, 0, 0, 0), {})
(SPEED,) = {one.speed for one in NEAR.robot.joints if one.name in CHAIN.coordinates}


def told(rows: Any, duration: float) -> dict[str, Any]:
    """What a plan tells of samples."""
    step = duration / (len(rows) - 1)
    speeds = np.abs(np.diff(rows, axis=0)).max(axis=0) / step
    ways = np.abs(np.diff(rows, axis=0))[[0, -1]].max(axis=0)
    growths = np.maximum(np.abs(np.diff(rows, 2, axis=0)).max(axis=0), ways) / step**2
    passed = {
        (name, quantity): value
        for quantity, values, limit in (("speed", speeds, SPEED), ("acceleration", growths, ASKED))
        for name, value in zip(CHAIN.coordinates, values, strict=True)
        if value > 1.001 * limit
    }
    return {
        "peak_joint_speed": speeds.tolist(),
        "peak_joint_acceleration": growths.tolist(),
        "joint_speed_limits": [SPEED] * 6,
        "joint_acceleration_limits": [ASKED] * 6,
        "limits_passed": [
            {"joint": joint, "quantity": quantity, "value": value}
            for (joint, quantity), value in passed.items()
        ],
    }


@settings(max_examples=examples(20))
@given(seed=st.integers(0, 10**6), duration=st.floats(0.05, 20.0))
def test_what_passes_a_limit_has_to_be_told(seed: int, duration: float) -> None:
    random = np.random.default_rng(seed)
    rows = np.cumsum(np.cumsum(random.normal(size=(random.integers(3, 9), 6)), axis=0), axis=0)
    exact = [[Fraction(one) for one in row] for row in rows.tolist()]
    section = told(rows, duration)
    check_rates(section, duration, exact, CHAIN, NEAR)
    faster = [2 * one for one in section["peak_joint_speed"]]
    with pytest.raises(Fault, match="nowhere as large"):
        check_rates(section | {"peak_joint_speed": faster}, duration, exact, CHAIN, NEAR)
    for name in ("peak_joint_acceleration", "joint_speed_limits", "joint_acceleration_limits"):
        with pytest.raises(Fault, match="not one number each"):
            check_rates(section | {name: [*section[name], 1.0]}, duration, exact, CHAIN, NEAR)
    for one in section["limits_passed"]:
        others = [other for other in section["limits_passed"] if other != one]
        for entries in (others, [*others, one | {"value": 0.99 * one["value"]}]):
            with pytest.raises(
                Fault, match=f"{one['joint']} passes its limit of {one['quantity']}"
            ):
                check_rates(section | {"limits_passed": entries}, duration, exact, CHAIN, NEAR)


def test_a_motion_that_does_not_begin_or_end_at_rest_is_refused() -> None:
    way = np.linspace(0.0, 0.5, 50)
    for shares in (way, 0.5 - way, np.abs(way - 0.2)):
        rows = np.outer(shares, np.ones(6))
        section = told(rows, 1.0)
        section["peak_joint_acceleration"] = [ASKED] * 6
        section["limits_passed"] = []
        exact = [[Fraction(one) for one in row] for row in rows.tolist()]
        with pytest.raises(Fault, match="is larger than its stated peak"):
            check_rates(section, 1.0, exact, CHAIN, NEAR)


def test_a_plan_in_half_its_time_is_refused() -> None:
    plan = Planner()(NEAR.replace(motion={"law": "time_optimal"}))
    data: dict[str, Any] = json.loads(json.dumps(plan.to_dict()))
    assert data["arm"]["within_limits"]
    # three samples show no second difference of a motion that speeds up before the second
    few = {"law": "three_phase", "samples": 3, "acceleration": 40.0, "deceleration": 40.0}
    coarse = json.loads(json.dumps(Planner()(NEAR.replace(motion=few)).to_dict()))
    assert (found := verdict_on("arm", coarse)).proven, found.reason
    other = copy.deepcopy(data)
    other["arm"]["joint_acceleration_limits"] = [100 * ASKED] * 6
    assert "joint_acceleration_limits are not those" in verdict_on("arm", other).reason
    arm = data["arm"]
    data["timing"]["duration"] /= 2
    arm["time"] = [time / 2 for time in arm["time"]]
    assert not verdict_on("arm", data).proven
    arm["peak_joint_speed"] = [2 * one for one in arm["peak_joint_speed"]]
    assert "larger than its stated peak" in verdict_on("arm", data).reason
    arm["peak_joint_acceleration"] = [4 * one for one in arm["peak_joint_acceleration"]]
    assert "passes its limit of acceleration farther than is told" in verdict_on("arm", data).reason
