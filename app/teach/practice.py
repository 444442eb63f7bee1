"""Practice: one question after the other; five right answers in a row are mastery of a subject."""

from __future__ import annotations

import secrets
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import msgspec

from abi.teach.quiz.question import QuizQuestion
from abi.teach.quiz.templates import question, templates

MASTERY = 5
"""Right answers in a row for mastery."""
_SEEDS = 2**31


@dataclass(frozen=True)
class Practice:
    """Progress of a student.

    Attributes:
        chosen: names of the templates to be asked of; empty while nothing is practised.
        quiz: whether a teacher has chosen them.
        template: of the question that is asked.
        seed: of that question.
        answer: number of the choice that was taken; -1 before.
        streaks: right answers in a row, by template.
        mastered: names of the templates with :data:`MASTERY` of them.
        asked: number of questions answered.
        right: of these, the right ones.
    """

    chosen: tuple[str, ...] = ()
    quiz: bool = False
    template: str = ""
    seed: int = 0
    answer: int = -1
    streaks: dict[str, int] = field(default_factory=dict)
    mastered: frozenset[str] = frozenset()
    asked: int = 0
    right: int = 0

    @property
    def question(self) -> QuizQuestion | None:
        """The present question; None while nothing is practised."""
        return question(self.template, self.seed) if self.template else None

    def begun(self, chosen: Iterable[str], quiz: bool = False) -> Practice:
        """Start with other templates and a first question; without any, end."""
        known = tuple(name for name in templates() if name in set(chosen))
        if not known:
            return replace(self, chosen=(), quiz=False, template="", answer=-1)
        return replace(self, chosen=known, quiz=quiz, template="").next()

    def next(self) -> Practice:
        """The next question, from the least practised template that is not mastered."""
        if not self.chosen:
            return self
        left = [name for name in self.chosen if name not in self.mastered] or list(self.chosen)
        others = [name for name in left if name != self.template] or left
        # each until it is mastered would be dull, and all in turn is predictable
        name = self.template if self.answer >= 0 and self._failed else secrets.choice(others)
        return replace(self, template=name, seed=secrets.randbelow(_SEEDS), answer=-1)

    def answered(self, number: int) -> Practice:
        """The progress after an answer; a second one to the same question does not count."""
        asked = self.question
        if asked is None or self.answer >= 0 or not 0 <= number < len(asked.choices):
            return self
        right = number == asked.right
        streak = self.streaks.get(self.template, 0) + 1 if right else 0
        mastered = self.mastered | ({self.template} if streak >= MASTERY else set())
        return replace(
            self,
            answer=number,
            streaks={**self.streaks, self.template: streak},
            mastered=mastered,
            asked=self.asked + 1,
            right=self.right + right,
        )

    @property
    def _failed(self) -> bool:
        asked = self.question
        return asked is not None and self.answer != asked.right

    def encode(self) -> str:
        """Encode the progress; empty without any."""
        return msgspec.json.encode(self).decode() if self.chosen or self.asked else ""


def decoded(text: str) -> Practice | None:
    """Decode the progress from untrusted text; None if it is invalid."""
    try:
        found = msgspec.json.decode(text, type=Practice)
    except (msgspec.MsgspecError, ValueError, RecursionError):
        return None
    known = set(templates())
    usable = (
        set(found.chosen) <= known
        and (found.template in found.chosen or not found.template)
        and found.mastered <= known
        and 0 <= found.seed < _SEEDS
        and min(found.asked, found.right) >= 0
    )
    return found if usable else None


def quiz(chosen: Iterable[str]) -> str:
    """Text of a link that practises these templates."""
    return Practice(chosen=tuple(chosen), quiz=True, asked=0).encode()
