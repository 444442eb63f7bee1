from __future__ import annotations

import numpy as np
import pytest

from abi.arrays import read_only
from abi.errors import StageError
from abi.planner.remembered_call import RememberedCall
from abi.search.search_kernels import reconstruct_path
from tests.kernel_forms import kernels_as


class Clock:
    """Takes the place of the clock: it goes on only by what a call is said to take, [s]."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


class Work:
    """Takes 3 ms, then 5, then 7; counts its calls, and raises what it is given."""

    def __init__(self, clock: Clock) -> None:
        self.calls = 0
        self.clock = clock

    def __call__(self, value: object) -> list[object]:
        self.calls += 1
        self.clock.now += (1 + 2 * self.calls) / 1e3
        if isinstance(value, Exception):
            raise value
        return [value]


@pytest.fixture
def work() -> Work:
    return Work(Clock())


def test_equal_arguments_give_back_the_same_object_and_its_time(work: Work) -> None:
    stage = RememberedCall(work, work.clock)
    first = stage((1.0, "a"))
    assert stage((1.0, "a")) is first
    assert work.calls == 1
    assert stage.ms == pytest.approx(3)
    assert stage((2.0, "a")) is not first
    assert work.calls == 2
    assert stage.ms == pytest.approx(5)
    # a memory of one
    assert stage((1.0, "a")) is not first


def test_a_remembered_error_does_not_gather_frames(work: Work) -> None:
    stage, error = RememberedCall(work, work.clock), StageError("mesh", "none", "None.", "")
    depths = []
    for _ in range(3):
        with pytest.raises(StageError) as caught:
            stage(error)
        depths.append(len(caught.traceback))
    assert depths[0] >= depths[1] == depths[2]


def test_arrays_are_the_same_only_as_objects(work: Work) -> None:
    stage, array = RememberedCall(work), np.zeros(3)
    first = stage(array)
    assert stage(array) is first
    assert stage(array.copy()) is not first


def test_an_error_of_the_stage_is_remembered_and_any_other_is_not(work: Work) -> None:
    stage = RememberedCall(work)
    known = StageError("mesh", "kind", "It is so.", "Do this.")
    for _ in range(2):
        with pytest.raises(StageError) as raised:
            stage(known)
        assert raised.value is known
    assert work.calls == 1
    broken = MemoryError()
    for _ in range(2):
        with pytest.raises(MemoryError):
            stage(broken)
    assert work.calls == 3


def test_named_arguments_count_as_well() -> None:
    stage = RememberedCall(lambda a, b=0: (a, b))
    assert stage(1, b=0) == (1, 0)
    assert stage(1, b=5) == (1, 5)
    assert stage(1, b=5) is stage(1, b=5)


def test_a_stage_tells_whether_its_inner_loops_ran_as_python() -> None:
    stage = RememberedCall(reconstruct_path)
    with kernels_as(compiled=False):
        stage(np.array([-1, 0], np.int32), 1)
        assert stage.interpreted
    with kernels_as(compiled=True):
        stage(read_only(np.array([-1, 0], np.int32)), 0)
        assert not stage.interpreted
