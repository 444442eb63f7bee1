"""The teacher's controls of a question to all: what it asks, and its rounds and answers."""

from __future__ import annotations

import viser

from abi.arrays import FloatArray
from abi.obstacles.pose import Vec3
from app.panels.teach.lessons import LessonPanel
from app.panels.widgets import Wake, pressed
from app.state.frame import Frame
from app.teach.classroom import Classroom
from app.teach.measures import filled
from app.teach.poll import MAX_CHOICES, ROUNDS, Poll
from app.ui import notices

_NEXT = "Which node is visited next?"
_NONE_RIGHT = "none is told"
_RIGHT = (_NONE_RIGHT, *(f"answer {number + 1}" for number in range(MAX_CHOICES)))


class QuestionControls:
    """Boxes and buttons that only the teacher's tab shows, around the question that all see."""

    def __init__(
        self, client: viser.ClientHandle, classroom: Classroom, lessons: LessonPanel, wake: Wake
    ) -> None:
        """Add what asks a question; :meth:`add_last` adds what comes below that."""
        self._client, self._classroom, self._lessons, self._wake = client, classroom, lessons, wake
        gui = client.gui
        self.question = gui.add_text("question", "", visible=False)
        self.choices = [
            gui.add_text(f"answer {number + 1}", "", visible=False) for number in range(MAX_CHOICES)
        ]
        self.right = gui.add_dropdown(
            "right answer",
            _RIGHT,
            visible=False,
            hint="Told when the answers are revealed, with the gain of a second round.",
        )
        self.ask_own = gui.add_button("Ask all", visible=False)
        self.ask_lesson = gui.add_button("Ask this lesson's question", visible=False)
        self.ask_place = gui.add_button(
            "Ask for a place",
            visible=False,
            color="gray",
            hint="The question above; the answer is a node that is clicked in the scene.",
        )
        self.ask_next = gui.add_button(
            "Ask which node comes next",
            visible=False,
            color="gray",
            hint="Of the search that you step through; the answer is clicked in the scene.",
        )
        self._written = (self.question, *self.choices, self.right)
        for box in self._written:
            box.on_update(wake)
        for button in (self.ask_own, self.ask_lesson, self.ask_place, self.ask_next):
            button.on_click(wake)

    def add_last(self, gui: viser.GuiApi) -> None:
        """Add what is done with a question, once its text and answers have been added."""
        self.reveal = gui.add_button("Reveal the answers", visible=False)
        self.again = gui.add_button(
            "Second round", visible=False, hint="After a discussion; hides the answers again."
        )
        self.close_poll = gui.add_button("Close the question", visible=False, color="gray")
        self.results = gui.add_button(
            "Save the results", visible=False, color="gray", hint="All answers as CSV."
        )
        for button in (self.reveal, self.again, self.close_poll, self.results):
            button.on_click(self._wake)

    @property
    def draft(self) -> tuple[str, ...]:
        """What is written of a question: its text, its answers, and which is right."""
        return tuple(box.value for box in self._written)

    def open(self, draft: tuple[str, ...]) -> None:
        """Show the controls, with a draft in the boxes in which nothing is typed."""
        for shown in (*self._written, self.ask_own, self.ask_place):
            shown.visible = True
        for box, text in zip((self.question, *self.choices), draft, strict=False):
            box.value = box.value or text
        if self.right.value == _NONE_RIGHT and draft[-1:] and draft[-1] in _RIGHT:
            self.right.value = draft[-1]

    def ask(self, frame: Frame | None) -> None:
        """Ask what was asked for since the last call, with the numbers of a frame."""
        text, lesson = self.question.value, self._lessons.progress.place
        right_one = _RIGHT.index(self.right.value) - 1
        if pressed(self.ask_own) and not self._classroom.ask(
            text, tuple(box.value for box in self.choices), right_one, lesson=lesson
        ):
            self._refuse("A question needs a text and two answers or more.")
        if pressed(self.ask_place):
            if text.strip():
                self._classroom.ask_place(text, lesson=lesson)
            else:
                self._refuse("Write the question first, such as: where will the path pass?")
        if pressed(self.ask_next) and frame is not None and frame.theatre is not None:
            state = frame.theatre.state
            n = len(state.trace.arcs.points)
            right = state.trace.arcs.points[state.candidates() % n]
            self._classroom.ask_place(_NEXT, tuple(map(place_of, right)), lesson)
        asked = self._lessons.progress.question
        if pressed(self.ask_lesson) and asked is not None and frame is not None:
            texts = [filled(choice.text, frame) for choice in asked.choices]
            right_one = next(k for k, choice in enumerate(asked.choices) if choice.right)
            why = filled(asked.choices[right_one].why, frame)
            self._classroom.ask(filled(asked.text, frame), tuple(texts), right_one, why, lesson)

    def answer_presses(self) -> None:
        """Reveal, ask again, close or save what was asked for since the last call."""
        if pressed(self.reveal):
            self._classroom.reveal()
        if pressed(self.again):
            self._classroom.ask_again()
        if pressed(self.close_poll):
            self._classroom.close_poll()
        if pressed(self.results):
            table = "\ufeff" + self._classroom.results()
            self._client.send_file_download("results.csv", table.encode(), save_immediately=True)

    def show(self, poll: Poll | None, lesson: bool, steps: bool) -> None:
        """Show what can be done now.

        Args:
            poll: the present question.
            lesson: whether the page of a lesson has one to ask.
            steps: whether a search is stepped through, of which the next node can be asked.
        """
        self.ask_lesson.visible, self.ask_next.visible = lesson, steps
        hidden = poll is not None and not poll.revealed
        self.reveal.visible = hidden
        # who has been told the answer has nothing to talk about
        again = hidden or (poll is not None and not poll.has_right)
        self.again.visible = again and poll is not None and len(poll.rounds) < ROUNDS
        self.close_poll.visible = poll is not None
        self.results.visible = True

    def _refuse(self, reason: str) -> None:
        notices.notify_refusal(self._client, "Not asked", reason)


def place_of(point: FloatArray) -> Vec3:
    """A point (3,) as a place that a question can have as its answer."""
    x, y, z = (float(number) for number in point)
    return x, y, z
