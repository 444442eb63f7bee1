"""Segments and boxes along the axes, in any exact or inexact numbers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

Box = Sequence[Sequence[Any]]
"""Two opposite corners, the lower one first."""


def segment_meets(a: Sequence[Any], b: Sequence[Any], box: Box) -> bool:
    """Check whether a segment meets a box; touching it is meeting it.

    The parameters of the points between each pair of faces are an interval; the segment meets the
    box where these have a point of [0, 1] in common (Liang and Barsky, 1984). With fractions the
    answer is exact.
    """
    first, last = 0, 1
    for start, end, low, high in zip(a, b, *box, strict=True):
        step = end - start
        if step == 0:
            if not low <= start <= high:
                return False
            continue
        enter, leave = sorted(((low - start) / step, (high - start) / step))
        first, last = max(first, enter), min(last, leave)
    return first <= last


def segment_meets_any(a: Sequence[Any], b: Sequence[Any], boxes: Iterable[Box]) -> bool:
    """Check whether a segment meets one of the boxes."""
    return any(segment_meets(a, b, box) for box in boxes)
