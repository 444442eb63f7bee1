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
from app.panels.teach.answer_dots import Balls, draw_answers
from app.panels.teach.lessons import LessonPanel
from app.panels.teach.poll_text import question_text
from app.panels.teach.question_controls import QuestionControls, place_of
from app.panels.teach.search_theatre import TheatrePanel
from app.panels.widgets import Wake, pressed
from app.shared.shared_plans import SharedPlans
from app.state.frame import Frame
from app.state.tab_state import TabState
from app.teach.classroom import Classroom
from app.teach.poll import MAX_CHOICES, Answer, Poll
from app.theatre.theatre import node_at
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
        self._balls: Balls = {}
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
            self.asking = QuestionControls(client, classroom, lessons, wake)
            self._text = gui.add_html("", visible=False)
            self.answers = [
                gui.add_button("", visible=False, color="gray") for _ in range(MAX_CHOICES)
            ]
            self.asking.add_last(client.gui)
        for box in (self.follow, self.lead):
            box.on_update(wake)
        self.word.on_update(wake)
        self.send.on_click(wake)
        for number, choice in enumerate(self.answers):
            choice.on_click(partial(self._answer, number))
        client.scene.on_click()(self._clicked)
        classroom.join(self._tab, nudge)

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
            self.send.visible = True
            # what has been set and typed before the page could say whose it is stays
            self.lead.value = bool(self.lead.value) or room.lead
            self.asking.open(room.draft)

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
        self._classroom.set(bool(self.lead.value), self.asking.draft)
        self.asking.ask(self._frame)
        self.asking.answer_presses()
        once = pressed(self.send)
        if once or self.lead.value:
            view = replace(state.alone(), dark=None, challenge="", practice="")
            if once or view != self._published:
                self._published = view
                self._classroom.show(view)

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
        lesson = self.teaches and self._lessons.progress.question is not None
        steps = self.teaches and frame.theatre is not None and not frame.theatre.race
        state = (identity, told, answers, own, students, self.teaches, frame.lecture, lesson, steps)
        if state == self._drawn:
            return
        self._drawn = state
        if self.teaches:
            self.asking.show(poll, lesson, steps)
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
        draw_answers(self._client.scene, self._balls, places, right, frame.plan.scene)

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
    return None if node < 0 else place_of(points[node])
