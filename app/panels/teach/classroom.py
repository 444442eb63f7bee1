"""Controls of a class: the teacher's, and the students' side."""

from __future__ import annotations

import html
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import viser

from abi.scene.scene import Scene
from app.panels.widgets import Wake, pressed
from app.shared.shared_plans import SharedPlans
from app.state.frame import Frame
from app.state.tab_state import TabState
from app.teach.classroom import MAX_CHOICES, Classroom
from app.ui import style
from app.ui.overlay import Overlay, button

_FIRST = -1.0
"""Place in the tab: before all that is there."""


class ClassroomPanel:
    """Widgets of one tab; which are seen depends on whether it is the teacher's."""

    def __init__(
        self,
        client: viser.ClientHandle,
        overlay: Overlay,
        classroom: Classroom,
        wake: Wake,
        nudge: Callable[[], None],
    ) -> None:
        gui, self._classroom, self._tab = client.gui, classroom, client.client_id
        self._overlay = overlay
        self._wake = wake
        self.teaches = False
        self._seen = 0
        self._followed: Scene | None = None
        self._drawn: tuple[object, ...] = ()
        self._chosen: list[int] = []
        self._published: TabState | None = None
        # above the lessons, whose text is long
        self._folder = gui.add_folder("Class", order=_FIRST)
        with self._folder:
            self.follow = gui.add_checkbox("follow the teacher", True)
            self.lead = gui.add_checkbox(
                "all follow me", False, visible=False, hint="What you show, the others see."
            )
            self.send = gui.add_button("Show this to all once", visible=False)
            self.question = gui.add_text("question", "", visible=False)
            self.choices = [
                gui.add_text(f"answer {number + 1}", "", visible=False)
                for number in range(MAX_CHOICES)
            ]
            self.ask = gui.add_button("Ask all", visible=False)
            self._text = gui.add_html("", visible=False)
            self.answers = [
                gui.add_button("", visible=False, color="gray") for _ in range(MAX_CHOICES)
            ]
        for widget in (self.follow, self.lead):
            widget.on_update(wake)
        for one in (self.send, self.ask):
            one.on_click(wake)
        for number, choice in enumerate(self.answers):
            choice.on_click(partial(self._answer, number))
        classroom.join(self._tab, nudge)

    def close(self) -> None:
        """Leave the class."""
        self._classroom.leave(self._tab)

    def recognise(self, secret: str, student: str) -> None:
        """Give the tab the teacher's controls if its address has the secret.

        Args:
            secret: what the address has; empty for none.
            student: whose tab it is, as its browser says; empty for nobody known.
        """
        self._classroom.recognise(self._tab, student)
        if secret and self._classroom.is_teacher(secret):
            self.teaches = True
            self._classroom.teach(self._tab)
            self.follow.visible = False
            for widget in (self.lead, self.question, *self.choices):
                widget.visible = True
            self.send.visible = self.ask.visible = True

    def view(self) -> TabState | None:
        """The newest view that the teacher has sent since the last call; None for none."""
        number, view = self._classroom.view
        if self.teaches or not self.follow.value or number == self._seen:
            return None
        self._seen, self._followed = number, None if view is None else view.scene
        return view

    def shared_plans(self, scene: Scene) -> SharedPlans | None:
        """Plans of the class where all show ``scene``: the teacher's, or what a student follows."""
        shared = self.teaches or (self._followed is not None and self._followed == scene)
        return self._classroom.plans if shared else None

    def publish(self, state: TabState) -> None:
        """Send what the teacher asked to send, or all that changes while the others follow."""
        if not self.teaches:
            return
        if pressed(self.ask):
            self._classroom.ask(self.question.value, tuple(box.value for box in self.choices))
        once = pressed(self.send)
        if once or self.lead.value:
            view = replace(state.alone(), dark=None, challenge="", practice="")
            if once or view != self._published:
                self._published = view
                self._classroom.show(view)

    def draw(self, frame: Frame) -> None:
        """Show the question with its answers, and the counts to the teacher; no frame counts."""
        poll, counts = self._classroom.poll, self._classroom.counts()
        while self._chosen and poll is not None:
            self._classroom.answer(self._tab, poll.number, self._chosen.pop(0))
            counts = self._classroom.counts()
        own = self._classroom.answer_of(self._tab)
        told = counts if self.teaches else ()
        state = (poll, told, own, self._classroom.students, self.teaches, frame.lecture)
        if state == self._drawn:
            return
        self._drawn = state
        self._text.visible = poll is not None
        if poll is None:
            return
        text = style.paragraph(f"<b>{html.escape(poll.text)}</b>")
        if self.teaches:
            text += bars(poll.choices, counts, self._classroom.students)
        self._text.content = text
        for number, widget in enumerate(self.answers):
            widget.visible = not self.teaches and number < len(poll.choices)
            if widget.visible:
                mark = "Your answer: " if number == own else ""
                widget.label = f"{mark}{poll.choices[number]}"
        # a student sees it in whichever tab, the hall in a lecture, whose panels are folded
        open_ = frame.lecture if self.teaches else own < 0
        self._overlay.show("class", self._card(poll.choices, text) if open_ else "")

    def _card(self, choices: tuple[str, ...], text: str) -> str:
        """The question over the scene, as HTML, with the answers to press or their bars."""
        if not self.teaches:
            pairs = zip(self.answers, choices, strict=False)
            buttons = "".join(button(widget, choice) for widget, choice in pairs)
            text += f'<div class="abi-buttons">{buttons}</div>'
        return f'<div class="abi-card abi-tour">{text}</div>'

    def _answer(self, number: int, event: Any) -> None:
        self._chosen.append(number)
        self._wake(event)


def bars(choices: tuple[str, ...], counts: tuple[int, ...], students: int) -> str:
    """Bar plot of the answers, as HTML."""
    most = max(*counts, 1)
    rows = "".join(
        f'<div>{html.escape(choice)}: <b>{count}</b><div style="height:8px;border-radius:3px;'
        f'background:{style.css(style.POINT)};width:{100 * count / most:.0f}%"></div></div>'
        for choice, count in zip(choices, counts, strict=True)
    )
    return style.paragraph(f"{rows}{sum(counts)} of {students} have answered.")
