"""Controls of a class: the teacher's, and the students' side."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import viser

from abi.arrays import FloatArray
from abi.obstacles.pose import Vec3
from abi.scene.scene import Scene
from app.panels.teach.answer_dots import AnswerDots
from app.panels.teach.lessons import LessonPanel
from app.panels.teach.poll_text import question_text
from app.panels.teach.search_theatre import TheatrePanel
from app.panels.widgets import Wake, pressed
from app.shared.shared_plans import SharedPlans
from app.state.frame import Frame
from app.state.tab_state import TabState
from app.teach.classroom import Classroom
from app.teach.measures import filled
from app.teach.poll import MAX_CHOICES, ROUNDS, Answer, Poll
from app.theatre.theatre import node_at
from app.ui import notices
from app.ui.overlay import Overlay, button

_FIRST = -1.0
"""Place in the tab: before all that is there."""
_NEXT = "Which node is visited next?"
_NONE_RIGHT = "none is told"
_RIGHT = (_NONE_RIGHT, *(f"answer {number + 1}" for number in range(MAX_CHOICES)))


class ClassroomPanel:
    """Widgets of one tab; which are seen depends on whether it is the teacher's."""

    def __init__(
        self,
        client: viser.ClientHandle,
        overlay: Overlay,
        classroom: Classroom,
        lessons: LessonPanel,
        wake: Wake,
        nudge: Callable[[], None],
        hurry: Callable[[], None],
    ) -> None:
        gui, self._classroom, self._tab = client.gui, classroom, client.client_id
        self._client, self._overlay, self._lessons = client, overlay, lessons
        self._wake, self._hurry = wake, hurry
        self.teaches = False
        self._seen = 0
        self._fresh = False  # whether a teacher's tab has no view of its own yet
        self._followed: Scene | None = None
        self._drawn: tuple[object, ...] = ()
        self._chosen: list[int] = []
        self._click: tuple[FloatArray, FloatArray] | None = None
        self._published: TabState | None = None
        self._frame: Frame | None = None
        self._dots = AnswerDots(client.scene)
        # above the lessons, whose text is long
        self._folder = gui.add_folder("Class", order=_FIRST)
        with self._folder:
            self.follow = gui.add_checkbox("follow the teacher", True)
            self.word = gui.add_text(
                "your word", "", hint="For the results, if you like: any word but your name."
            )
            self.lead = gui.add_checkbox(
                "all follow me", False, visible=False, hint="What you show, the others see."
            )
            self.send = gui.add_button("Show this to all once", visible=False)
            self.question = gui.add_text("question", "", visible=False)
            self.choices = [
                gui.add_text(f"answer {number + 1}", "", visible=False)
                for number in range(MAX_CHOICES)
            ]
            self.right = gui.add_dropdown(
                "right answer",
                _RIGHT,
                visible=False,
                hint="Told when the answers are revealed, with the gain of a second round.",
            )
            self.ask = gui.add_button("Ask all", visible=False)
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
            self._text = gui.add_html("", visible=False)
            self.answers = [
                gui.add_button("", visible=False, color="gray") for _ in range(MAX_CHOICES)
            ]
            self.reveal = gui.add_button("Reveal the answers", visible=False)
            self.again = gui.add_button(
                "Second round", visible=False, hint="After a discussion; hides the answers again."
            )
            self.close_poll = gui.add_button("Close the question", visible=False, color="gray")
            self.results = gui.add_button(
                "Save the results", visible=False, color="gray", hint="All answers as CSV."
            )
        for box in (self.follow, self.lead):
            box.on_update(wake)
        for text in (self.word, self.question, *self.choices, self.right):
            text.on_update(wake)
        for one in self._buttons:
            one.on_click(wake)
        for number, choice in enumerate(self.answers):
            choice.on_click(partial(self._answer, number))
        client.scene.on_click()(self._clicked)
        classroom.join(self._tab, nudge)

    @property
    def _buttons(self) -> tuple[viser.GuiButtonHandle, ...]:
        """What the teacher presses."""
        asking = self.ask, self.ask_lesson, self.ask_place, self.ask_next
        return (self.send, *asking, self.reveal, self.again, self.close_poll, self.results)

    @property
    def _written(self) -> tuple[viser.GuiInputHandle[str], ...]:
        """What the teacher writes of a question."""
        return (self.question, *self.choices, self.right)

    def close(self) -> None:
        """Leave the class."""
        self._classroom.leave(self._tab)

    def recognise(self, secret: str, student: str, fresh: bool = False) -> None:
        """Give the tab the teacher's controls if its address has the secret.

        Args:
            secret: what the address has; empty for none.
            student: whose tab it is, as its browser says; empty for nobody known.
            fresh: whether the browser remembers no view of this tab.
        """
        room = self._classroom
        room.recognise(self._tab, student)
        if word := room.word(self._tab):
            self.word.value = word
        if secret and room.is_teacher(secret):
            self.teaches, self._fresh = True, fresh
            room.teach(self._tab, self._hurry)
            self.follow.visible = self.word.visible = False
            self.lead.visible = True
            for written in self._written:
                written.visible = True
            for asking in (self.send, self.ask, self.ask_place):
                asking.visible = True
            # what has been set and typed before the page could say whose it is stays
            self.lead.value = bool(self.lead.value) or room.lead
            for box, text in zip((self.question, *self.choices), room.draft, strict=False):
                box.value = box.value or text
            if self.right.value == _NONE_RIGHT and room.draft[-1:] and room.draft[-1] in _RIGHT:
                self.right.value = room.draft[-1]

    def view(self) -> TabState | None:
        """The newest view that the teacher has sent since the last call; None for none.

        A teacher's tab in a browser that knows none takes the one that the class has.
        """
        number, view = self._classroom.view
        if self.teaches:
            fresh, self._fresh = self._fresh, False
            return view if fresh else None
        if not self.follow.value:
            self._seen = 0  # whoever follows again is shown what the class sees
        if not self.follow.value or number == self._seen:
            return None
        self._seen, self._followed = number, None if view is None else view.scene
        return view

    def shared_plans(self, scene: Scene) -> SharedPlans | None:
        """Plans of the class where all show ``scene``: the teacher's, or what a student follows."""
        shared = self.teaches or (self._followed is not None and self._followed == scene)
        return self._classroom.plans if shared else None

    def hold_back(self, theatre: TheatrePanel) -> None:
        """Keep the answer to the class's question out of lesson and search while it is open."""
        poll = self._classroom.poll
        hidden = poll is not None and not poll.revealed
        self._lessons.voted = hidden and not self.teaches
        # the hall sees the teacher's search
        theatre.voted = poll is not None and hidden and bool(poll.places)
        theatre.yields_clicks = self._takes_clicks

    @property
    def _takes_clicks(self) -> bool:
        """Whether a click in the scene is an answer."""
        poll = self._classroom.poll
        return poll is not None and poll.asks_place and not self.teaches

    def publish(self, state: TabState) -> None:
        """Do what the teacher asked for, and send what changes while the others follow."""
        if not self.teaches:
            return
        self._classroom.set(bool(self.lead.value), tuple(box.value for box in self._written))
        self._ask()
        if pressed(self.reveal):
            self._classroom.reveal()
        if pressed(self.again):
            self._classroom.ask_again()
        if pressed(self.close_poll):
            self._classroom.close_poll()
        if pressed(self.results):
            table = "\ufeff" + self._classroom.results()
            self._client.send_file_download("results.csv", table.encode(), save_immediately=True)
        once = pressed(self.send)
        if once or self.lead.value:
            view = replace(state.alone(), dark=None, challenge="", practice="")
            if once or view != self._published:
                self._published = view
                self._classroom.show(view)

    def _ask(self) -> None:
        """Ask what the teacher asks."""
        text, frame, lesson = self.question.value, self._frame, self._lessons.place
        right_one = _RIGHT.index(self.right.value) - 1
        if pressed(self.ask) and not self._classroom.ask(
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
            self._classroom.ask_place(_NEXT, tuple(map(_place, right)), lesson)
        asked = self._lessons.question
        if pressed(self.ask_lesson) and asked is not None and frame is not None:
            texts = [filled(choice.text, frame) for choice in asked.choices]
            right_one = next(k for k, choice in enumerate(asked.choices) if choice.right)
            why = filled(asked.choices[right_one].why, frame)
            self._classroom.ask(filled(asked.text, frame), tuple(texts), right_one, why, lesson)

    def _refuse(self, reason: str) -> None:
        notices.notify_refusal(self._client, "Not asked", reason)

    def draw(self, frame: Frame) -> None:
        """Show the question with its answers, and the counts to the teacher; no frame counts."""
        self._frame = frame
        if not self.teaches:
            self._classroom.name(self._tab, self.word.value)
        self._take(frame)
        poll, own = self._classroom.poll, self._classroom.answer_of(self._tab)
        students = self._classroom.taking_part
        self._draw_places(poll, own, frame)
        sees_all = self.teaches or (poll is not None and poll.revealed)
        told = (len(poll.answers), students) if poll is not None and self.teaches else ()
        answers = poll.answers if poll is not None and sees_all else None
        identity = poll and (poll.number, len(poll.rounds), poll.revealed)
        lesson = self.teaches and self._lessons.question is not None
        steps = self.teaches and frame.theatre is not None and not frame.theatre.race
        state = (identity, told, answers, own, students, self.teaches, frame.lecture, lesson, steps)
        if state == self._drawn:
            return
        self._drawn = state
        self.ask_lesson.visible, self.ask_next.visible = lesson, steps
        self._show_controls(poll)
        self._text.visible = poll is not None
        for number, widget in enumerate(self.answers):
            open_choices = () if poll is None or poll.revealed else poll.choices
            widget.visible = not self.teaches and number < len(open_choices)
            if widget.visible:
                mark = "Your answer: " if number == own else ""
                widget.label = f"{mark}{open_choices[number]}"
        if poll is None:
            self._overlay.show("class", "")
            return
        text = question_text(poll, students, answered=self.teaches)
        self._text.content = text
        # a student sees it in whichever tab, the hall in a lecture, whose panels are folded
        open_ = frame.lecture if self.teaches else own is None and not poll.revealed
        self._overlay.show("class", self._card(poll, text) if open_ else "")

    def _show_controls(self, poll: Poll | None) -> None:
        """Show what the teacher can do with the present question."""
        on = self.teaches and poll is not None
        hidden = on and poll is not None and not poll.revealed
        self.reveal.visible = hidden
        # who has been told the answer has nothing to talk about
        again = hidden or (on and poll is not None and not poll.has_right)
        self.again.visible = again and poll is not None and len(poll.rounds) < ROUNDS
        self.close_poll.visible = on
        self.results.visible = self.teaches

    def _take(self, frame: Frame) -> None:
        """Give the answers that were pressed or clicked since the last frame."""
        poll = self._classroom.poll
        chosen, self._chosen = self._chosen, []
        click, self._click = self._click, None
        if poll is None or self.teaches:
            return
        for number in chosen:
            self._classroom.answer(self._tab, poll.number, number)
        if click is not None and poll.asks_place:
            place = _clicked_node(frame, *click)
            if place is not None:
                self._classroom.answer(self._tab, poll.number, place)

    def _draw_places(self, poll: Poll | None, own: Answer | None, frame: Frame) -> None:
        """Show the places that were answered: all once they are revealed, before that the own."""
        given: list[Answer] = []
        right: tuple[Vec3, ...] = ()
        if poll is not None and poll.asks_place:
            given = [own] if own is not None else []
            if poll.revealed:
                given, right = list(poll.answers.values()), poll.places
        places = [answer for answer in given if not isinstance(answer, int)]
        self._dots.draw(places, right, frame.plan.scene)

    def _card(self, poll: Poll, text: str) -> str:
        """The question over the scene, as HTML, with the answers to press or their bars."""
        if not self.teaches and poll.choices:
            pairs = zip(self.answers, poll.choices, strict=False)
            buttons = "".join(button(widget, choice) for widget, choice in pairs)
            text += f'<div class="abi-buttons">{buttons}</div>'
        return f'<div class="abi-card abi-tour">{text}</div>'

    def _answer(self, number: int, event: Any) -> None:
        self._chosen.append(number)
        self._wake(event)

    def _clicked(self, event: Any) -> None:
        if not self._takes_clicks:
            return
        ray = np.array(event.ray_origin, float), np.array(event.ray_direction, float)
        if np.isfinite(ray).all():
            self._click = ray
            self._wake(event)


def _clicked_node(frame: Frame, origin: FloatArray, direction: FloatArray) -> Vec3 | None:
    """Place of the node that a ray means: one that waits in a search, or any with an edge."""
    if frame.theatre is not None:
        state = frame.theatre.state
        n = len(state.trace.arcs.points)
        points, nodes = state.trace.arcs.points, state.open % n
    elif frame.plan.graph is not None:
        graph = frame.plan.graph
        points = graph.points
        nodes = np.flatnonzero(np.diff(graph.indptr)).astype(np.int32)
    else:
        return None
    node = node_at(points, nodes, origin, direction)
    return None if node < 0 else _place(points[node])


def _place(point: FloatArray) -> Vec3:
    x, y, z = (float(number) for number in point)
    return x, y, z
