"""Practise: endless questions with their answers, and links that a teacher makes of some."""

from __future__ import annotations

import html
from functools import partial
from typing import Any

import viser

from abi.scene.scene import Scene
from abi.teach.quiz.question import QuizQuestion
from abi.teach.quiz.templates import templates
from app.panels.widgets import Wake, pressed
from app.state.frame import Frame
from app.teach.lesson import Setting
from app.teach.practice import MASTERY, Practice, decoded, quiz
from app.ui import style

_NONE, _MIX = "choose a subject", "a mix of all"
_MOST_CHOICES = 4
_SHOWN = ("workspace", "obstacles")
_BEFORE_LESSONS = -0.5
"""Place in the tab while something is practised."""
_INTRO = "Questions without end, and why each answer is right. Five in a row are mastery."


class PracticePanel:
    """Widgets of one tab, and where the student is.

    Attributes:
        practice: where the student is.
    """

    def __init__(self, gui: viser.GuiApi, wake: Wake) -> None:
        self._wake = wake
        self.practice = Practice()
        self._presses: list[int] = []
        self._drawn: tuple[object, ...] = ()
        self._subjects = {title: name for name, title in templates().items()}
        self._shows = False
        self._folder = gui.add_folder("Practise", expand_by_default=False)
        self._place = self._folder.order
        with self._folder:
            self._text = gui.add_html(style.paragraph(_INTRO))
            self.subject = gui.add_dropdown("subject", (_NONE, _MIX, *self._subjects))
            self._question = gui.add_html("", visible=False)
            self.answers = [
                gui.add_button("", visible=False, color="gray") for _ in range(_MOST_CHOICES)
            ]
            self._reply = gui.add_html("", visible=False)
            self.next = gui.add_button("Next question", visible=False)
            self.look = gui.add_button(
                "Show the scene", visible=False, color="gray", hint="The boxes of the question."
            )
            self.back = gui.add_button("Back to my scene", visible=False, color="gray")
            with gui.add_folder("A quiz for others", expand_by_default=False):
                self.asked = {
                    name: gui.add_checkbox(title, False) for name, title in templates().items()
                }
                self.link = gui.add_button(
                    "Copy quiz link", hint="Whoever opens it is asked about these, without end."
                )
        for number, button in enumerate(self.answers):
            button.on_click(partial(self._press, number))
        self.subject.on_update(wake)
        for button in (self.next, self.look, self.back, self.link):
            button.on_click(wake)
        self._chosen = _NONE

    @property
    def kept(self) -> str:
        """The practice as a text to keep; empty where there is nothing to keep."""
        return self.practice.encode()

    def restore(self, text: str) -> None:
        """Go on where a kept text says, which may come from anyone."""
        if not text or text == self.kept:
            return
        found = decoded(text)
        if found is None:
            return
        self.practice = found if found.template else found.begun(found.chosen, found.quiz)
        self._folder.expand_by_default = True

    def quiz_link(self) -> str:
        """The practice of a link that was asked for since the last call; empty for none."""
        if not pressed(self.link):
            return ""
        names = [name for name, box in self.asked.items() if box.value]
        return quiz(names or self.practice.chosen or templates())

    def cue(self) -> tuple[Setting, Scene] | None:
        """The scene of the question, if it was asked for since the last call."""
        self._take()
        asked = self.practice.question if pressed(self.look) else None
        if asked is None or asked.scene is None:
            return None
        self._shows = True
        return Setting(scene="question", shown=_SHOWN), asked.scene

    def left(self) -> bool:
        """Check whether the scene of a question was left since the last call."""
        left = pressed(self.back) and self._shows
        self._shows = self._shows and not left
        return left

    def draw(self, frame: Frame) -> None:
        """Show the question; no frame counts but that a lesson hides it."""
        self._folder.visible = not frame.lesson
        state = self.practice, self._shows
        if state == self._drawn:
            return
        self._drawn = state
        asked = self.practice.question
        for widget in (self._question, self._reply, self.next, self.look):
            widget.visible = asked is not None
        self.back.visible = self._shows
        self._folder.order = self._place if asked is None else _BEFORE_LESSONS
        self._text.content = style.paragraph(_progress(self.practice))
        for number, button in enumerate(self.answers):
            button.visible = asked is not None and number < len(asked.choices)
        if asked is not None:
            self._write(asked)

    def _write(self, asked: QuizQuestion) -> None:
        answer = self.practice.answer
        self._question.content = style.paragraph(f"<b>{html.escape(asked.text)}</b>")
        for number, choice in enumerate(asked.choices):
            sign = ""
            if answer >= 0 and number in (answer, asked.right):
                sign = "✓ " if number == asked.right else "✗ "
            self.answers[number].label = sign + choice
        right = answer == asked.right
        word = "✓ Right." if right else "✗ No."
        colour = style.readable(style.GOOD if right else style.BAD)
        told = f'<b style="color:{colour}">{word}</b> {html.escape(asked.why)}'
        self._reply.content = style.paragraph(told)
        self._reply.visible = self.next.visible = answer >= 0
        self.look.visible = asked.scene is not None

    def _take(self) -> None:
        """Do what was pressed or chosen since the last call."""
        if self.subject.value != self._chosen:
            self._chosen = self.subject.value
            names = {_NONE: (), _MIX: tuple(templates())}
            one = self._subjects.get(self._chosen)
            self.practice = self.practice.begun(
                names.get(self._chosen, ()) if one is None else (one,)
            )
        while self._presses:
            self.practice = self.practice.answered(self._presses.pop(0))
        if pressed(self.next):
            self.practice = self.practice.next()

    def _press(self, number: int, event: Any) -> None:
        self._presses.append(number)
        self._wake(event)


def _progress(practice: Practice) -> str:
    """What has been reached, as HTML."""
    if not practice.template:
        return _INTRO
    title = templates()[practice.template]
    streak = practice.streaks.get(practice.template, 0)
    mastered = [name for name in practice.chosen if name in practice.mastered]
    state = "✓ mastered" if practice.template in practice.mastered else f"{streak} of {MASTERY}"
    whole = f"{len(mastered)} of {len(practice.chosen)} subjects mastered, "
    whole = whole if len(practice.chosen) > 1 else ""
    head = "A quiz of your teacher's. " if practice.quiz else ""
    return (
        f"{head}<b>{html.escape(title)}</b> {state}; {whole}{practice.right} of "
        f"{practice.asked} right."
    )
