from __future__ import annotations

import re

import numpy as np
import pytest

from abi.errors import (
    ClearanceNotHeld,
    NoPath,
    NotFollowed,
    OutOfReach,
    PointBlocked,
    StageError,
)

ERRORS = [
    PointBlocked("start", 0, -0.08453, 0.2, np.array([1.23456, 2.0, 3.0])),
    PointBlocked("goal", 1, 0.08453, 0.2, None),
    NoPath(np.arange(3, dtype=np.int32), 1234, 1.299),
    ClearanceNotHeld(0.2, -0.08453),
    ClearanceNotHeld(0.2, 0.1234567),
    OutOfReach(0.5, 1.25, 0.7654321, True),
    OutOfReach(0.5, 1.25, 0.7654321, False, (12.3456, 2.4)),
    NotFollowed(0.5, 1.25, 0.7654321),
]


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
def test_every_length_has_a_unit_and_three_digits(error: StageError) -> None:
    error = error.in_unit("mm")
    text = f"{error.message} {error.hint}"

    # points have one unit behind the bracket
    points = re.findall(r"\([-\d., ]+\)( mm)?", text)
    assert all(points)
    numbers = re.findall(r"(\d+\.\d+)( mm| s)?", re.sub(r"\([-\d., ]+\)", "", text))
    assert all(unit for _, unit in numbers), text
    assert all(len(number.strip("0.").replace(".", "")) <= 3 for number, _ in numbers), text
