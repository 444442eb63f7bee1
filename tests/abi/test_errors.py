from __future__ import annotations

import copy
import pickle
import re
from collections.abc import Callable
from multiprocessing import get_context

import numpy as np
import pytest

from abi import Scene
from abi.arm_planning.arm_errors import ArmNotClear, out_of_reach
from abi.errors import (
    AbiError,
    SceneError,
    StageError,
    clearance_not_held,
    no_path,
    point_blocked,
)

ERRORS = [
    point_blocked("start", 0, -0.08453, 0.2, np.array([1.23456, 2.0, 3.0])),
    point_blocked("goal", 1, 0.08453, 0.2, None),
    no_path(np.arange(3, dtype=np.int32), 1234, 1.299),
    clearance_not_held(0.2, -0.08453),
    clearance_not_held(0.2, 0.1234567),
    out_of_reach(0.5, 1.25, 0.7654321, True),
    out_of_reach(0.5, 1.25, 0.7654321, False, (12.3456, 2.4)),
    out_of_reach(0.5, 1.25, 0.7654321, None),
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


def same(error: AbiError) -> AbiError:
    """The error, sent through pickle."""
    sent: AbiError = pickle.loads(pickle.dumps(error))
    return sent


EVERY = [
    *ERRORS,
    ArmNotClear("With the elbow up", "start", "upper_arm", 0),
    SceneError("spline.degree", 9, "at most 5"),
    AbiError("There is no motion.", "Plan one."),
]


@pytest.mark.parametrize("error", EVERY, ids=lambda error: type(error).__name__)
@pytest.mark.parametrize("send", [same, copy.copy, copy.deepcopy])
def test_an_error_that_is_sent_or_copied_says_the_same(
    error: AbiError, send: Callable[[AbiError], AbiError]
) -> None:
    sent = send(error)

    assert type(sent) is type(error)
    assert (str(sent), sent.hint, sent.args) == (str(error), error.hint, error.args)
    assert vars(sent).keys() == vars(error).keys()
    if isinstance(error, StageError):
        assert isinstance(sent, StageError)
        assert sent.in_unit("mm").message == error.in_unit("mm").message


def read(data: dict[str, object]) -> Scene:
    """A scene, or its error, in another process."""
    return Scene.from_dict(data)


def test_an_error_of_another_process_arrives() -> None:
    """An error that cannot be read there makes a pool wait for ever."""
    with get_context("spawn").Pool(1) as pool, pytest.raises(SceneError, match=r"spline\.degree"):
        pool.map_async(read, [{"version": 1, "spline": {"degree": 9}}]).get(60)
