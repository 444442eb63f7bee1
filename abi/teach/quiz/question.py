"""A question with several answers, one of which is right, and an explanation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from abi.scene.scene import Scene
from abi.teach.numbers import text

_CHOICES = 4
_APART = 0.02
"""Least relative difference of numbers to choose from."""
_OTHERS = (0.5, 2.0, 0.8, 1.25, 1.5)
"""Factors of the right number for wrong answers, if the usual errors give too few."""


@dataclass(frozen=True)
class QuizQuestion:
    """A question.

    Attributes:
        text: of the question.
        choices: answers to choose from, no two alike.
        right: number of the right one, from 0 on.
        why: why it is right, in one sentence.
        facts: what the question is about, as plain data by name.
        scene: where to look; None for a question that needs no scene.
    """

    text: str
    choices: tuple[str, ...]
    right: int
    why: str
    facts: Mapping[str, Any] = field(default_factory=dict)
    scene: Scene | None = None


def chosen(
    random: np.random.Generator,
    asked: str,
    right: str,
    wrong: Sequence[str],
    why: str,
    facts: Mapping[str, Any],
    scene: Scene | None = None,
) -> QuizQuestion:
    """The question with its answers shuffled, and at most three wrong ones."""
    others = [one for one in dict.fromkeys(wrong) if one != right][: _CHOICES - 1]
    assert others
    choices = [right, *others]
    order = random.permutation(len(choices)).tolist()
    mixed = tuple(choices[k] for k in order)
    return QuizQuestion(asked, mixed, mixed.index(right), why, facts, scene)


def fixed(
    asked: str,
    choices: tuple[str, ...],
    right: int,
    why: str,
    facts: Mapping[str, Any],
    scene: Scene | None = None,
) -> QuizQuestion:
    """The question with its answers in a given order, such as yes and no."""
    return QuizQuestion(asked, choices, right, why, facts, scene)


def of_number(
    random: np.random.Generator,
    asked: str,
    right: float,
    wrong: Sequence[float],
    why: str,
    facts: Mapping[str, Any],
    unit: str = "",
    scene: Scene | None = None,
) -> QuizQuestion:
    """The question for a number, with wrong answers from the usual errors, all well apart.

    Args:
        random: the order.
        asked: the question.
        right: the number.
        wrong: what errors give, the commonest first.
        why: why it is right.
        facts: what it is about.
        unit: of all numbers.
        scene: where to look.
    """
    apart: list[float] = [right]
    for other in (*wrong, *(right * factor for factor in _OTHERS), right + 1.0, right + 2.0):
        if np.isfinite(other) and other >= 0 and all(_differ(other, one) for one in apart):
            apart.append(float(other))
    words = [f"{text(one)} {unit}".rstrip() for one in apart]
    return chosen(random, asked, words[0], words[1:], why, facts, scene)


def of_count(
    random: np.random.Generator,
    asked: str,
    right: int,
    wrong: Sequence[int],
    why: str,
    facts: Mapping[str, Any],
) -> QuizQuestion:
    """The question for a count, with other counts near it."""
    near = (right + 1, right - 1, right + 2, right - 2, right + 3)
    words = [str(one) for one in (*wrong, *near) if one >= 0]
    return chosen(random, asked, str(right), words, why, facts)


def _differ(a: float, b: float) -> bool:
    return abs(a - b) > _APART * max(abs(a), abs(b)) and text(a) != text(b)
