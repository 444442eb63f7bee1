"""Samples of a motion say which joints their numbers are of, and when each is."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from abi.verify.fault import Fault
from abi.verify.samples import check_samples, check_tool_points

JOINTS = ("shoulder", "elbow")
TIMING = {"duration": 2.0}


def samples() -> dict[str, Any]:
    return {
        "joints": [*JOINTS],
        "time": np.linspace(0, 2, 6).tolist(),
        "positions": [[0.1 * k, -0.2 * k] for k in range(6)],
        "tool": [[0.1 * k, -0.2 * k, 1.0] for k in range(6)],
        "peak_joint_speed": [0.25, 0.5],
        "limits_passed": [],
        "within_limits": True,
    }


def exchange_names(section: dict[str, Any]) -> None:
    section["joints"].reverse()


def forget_a_name(section: dict[str, Any]) -> None:
    del section["joints"][1]


def drop_a_row(section: dict[str, Any]) -> None:
    del section["positions"][3]


def drop_a_sample(section: dict[str, Any]) -> None:
    del section["positions"][3], section["time"][3]


def run_backwards(section: dict[str, Any]) -> None:
    section["time"].reverse()


def hurry(section: dict[str, Any]) -> None:
    section["time"] = [0.5 * time for time in section["time"]]


def deny_speed(section: dict[str, Any]) -> None:
    section["peak_joint_speed"][1] *= 0.99


def deny_limits(section: dict[str, Any]) -> None:
    section["limits_passed"] = [{"joint": "elbow"}]


def move_tool(section: dict[str, Any]) -> None:
    section["tool"][4][2] += 1e-6


def drop_tool(section: dict[str, Any]) -> None:
    del section["tool"][-1]


def drop_all(section: dict[str, Any]) -> None:
    section |= {"time": [], "positions": []}


def check(section: dict[str, Any]) -> None:
    """Check a motion whose joints slide the tool along x and y."""
    check_samples(section, TIMING, JOINTS)
    check_tool_points(section, lambda row: (row[0], row[1], Fraction(1)), Fraction(1, 10**8))


def test_samples_of_the_motion_are_accepted() -> None:
    check(samples())


@pytest.mark.parametrize(
    "damage",
    [
        *(exchange_names, forget_a_name, drop_a_row, drop_a_sample),
        *(run_backwards, hurry, drop_all),
        *(deny_speed, deny_limits, move_tool, drop_tool),
    ],
)
def test_samples_of_another_motion_are_refused(damage: Callable[[dict[str, Any]], None]) -> None:
    section = samples()
    damage(section)
    with pytest.raises(Fault):
        check(section)
