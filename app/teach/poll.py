"""A question to a class with the answers of its rounds, and the record of all questions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import msgspec

from abi.obstacles.pose import Vec3

MAX_CHOICES = 4
ROUNDS = 2
_MAX_TEXT = 300
"""Most characters of a question or an answer."""
_SAME_PLACE = 1e-6
"""Distance within which a place counts as a right one, [unit]."""

Answer = int | Vec3
"""Number of a choice, or a place in the scene, [unit], world."""


@dataclass(frozen=True)
class Poll:
    """A question to all, and the answers of its rounds.

    Attributes:
        number: from 1 on, another for each question.
        text: the question.
        choices: answers to choose from, 2 to ``MAX_CHOICES``; empty where a place is asked for.
        right: number of the right choice; -1 where none is known.
        why: why it is right, as plain text.
        places: the right places, [unit], world; empty where none is known.
        lesson: lesson and page that were open; empty for none.
        asked_at: time at which it was asked, as ISO 8601 text; empty where none was noted.
        rounds: of each, the answers by student.
        revealed: whether the answers are shown.
    """

    number: int
    text: str
    choices: tuple[str, ...] = ()
    right: int = -1
    why: str = ""
    places: tuple[Vec3, ...] = ()
    lesson: str = ""
    asked_at: str = ""
    rounds: tuple[Mapping[str, Answer], ...] = field(default_factory=lambda: ({},))
    revealed: bool = False

    @property
    def asks_place(self) -> bool:
        """Whether the answer is a place in the scene."""
        return not self.choices

    @property
    def has_right(self) -> bool:
        """Whether the right answer is known."""
        return self.right >= 0 or bool(self.places)

    def takes(self, answer: Answer) -> bool:
        """Check whether an answer fits this question."""
        if self.asks_place:
            return not isinstance(answer, int) and all(map(math.isfinite, answer))
        return isinstance(answer, int) and 0 <= answer < len(self.choices)

    def is_right(self, answer: Answer) -> bool:
        """Check whether an answer is right; False if the right one is not known."""
        if isinstance(answer, int):
            return answer == self.right
        return any(math.dist(answer, place) < _SAME_PLACE for place in self.places)

    @property
    def answers(self) -> Mapping[str, Answer]:
        """The answers of the present round."""
        return self.rounds[-1]

    def counts(self, number: int = -1) -> tuple[int, ...]:
        """Number of students for each choice in a round, by default the present one."""
        given = list(self.rounds[number].values())
        return tuple(given.count(choice) for choice in range(len(self.choices)))

    def right_share(self, number: int = -1) -> float | None:
        """Fraction of right answers in a round; None if unknown or without answers."""
        given = self.rounds[number].values()
        if not self.has_right or not given:
            return None
        return sum(map(self.is_right, given)) / len(given)

    @property
    def gain(self) -> float | None:
        """Normalised gain from the first to the second round (Hake, 1998)."""
        if len(self.rounds) < ROUNDS:
            return None
        first, second = self.right_share(0), self.right_share(1)
        if first is None or second is None or first == 1:
            return None
        return (second - first) / (1 - first)


def poll_of(
    number: int, text: str, choices: tuple[str, ...], right: int = -1, why: str = ""
) -> Poll | None:
    """The question with its non-empty answers; None with fewer than two."""
    said = [k for k, choice in enumerate(choices) if choice.strip()][:MAX_CHOICES]
    if not text.strip() or len(said) < 2:
        return None
    kept = tuple(choices[k][:_MAX_TEXT] for k in said)
    return Poll(number, text[:_MAX_TEXT], kept, said.index(right) if right in said else -1, why)


class Record(msgspec.Struct):
    """All questions and answers of a class, and the teacher's settings.

    Attributes:
        asked: the questions with their answers, the last one last.
        closed: whether the last question is asked no more.
        words: that students have chosen for the results.
        lead: whether all follow the teacher.
        draft: question and answers that the teacher is writing.
    """

    asked: list[Poll] = []
    closed: bool = False
    words: dict[str, str] = {}
    lead: bool = False
    draft: list[str] = []
