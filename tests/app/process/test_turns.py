"""Turns come in order, one at a time; who is in a hurry goes first, and nobody waits for ever."""

from __future__ import annotations

import threading

import pytest

from app.process.turns import AT_ONCE, PATIENT, Turns
from tests.app.fake_tab import until


def test_turns_come_one_at_a_time_in_the_order_of_asking() -> None:
    turns = Turns(longest=60.0)
    order: list[int] = []
    inside: list[int] = []

    def take(number: int) -> None:
        with turns.turn(number):
            inside.append(number)
            assert inside == [number]
            order.append(number)
            inside.remove(number)

    threads = [threading.Thread(target=take, args=(number,)) for number in range(8)]
    with turns.turn("long"):
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

    def take(number: int) -> None:
        with turns.turn(number):
            both.wait()

    threads = [threading.Thread(target=take, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not both.broken


def test_a_long_turn_goes_on_beside_the_next() -> None:
    turns = Turns(longest=0.01)
    done = threading.Event()

    def take() -> None:
        with turns.turn("other"):
            done.set()

    with turns.turn("long"):
        thread = threading.Thread(target=take)
        thread.start()
        assert done.wait(30.0)
        thread.join()
    with turns.turn("long"):
        assert turns.waiting == 0


def test_a_fault_ends_its_turn() -> None:
    turns = Turns(longest=60.0)
    for _ in range(2):
        try:
            with turns.turn("long"):
                raise ValueError
        except ValueError:
            assert turns.waiting == 0


def _order(turns: Turns, asking: list[tuple[str, float]], hurried: str = "") -> list[str]:
    """Names of threads in the order of their turns; each can wait for so long, [s]."""
    order: list[str] = []

    def take(name: str, patience: float) -> None:
        with turns.turn(name, patience):
            order.append(name)

    threads = [threading.Thread(target=take, args=one) for one in asking]
    with turns.turn("long"):
        for count, thread in enumerate(threads, 1):
            thread.start()
            until(lambda count=count: turns.waiting == count)  # type: ignore[misc]
        if hurried:
            turns.hasten(hurried)
    for thread in threads:
        thread.join()
    return order


def test_a_hand_is_served_before_those_who_follow_it() -> None:
    asking = [("student", PATIENT), ("another", PATIENT), ("teacher", AT_ONCE)]
    assert _order(Turns(longest=60.0), asking) == ["teacher", "student", "another"]


def test_patience_ends() -> None:
    asking = [("patient", 0.0), ("hand", 0.0), ("very patient", 60.0), ("late hand", 0.0)]
    assert _order(Turns(longest=60.0), asking) == ["patient", "hand", "late hand", "very patient"]


def test_one_that_is_hastened_while_it_waits_goes_before_the_patient() -> None:
    asking = [("student", PATIENT), ("dragged", PATIENT), ("hand", AT_ONCE)]
    assert _order(Turns(longest=60.0), asking, "dragged") == ["hand", "dragged", "student"]


def test_of_all_a_hands_moves_one_hastens_a_turn(monkeypatch: pytest.MonkeyPatch) -> None:
    turns = Turns(longest=60.0)
    called: list[None] = []
    monkeypatch.setattr(turns, "_call", lambda: called.append(None))
    for _ in range(2):
        for _ in range(20):
            turns.hasten("dragged")
        with turns.turn("dragged", 60.0):
            pass
    assert len(called) == 2 * 2  # at the begin and the end of each turn


def test_haste_before_a_turn_is_asked_for_counts_for_that_one_only() -> None:
    asking = [("tab", PATIENT), ("hand", AT_ONCE)]
    turns = Turns(longest=60.0)
    turns.hasten("tab")
    assert _order(turns, asking) == ["tab", "hand"]
    assert _order(turns, asking) == ["hand", "tab"]
