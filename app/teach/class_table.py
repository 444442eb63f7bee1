"""Results of a class as a table: one row for each answer."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence

from app.teach.poll import Answer, Poll

_HEAD = ("question", "asked at", "lesson", "text", "round", "student", "answer", "right")
_FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""First characters that make a spreadsheet take a text for a formula."""


def table(asked: Sequence[Poll], words: Mapping[str, str]) -> str:
    """The answers as CSV; a student is a self-chosen word, or a number.

    Args:
        asked: the questions in their order.
        words: by student.
    """
    students = {
        student: number
        for number, student in enumerate(
            dict.fromkeys(key for one in asked for answers in one.rounds for key in answers), 1
        )
    }
    target = io.StringIO()
    writer = csv.writer(target, lineterminator="\n")
    writer.writerow(_HEAD)
    for one in asked:
        for number, answers in enumerate(one.rounds, 1):
            for student, answer in answers.items():
                name = words.get(student) or f"student {students[student]}"
                right = {True: "yes", False: "no"}[one.is_right(answer)]
                writer.writerow(
                    (
                        one.number,
                        one.asked_at,
                        _harmless(one.lesson),
                        _harmless(one.text),
                        number,
                        _harmless(name),
                        _harmless(_told(one, answer)),
                        right if one.has_right else "",
                    )
                )
    return target.getvalue()


def _told(poll: Poll, answer: Answer) -> str:
    if isinstance(answer, int):
        return poll.choices[answer]
    return f"({', '.join(f'{x:.4g}' for x in answer)})"


def _harmless(text: str) -> str:
    """Escape a student's text so that no spreadsheet takes it for a formula."""
    return f"'{text}" if text.startswith(_FORMULA) else text
