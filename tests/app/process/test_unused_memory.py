"""Memory is given back once for all that asked, and not while tabs wait for their turn."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from app.process import unused_memory
from tests.app.fake_tab import until


def test_memory_is_given_back_once_and_when_no_tab_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    turns, begun, collected = SimpleNamespace(waiting=2), list[None](), list[None]()
    begin = unused_memory._begin

    def noted() -> None:
        begun.append(None)
        begin()

    monkeypatch.setattr(unused_memory, "DELAY", 0.01)
    monkeypatch.setattr(unused_memory, "TURNS", turns)
    monkeypatch.setattr(unused_memory, "_pending", False)
    monkeypatch.setattr(unused_memory, "_begin", noted)
    monkeypatch.setattr(
        unused_memory, "gc", SimpleNamespace(collect=lambda: collected.append(None))
    )
    unused_memory.give_back_soon()
    unused_memory.give_back_soon()
    until(lambda: len(begun) > 3)
    assert collected == []
    turns.waiting = 0
    until(lambda: not unused_memory._pending)
    until(lambda: collected == [None])
