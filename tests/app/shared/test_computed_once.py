"""What all tabs share is computed once, however many ask for it at the same time."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from app.shared.computed_once import computed_once

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
