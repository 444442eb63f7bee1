"""A class: what its teacher shows to all tabs, and what the tabs answer."""

from __future__ import annotations

import contextlib
import logging
import secrets
import threading
from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import datetime
from pathlib import Path

from abi.obstacles.pose import Vec3
from app.shared.shared_plans import SharedPlans
from app.state.tab_state import TabState
from app.teach.class_file import read_record, record_beside, write_record
from app.teach.class_table import table
from app.teach.poll import ROUNDS, Answer, Poll, Record, poll_of

_log = logging.getLogger("abi.class")
_MAX_WORD = 30
"""Most characters of a student's word."""


class Classroom:
    """State shared by the sessions of a server; thread-safe.

    All tabs of a student's browser have one answer. Whose a tab is, its page says: whoever writes
    pages of his own, or opens another browser, can still answer more than once.

    Attributes:
        secret: what a teacher's address has and no other: ``?teach=…``.
        plans: of what the teacher shows; one tab makes them for all.
        view: number of the view sent last, 0 for none, and the view.
    """

    def __init__(
        self, secret: str | None = None, file: Path | None = None, results: Path | None = None
    ) -> None:
        """Begin without tabs.

        Args:
            secret: the teacher's; by default it is generated.
            file: of the record, with which it goes on; None to keep none, or the one beside the
                results.
            results: table to keep of the answers; without one the record is deleted at the end.
        """
        self.secret = secret or secrets.token_urlsafe(16)
        self.plans = SharedPlans()
        self._lock = threading.Lock()
        self._wakes: dict[int, Callable[[], None]] = {}
        self.view: tuple[int, TabState | None] = (0, None)
        self._results = results
        self._file = record_beside(results) if file is None and results is not None else file
        self._record = Record() if self._file is None else read_record(self._file)
        self._students: dict[int, str] = {}
        self._teachers: set[int] = set()

    @property
    def poll(self) -> Poll | None:
        """The present question with its answers; None without one."""
        record = self._record
        return None if record.closed or not record.asked else record.asked[-1]

    @property
    def lead(self) -> bool:
        """Whether all tabs follow the teacher's."""
        return self._record.lead

    @property
    def draft(self) -> tuple[str, ...]:
        """Question and answers that the teacher is writing."""
        return tuple(self._record.draft)

    def is_teacher(self, secret: str) -> bool:
        """Check the teacher's secret, in constant time."""
        return secrets.compare_digest(secret.encode(), self.secret.encode())

    def join(self, tab: int, wake: Callable[[], None]) -> None:
        """Have ``wake`` called on every change."""
        with self._lock:
            self._wakes[tab], self._students[tab] = wake, f"tab {tab}"

    def recognise(self, tab: int, student: str) -> None:
        """Assign a tab to a student; its earlier answer without one is dropped."""
        with self._lock:
            if tab in self._students and student:
                self._forget(f"tab {tab}")
                self._students[tab] = f"student {student}"

    def teach(self, tab: int, wake: Callable[[], None]) -> None:
        """Mark a tab as the teacher's, whose ``wake`` answers call from now on."""
        with self._lock:
            self._teachers.add(tab)
            self._wakes[tab] = wake

    def leave(self, tab: int) -> None:
        """Forget a closed tab; its student's answer stays if the student can return."""
        with self._lock:
            self._wakes.pop(tab, None)
            self._teachers.discard(tab)
            if self._students.pop(tab, "") == f"tab {tab}":
                self._forget(f"tab {tab}")

    def end(self) -> None:
        """Delete the answers, unless the results are kept."""
        if self._file is not None and self._results is None:
            with contextlib.suppress(OSError):
                self._file.unlink()

    def show(self, view: TabState) -> None:
        """Show a view in all tabs; a tab that has not yet taken the last one gets only this."""
        with self._lock:
            self.view = (self.view[0] + 1, view)
        self._wake_all()

    def set(self, lead: bool, draft: tuple[str, ...]) -> None:
        """Record the teacher's settings for tabs that are opened later."""
        with self._lock:
            if (lead, list(draft)) == (self._record.lead, self._record.draft):
                return
            self._record.lead, self._record.draft = lead, list(draft)
            self._write()

    def ask(
        self,
        text: str,
        choices: tuple[str, ...],
        right: int = -1,
        why: str = "",
        lesson: str = "",
    ) -> bool:
        """Ask all tabs a question; False if it has fewer than two answers."""
        poll = poll_of(self._next, text, choices, right, why)
        if poll is not None:
            self._begin(replace(poll, lesson=lesson))
        return poll is not None

    def ask_place(self, text: str, places: tuple[Vec3, ...] = (), lesson: str = "") -> None:
        """Ask all tabs for a place in the scene, of which ``places`` are right."""
        self._begin(Poll(self._next, text, places=places, lesson=lesson))

    def reveal(self) -> None:
        """Reveal the answers to all."""
        self._change(lambda poll: replace(poll, revealed=True))

    def ask_again(self) -> None:
        """Begin the second round of the present question."""
        self._change(_second_round)

    def close_poll(self) -> None:
        """Close the present question; its answers stay in the results."""
        with self._lock:
            self._record.closed = True
            self._write()
        self._wake_all()

    def answer(self, tab: int, number: int, answer: Answer) -> None:
        """Record a student's latest answer, if the question is still open.

        Once the right answer has been told, none is counted any more.
        """
        with self._lock:
            poll, student = self.poll, self._students.get(tab)
            if poll is None or student is None or (poll.revealed and poll.has_right):
                return
            if poll.number != number or not poll.takes(answer):
                return
            rounds = (*poll.rounds[:-1], {**poll.answers, student: answer})
            self._record.asked[-1] = replace(poll, rounds=rounds)
            self._write()
            own = {other for other, whose in self._students.items() if whose == student} - {tab}
            told = set(self._wakes) if poll.revealed else self._teachers | own
            wakes = [wake for other, wake in self._wakes.items() if other in told and other != tab]
        for wake in wakes:
            wake()

    def answer_of(self, tab: int) -> Answer | None:
        """Answer of a tab's student in this round; None without one."""
        poll = self.poll
        return None if poll is None else poll.answers.get(self._students.get(tab, ""))

    def counts(self) -> tuple[int, ...]:
        """Number of students for each answer of the present question."""
        poll = self.poll
        return () if poll is None else poll.counts()

    def name(self, tab: int, word: str) -> None:
        """Set the word that stands for a tab's student in the results."""
        with self._lock:
            student = self._students.get(tab, "")
            if self._record.words.get(student, "") != word[:_MAX_WORD]:
                self._record.words[student] = word[:_MAX_WORD]
                self._write()

    def word(self, tab: int) -> str:
        """Word of a tab's student; empty without one."""
        return self._record.words.get(self._students.get(tab, ""), "")

    def results(self) -> str:
        """All answers so far as CSV."""
        with self._lock:
            return table(self._record.asked, self._record.words)

    @property
    def students(self) -> int:
        """Number of students, not counting the teacher's tabs."""
        with self._lock:
            tabs = self._students.items()
            return len({student for tab, student in tabs if tab not in self._teachers})

    @property
    def taking_part(self) -> int:
        """Number of students who are present or have answered the present question."""
        poll = self.poll
        with self._lock:
            tabs = self._students.items()
            here = {student for tab, student in tabs if tab not in self._teachers}
        answers: Mapping[str, Answer] = {} if poll is None else poll.answers
        return len(here | set(answers))

    @property
    def _next(self) -> int:
        """Number of the next question."""
        return 1 + max((one.number for one in self._record.asked), default=0)

    def _begin(self, poll: Poll) -> None:
        now = datetime.now().astimezone().isoformat(timespec="seconds")
        with self._lock:
            self._record.asked.append(replace(poll, asked_at=now))
            self._record.closed = False
            self._write()
        self._wake_all()

    def _change(self, change: Callable[[Poll], Poll]) -> None:
        """Change the present question, if there is one."""
        with self._lock:
            poll = self.poll
            if poll is None:
                return
            self._record.asked[-1] = change(poll)
            self._write()
        self._wake_all()

    def _forget(self, student: str) -> None:
        """Drop the answer of the present student; the lock is held."""
        poll = self.poll
        if poll is not None and student in poll.answers:
            left = {key: value for key, value in poll.answers.items() if key != student}
            self._record.asked[-1] = replace(poll, rounds=(*poll.rounds[:-1], left))

    def _write(self) -> None:
        """Save the record; the lock is held."""
        if self._file is None:
            return
        try:
            write_record(self._file, self._record, self._results)
        except OSError as error:
            _log.warning("the class cannot be kept", extra={"reason": str(error)})

    def _wake_all(self) -> None:
        with self._lock:
            wakes = list(self._wakes.values())
        for wake in wakes:
            wake()


def _second_round(poll: Poll) -> Poll:
    """The question in its second round, with hidden answers."""
    if len(poll.rounds) >= ROUNDS:
        return poll
    return replace(poll, rounds=(*poll.rounds, {}), revealed=False)
