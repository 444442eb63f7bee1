"""Numbers and points in the sentences of exercises, and checks of answers."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import Any

from abi.length_text import with_minus


def text(value: float) -> str:
    """Format a number with four digits."""
    return with_minus(f"{value + 0.0:.4g}")


def point(place: Iterable[float]) -> str:
    """Format a point in parentheses."""
    return f"({', '.join(map(text, place))})"


def shown(value: Any) -> str:
    """Format an answer, shortened for a sentence."""
    if isinstance(value, float):
        return text(value)
    if isinstance(value, list) and value and all(is_number(part) for part in value):
        return point(value)
    written = repr(value)
    return written if len(written) <= 80 else f"{written[:77]}…"


def is_number(value: Any) -> bool:
    """Check whether an answer is a finite number; whole ones may be too large for that."""
    return type(value) in (int, float) and abs(value) <= sys.float_info.max


def are_numbers(value: Any, count: int) -> bool:
    """Check whether an answer is a list of that many finite numbers."""
    return isinstance(value, list) and len(value) == count and all(map(is_number, value))


def are_points(value: Any) -> bool:
    """Check whether an answer is a list of points (n, 3)."""
    return isinstance(value, list) and all(are_numbers(part, 3) for part in value)
