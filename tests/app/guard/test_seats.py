"""Tabs of all processes behind one address count together."""

from __future__ import annotations

from pathlib import Path

from app.guard.guard import Guard
from app.guard.policy import policy_for
from app.guard.seats import Seats


def test_a_process_counts_once_it_is_there_and_no_more_once_it_is_gone(tmp_path: Path) -> None:
    first = Seats(tmp_path, 0, count=2)
    second = Seats(tmp_path, 1)
    first.note(0)
    assert not first.are_all_there
    second.note(3)
    assert first.are_all_there
    assert (first.elsewhere, second.elsewhere) == (3, 0)
    first.vacate(1)
    assert first.elsewhere == 0
    assert not first.are_all_there


def test_a_server_is_full_by_the_tabs_of_all_its_processes(tmp_path: Path) -> None:
    first, second = Seats(tmp_path, 0, count=2), Seats(tmp_path, 1)
    guard = Guard(policy_for("127.0.0.1", max_tabs=4), first)
    second.note(3)
    assert not guard.is_full
    second.note(4)
    assert guard.is_full
    second.note(0)
    assert not guard.is_full
