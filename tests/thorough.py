"""Whether tests try all that they can, as once a night, or what finds nearly all of it."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import TypeVar

T = TypeVar("T")

THOROUGH = os.environ.get("ABI_THOROUGH") == "1"
"""What ``make thorough`` sets: properties try ten times as many examples, laws all cases."""
EXAMPLES = 1000 if THOROUGH else 40
"""Examples of a property that asks for no number of its own."""


def examples(usual: int) -> int:
    """Examples of a property of which each takes long: so many, and ten times as many at night."""
    return 10 * usual if THOROUGH else usual


def of_each_kind(every: Iterable[T], *kinds: T) -> list[T]:
    """The cases that stand for their kinds; at night every case."""
    cases = list(every)
    assert all(one in cases for one in kinds)
    return cases if THOROUGH else list(kinds)
