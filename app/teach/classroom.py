"""A class: what its teacher shows to all tabs, and what the tabs answer."""

from __future__ import annotations

import secrets
import threading
from collections.abc import Callable
from dataclasses import dataclass

from app.shared.shared_plans import SharedPlans
from app.state.tab_state import TabState

MAX_CHOICES = 4
_MAX_TEXT = 300
"""Letters of a question and of an answer."""


@dataclass(frozen=True)
class Poll:
    """A question to all.

    Attributes:
        number: from 1 on, another for each question.
        text: the question.
        choices: answers to choose from; 2 to ``MAX_CHOICES``.
    """

    number: int
    text: str
    choices: tuple[str, ...]


class Classroom:
    """State that the sessions of a server share; every method may be called from any thread.

    All tabs of a student's browser have one answer. Whose a tab is, its page says: whoever writes
    pages of his own, or opens another browser, can still answer more than once.

    Attributes:
        secret: what a teacher's address has and no other: ``?teach=…``.
        plans: of what the teacher shows; one tab makes them for all.
        view: number of the view sent last, 0 for none, and the view.
        poll: the question asked last; None before the first.
    """

    def __init__(self, secret: str | None = None) -> None:
        """Begin without tabs; without a secret, one is made."""
        self.secret = secret or secrets.token_urlsafe(16)
        self.plans = SharedPlans()
        self._lock = threading.Lock()
        self._wakes: dict[int, Callable[[], None]] = {}
        self.view: tuple[int, TabState | None] = (0, None)
        self.poll: Poll | None = None
        self._answers: dict[str, int] = {}
        self._students: dict[int, str] = {}
        self._teachers: set[int] = set()

    def is_teacher(self, secret: str) -> bool:
        """Check whether that is the teacher's secret; takes the same time for every wrong one."""
        return secrets.compare_digest(secret.encode(), self.secret.encode())

    def join(self, tab: int, wake: Callable[[], None]) -> None:
        """Have ``wake`` called whenever there is something new."""
        with self._lock:
            self._wakes[tab], self._students[tab] = wake, f"tab {tab}"

    def recognise(self, tab: int, student: str) -> None:
        """Count a tab among those of a student; an answer that it gave before is forgotten."""
        with self._lock:
            if tab in self._students and student:
                self._answers.pop(f"tab {tab}", None)
                self._students[tab] = f"student {student}"

    def teach(self, tab: int) -> None:
        """Count a tab among the teacher's: answers wake it."""
        with self._lock:
            self._teachers.add(tab)

    def leave(self, tab: int) -> None:
        """Forget a tab, and its student's answer with the last of them."""
        with self._lock:
            self._wakes.pop(tab, None)
            self._teachers.discard(tab)
            student = self._students.pop(tab, "")
            if student not in self._students.values():
                self._answers.pop(student, None)

    def show(self, view: TabState) -> None:
        """Send a view to all tabs; one that has not taken the last yet goes on to this."""
        with self._lock:
            self.view = (self.view[0] + 1, view)
        self._wake_all()

    def ask(self, text: str, choices: tuple[str, ...]) -> bool:
        """Ask all tabs; False where that is no question with two answers or more."""
        kept = tuple(choice[:_MAX_TEXT] for choice in choices if choice.strip())[:MAX_CHOICES]
        if not text.strip() or len(kept) < 2:
            return False
        with self._lock:
            number = 1 if self.poll is None else self.poll.number + 1
            self.poll, self._answers = Poll(number, text[:_MAX_TEXT], kept), {}
        self._wake_all()
        return True

    def answer(self, tab: int, number: int, choice: int) -> None:
        """Count a student's answer, the last one, if the question is still the one asked."""
        with self._lock:
            poll = self.poll
            if poll is None or poll.number != number or not 0 <= choice < len(poll.choices):
                return
            student = self._students.get(tab)
            if student is None:
                return
            self._answers[student] = choice
            own = {other for other, whose in self._students.items() if whose == student} - {tab}
            wakes = [wake for other, wake in self._wakes.items() if other in self._teachers | own]
        for wake in wakes:
            wake()

    def answer_of(self, tab: int) -> int:
        """Answer of a tab's student; -1 for none."""
        return self._answers.get(self._students.get(tab, ""), -1)

    def counts(self) -> tuple[int, ...]:
        """Number of students for each answer of the present question."""
        with self._lock:
            if self.poll is None:
                return ()
            given = list(self._answers.values())
            return tuple(given.count(choice) for choice in range(len(self.poll.choices)))

    @property
    def students(self) -> int:
        """Number of students; tabs that are the teacher's are none's."""
        with self._lock:
            tabs = self._students.items()
            return len({student for tab, student in tabs if tab not in self._teachers})

    def _wake_all(self) -> None:
        with self._lock:
            wakes = list(self._wakes.values())
        for wake in wakes:
            wake()
