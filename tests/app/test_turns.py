"""Turns come in order, one at a time, and a long one holds nobody up."""

from __future__ import annotations

import threading

from app.turns import Turns
from tests.app.fake_tab import until


def test_turns_come_one_at_a_time_in_the_order_of_asking() -> None:
    turns = Turns(longest=60.0)
    order: list[int] = []
    inside: list[int] = []

    def take(number: int) -> None:
        with turns:
            inside.append(number)
            assert inside == [number]
            order.append(number)
            inside.remove(number)

    threads = [threading.Thread(target=take, args=(number,)) for number in range(8)]
    with turns:
        for count, thread in enumerate(threads, 1):
            thread.start()
            until(lambda count=count: turns.waiting == count)  # type: ignore[misc]
        assert order == []
    for thread in threads:
        thread.join()
    assert order == list(range(8))
    assert turns.waiting == 0


def test_as_many_take_turns_as_there_are() -> None:
    turns = Turns(count=2, longest=60.0)
    both = threading.Barrier(2, timeout=30.0)

    def take() -> None:
        with turns:
            both.wait()

    threads = [threading.Thread(target=take) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not both.broken


def test_a_long_turn_goes_on_beside_the_next() -> None:
    turns = Turns(longest=0.01)
    done = threading.Event()

    def take() -> None:
        with turns:
            done.set()

    with turns:
        thread = threading.Thread(target=take)
        thread.start()
        assert done.wait(30.0)
        thread.join()
    with turns:
        assert turns.waiting == 0


def test_a_fault_ends_its_turn() -> None:
    turns = Turns(longest=60.0)
    for _ in range(2):
        try:
            with turns:
                raise ValueError
        except ValueError:
            assert turns.waiting == 0
