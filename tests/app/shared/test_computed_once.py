"""What all tabs share is computed once, however many ask for it at the same time."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from abi.planner.plan import Plan
from abi.scene.scene import Scene
from app.shared.computed_once import computed_once, once_a_plan

_ASKING = 8


def test_those_who_ask_together_wait_for_one() -> None:
    computed: list[int] = []
    together = threading.Barrier(_ASKING)

    @computed_once(2)
    def slow(number: int) -> list[int]:
        """Double it."""
        computed.append(number)
        threading.Event().wait(0.05)  # others ask meanwhile
        return [2 * number]

    def ask(_: int) -> list[int]:
        together.wait()
        return slow(3)

    with ThreadPoolExecutor(_ASKING) as pool:
        found = list(pool.map(ask, range(_ASKING)))
    assert computed == [3]
    assert all(one is found[0] for one in found)
    assert found[0] == [6]
    assert slow.__doc__ == "Double it."


def test_the_latest_results_are_kept_by_what_they_depend_on() -> None:
    computed: list[int] = []

    @computed_once(2, by=abs)
    def made(number: int) -> int:
        computed.append(number)
        return number

    assert [made(number) for number in (1, -1, 2, 1, 3, -1, 2)] == [1, 1, 2, 1, 3, 1, 2]
    assert computed == [1, 2, 3, 2]


def test_what_is_made_of_a_plan_is_made_by_the_first_of_those_who_ask_together() -> None:
    computed: list[tuple[Plan, int]] = []
    together = threading.Barrier(_ASKING)
    plans = [Plan(Scene.from_dict({"version": 1})) for _ in range(2)]

    @once_a_plan
    def slow(plan: Plan, number: int) -> list[int]:
        computed.append((plan, number))
        threading.Event().wait(0.05)  # others ask meanwhile
        if plan is plans[0] and computed.count((plan, number)) == 1:
            raise MemoryError  # which is nobody else's
        return [number]

    def ask(index: int) -> list[int]:
        together.wait()
        try:
            return slow(plans[index % 2], 3)
        except MemoryError:
            return []

    with ThreadPoolExecutor(_ASKING) as pool:
        found = list(pool.map(ask, range(_ASKING)))
    assert found.count([]) == 1
    assert found.count([3]) == _ASKING - 1
    assert len(computed) == 3


def test_a_fault_is_nobody_s_value_and_old_ones_are_dropped() -> None:
    computed: list[int] = []

    @computed_once(2)
    def picky(number: int) -> int:
        computed.append(number)
        if computed == [0]:
            raise MemoryError
        return number

    with pytest.raises(MemoryError):
        picky(0)
    for number in (0, 0, 1, 2, 0):
        assert picky(number) == number
    assert computed == [0, 0, 1, 2, 0]
