"""A small attack; ``make attack`` is the whole one."""

from __future__ import annotations

import random

import pytest

from app.guard.messages import decode
from benchmarks.attack import attack, malformed


def test_what_the_attack_sends_is_refused() -> None:
    chance = random.Random(1)
    assert not any(decode(malformed(chance)) for _ in range(2000))


@pytest.mark.slow
def test_another_tab_works_on_under_attack() -> None:
    result = attack(messages=600)
    assert result["messages"] == 600
    assert result["updates"] > 0
    assert result["faults"] == 0
