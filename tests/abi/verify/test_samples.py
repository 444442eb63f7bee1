"""Samples of a motion say which joints their numbers are of, and when each is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from abi.verify.certificate import Fault
from abi.verify.samples import check_samples

JOINTS = ("shoulder", "elbow")
TIMING = {"duration": 2.0}


def samples() -> dict[str, Any]:
    return {
        "joints": [*JOINTS],
        "time": np.linspace(0, 2, 6).tolist(),
        "positions": [[0.1 * k, -0.2 * k] for k in range(6)],
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


def drop_all(section: dict[str, Any]) -> None:
    section |= {"time": [], "positions": []}


def test_samples_of_the_motion_are_accepted() -> None:
    check_samples(samples(), TIMING, JOINTS)


@pytest.mark.parametrize(
    "damage",
    [
        *(exchange_names, forget_a_name, drop_a_row, drop_a_sample),
        *(run_backwards, hurry, drop_all),
    ],
)
def test_samples_of_another_motion_are_refused(damage: Callable[[dict[str, Any]], None]) -> None:
    section = samples()
    damage(section)
    with pytest.raises(Fault):
        check_samples(section, TIMING, JOINTS)
