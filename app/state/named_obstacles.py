"""Obstacles that sentences on the page refer to by number."""

from __future__ import annotations

import re

from app.state.frame import Frame
from app.ui.labels import sentence
from app.ui.plan_notes import notes

_NAMED = re.compile(r"\bobstacles? (\d+(?:–\d+)?(?:(?:, | and )\d+(?! more|\d))*)")
_RANGE = re.compile(r"(\d+)(?:–(\d+))?")


def named_obstacles(frame: Frame) -> frozenset[int]:
    """Obstacles, from 0, that the frame's errors and notes refer to."""
    texts = list(notes(frame.plan).values())
    texts += [sentence(error) for error in (frame.plan.error, frame.refused) if error is not None]
    if frame.reason is not None:
        texts += [frame.reason.message, frame.reason.hint]
    return frozenset(number for text in texts for number in numbers_of(text))


def numbers_of(text: str) -> list[int]:
    """Obstacles, from 0, that a text refers to, singly or as a range."""
    ranges = [found for named in _NAMED.findall(text) for found in _RANGE.findall(named)]
    return [k for first, last in ranges for k in range(int(first) - 1, int(last or first))]
