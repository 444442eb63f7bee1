"""The lesson player: pages, questions before the answer, tasks that wait for the student."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from functools import partial
from typing import Any

import viser

from abi import assets
from abi.errors import SceneError
from abi.scene.scene import Scene
from app.panels.teach.exercise_start import ExerciseStart
from app.panels.widgets import Wake
from app.state.frame import Frame
from app.teach.cue import Cue
from app.teach.lesson import (
    NO_LESSONS,
    AnswerChoice,
    Library,
    Question,
    Setting,
    Step,
    scene_of,
)
from app.teach.measures import filled
from app.ui import notices, page, style
from app.ui.cards import Card, cards
from app.ui.formulas import with_formulas

_NONE = "choose a lesson"
_MOST_CHOICES = 4
_STAGE = re.compile(r"[Ss]tage \**(\d)")
_VOTED = "*The class is voting. Here you can answer afterwards.*"
_INTRO = style.paragraph(
    "Choose a lesson. It asks before it explains, lets you try for yourself, and "
    "brings your own scene back at the end."
)


class LessonPanel:
    """Widgets of the player, and where the student is.

    Attributes:
        voted: whether the class votes meanwhile, so that the page takes and tells no answer.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        library: Library,
        wake: Wake,
        held: Callable[[], bool],
    ) -> None:
        """Add the widgets; while a hand has ``held`` something, nothing in the scene is set."""
        gui, self._client, self._wake = client.gui, client, wake
        self._held = held
        self._library, self._lessons = library, NO_LESSONS
        self._name, self._number = "", 0
        self._passed: set[tuple[str, int]] = set()
        self._done = False  # whether the page was passed since it was turned to
        self._left = ""
        self._answer = -1
        self.voted = False
        self._cue: Setting | None = None
        self._ended = False
        self._pressed: list[str] = []
        self._drawn: tuple[object, ...] = ()
        self._finished = ""
        self._pointed = "", 0
        self.choice = gui.add_dropdown("lesson", (_NONE,), visible=False)  # set by the cards
        self._intro = gui.add_html(_INTRO)
        self._place = gui.add_html("", visible=False)
        self._text = gui.add_markdown("", visible=False)
        self._question = gui.add_markdown("", visible=False)
        self.answers = [
            gui.add_button("", visible=False, color="gray") for _ in range(_MOST_CHOICES)
        ]
        self._stage = gui.add_html("", visible=False)
        self._reply = gui.add_markdown("", visible=False)
        self._after = gui.add_markdown("", visible=False)
        self.exercise = ExerciseStart(client, wake)
        self.show_me = gui.add_button(
            "Show me", visible=False, color="gray", hint="Does it for you."
        )
        self.next = gui.add_button("Next", visible=False)
        self.next_lesson = gui.add_button("Next lesson", visible=False)
        self.back = gui.add_button("Back", visible=False, color="gray")
        # the line over the scene presses it, out of the way of who turns pages
        self.leave = gui.add_button("End lesson", visible=False)
        self.choice.on_update(wake)
        for number, button in enumerate(self.answers):
            button.on_click(partial(self._press, str(number)))
        steps = {"show": self.show_me, "next": self.next, "back": self.back, "leave": self.leave}
        steps["lesson"] = self.next_lesson
        for name, button in steps.items():
            button.on_click(partial(self._press, name))

    @property
    def chosen(self) -> bool:
        """Whether a lesson is gone through, which says itself what is shown."""
        return self._step is not None

    @property
    def asks(self) -> bool:
        """Whether the page asks a question that has not been answered yet."""
        step = self._step
        return step is not None and step.question is not None and not self._is_passed

    @property
    def question(self) -> Question | None:
        """The question of the page; None without one."""
        step = self._step
        return None if step is None else step.question

    @property
    def place(self) -> str:
        """Lesson and page where the student is, as a text; empty where no lesson is chosen."""
        if self._step is None:
            return ""
        lesson, number = self._lessons[self._name][0], list(self._lessons).index(self._name) + 1
        return (
            f"Lesson {number} of {len(self._lessons)}: {lesson.title}, "
            f"page {self._number + 1} of {len(lesson.steps)}"
        )

    @property
    def waiting(self) -> bool:
        """Whether there is a cue to follow."""
        return self._cue is not None

    @property
    def progress(self) -> str:
        """Place of the student and the steps passed, as a text to keep."""
        if not self._name and not self._passed:
            return ""
        passed = sorted(self._passed)
        return json.dumps({"lesson": self._name, "step": self._number, "passed": passed})

    def restore(self, text: str) -> None:
        """Go on where a kept text says; ignore one that says nothing of these lessons."""
        if not text or text == self.progress:
            return
        if self._lessons is NO_LESSONS:
            self._list()
        if place := self._parse(text):
            self._name, self._number = place
            self._done = place in self._passed  # with all that was revealed
            self.choice.value = self.titles[list(self._lessons).index(self._name)]

    def follow(self, text: str) -> bool:
        """Go where the teacher is; whether that ended a lesson, without a scene to go back to."""
        self.restore(text)
        if not self.chosen or self._parse(text) is not None:
            return False
        self._go("", 0)
        self._ended = False
        self.choice.value = _NONE
        return True

    def recall(self, text: str) -> None:
        """Take over what was passed in tabs that are closed; its lesson goes on where it stood."""
        self._left = text

    def cue(self, scene: Scene) -> Cue | None:
        """Setting of the lesson now, starting from ``scene``; None where it sets nothing."""
        self._take_presses()
        if self._cue is None:
            return None
        setting, self._cue = self._cue, None
        folder = self._lessons[self._name][1]
        try:
            return Cue(setting, scene_of(setting, scene, folder))
        except SceneError as error:
            notices.notify_refusal(self._client, "The lesson cannot change this", error.message)
            return None

    def left(self) -> bool:
        """Check whether a lesson was finished, or left, since the last call."""
        ended, self._ended = self._ended, False
        return ended

    def draw(self, frame: Frame) -> None:
        """Show the page with the frame's numbers; go on where its task is done."""
        resting = not (frame.interactive or frame.plan.partial or not frame.current)
        if resting and self._lessons is NO_LESSONS:
            self._list()
        step = self._step
        if (
            step is not None
            and step.task is not None
            and not self._done
            and resting
            and self._cue is None
            and step.task.is_done(frame)
            and (step.reveal == Setting() or not self._held())
        ):
            self._pass(step)
        if step is None:
            state = self._lessons is NO_LESSONS, self._finished, len(self._passed)
            if state != self._drawn:
                self._drawn = state
                self._write(frame, resting)
                self._intro.content = _INTRO + self._cards()
            return
        place = self._name, self._number, self._answer, self._is_passed, self._done, self.voted
        drawn = (frame.plan, frame.theatre, frame.bent, resting, *place)
        if drawn != self._drawn:
            self._drawn = drawn
            self._write(frame, resting)
        if resting and self._pointed != (self._name, self._number):
            self._pointed = self._name, self._number
            if step.task is not None and (stage := _STAGE.search(step.task.text)):
                page.call(self._client, "showStage", int(stage[1]))

    @property
    def _step(self) -> Step | None:
        if self._name not in self._lessons:
            return None
        return self._lessons[self._name][0].steps[self._number]

    @property
    def _is_passed(self) -> bool:
        step = self._step
        nothing_to_do = step is not None and step.question is None and step.task is None
        return nothing_to_do or (self._name, self._number) in self._passed

    @property
    def _is_last(self) -> bool:
        """Whether the page is the lesson's last."""
        return self._number + 1 == len(self._lessons[self._name][0].steps)

    def _parse(self, text: str) -> tuple[str, int] | None:
        """Take what a kept text says was passed; lesson and page where it stands, or None."""
        try:
            data = json.loads(text)
            name, number = str(data["lesson"]), int(data["step"])
            passed = {(str(a), int(b)) for a, b in data["passed"]}
        except (ValueError, TypeError, KeyError, RecursionError):
            return None
        self._passed |= {(a, b) for a, b in passed if a in self._lessons}
        known = name in self._lessons and 0 <= number < len(self._lessons[name][0].steps)
        return (name, number) if known else None

    def _list(self) -> None:
        """List the lessons, which take longer to read than a frame."""
        self._lessons = self._library()
        self.choice.options = (_NONE, *self.titles)

    @property
    def titles(self) -> list[str]:
        """The lessons with their numbers, in order; none until they are listed."""
        return [
            f"{number}. {lesson.title}"
            for number, (lesson, _) in enumerate(self._lessons.values(), 1)
        ]

    def _title(self, name: str) -> str:
        return self.titles[list(self._lessons).index(name)]

    @property
    def _following(self) -> str:
        """The lesson after this one, or after the one finished last; empty behind the last."""
        names = list(self._lessons)
        name = self._name or self._finished
        place = names.index(name) + 1 if name in names else len(names)
        return names[place] if place < len(names) else ""

    def _is_done(self, name: str) -> bool:
        """Check whether all that a lesson asks was answered or done."""
        steps = self._lessons[name][0].steps
        asked = [k for k, one in enumerate(steps) if one.question or one.task]
        return bool(asked) and all((name, number) in self._passed for number in asked)

    def _cards(self) -> str:
        """The lessons to choose from, as HTML; the one to go on with stands out."""
        following = self._following
        entries = []
        for name, (lesson, _) in self._lessons.items():
            note = f"{lesson.minutes} minutes"
            if self._is_done(name):
                note += " · ✓ done"
            elif name == following:
                note += " · next"
            picture = assets.path("pictures", "lessons", f"{name}.webp")
            title = self._title(name)
            entries.append(Card(title, note, picture, name == following))
        return cards(self.choice, entries)

    def _take_presses(self) -> None:
        """Do what the student pressed or chose since the last call."""
        self.exercise.send_asked()
        titles = self.titles
        chosen = self.choice.value
        name = list(self._lessons)[titles.index(chosen)] if chosen in titles else ""
        if name != self._name:
            place, self._left = self._parse(self._left) if name else None, ""
            self._go(name, place[1] if place is not None and place[0] == name else 0)
        while self._pressed:
            self._take(self._pressed.pop(0))

    def _take(self, press: str) -> None:
        step = self._step
        if step is None:
            return
        if press == "back" and self._number > 0:
            self._go(self._name, self._number - 1)
        elif press == "next" and self._is_passed and not self._is_last:
            self._go(self._name, self._number + 1)
        elif press == "lesson" and self._is_passed and self._following:
            self._finished = self._name
            self._go(self._following, 0)
            self.choice.value = self._title(self._name)
        elif press == "leave":
            if self._is_passed and self._is_last:
                self._finished = self._name
            self.choice.value = _NONE
            self._go("", 0)
        elif press == "show" and step.task is not None:
            self._cue = step.task.shown_by
        elif press.isdigit() and step.question is not None and not self.voted:
            number = int(press)
            if number < len(step.question.choices):
                self._answer = number
                if step.question.choices[number].right and not self._done:
                    self._pass(step)

    def _go(self, name: str, number: int) -> None:
        """Turn to a page; no name ends the lesson."""
        self._ended |= bool(self._name) and not name
        self._name, self._number, self._answer, self._done = name, number, -1, False
        step = self._step
        self._cue = None if step is None else step.set

    def _pass(self, step: Step) -> None:
        """Reveal what the page has kept back."""
        self._passed.add((self._name, self._number))
        self._done = True
        # what sets nothing would still write the panels anew, in the middle of a drag
        self._cue = None if step.reveal == Setting() else step.reveal

    def _write(self, frame: Frame, resting: bool) -> None:
        """Write the page into the widgets; unless ``resting`` the plan may lack some numbers."""
        step, passed = self._step, self._is_passed
        for widget in (self._place, self._text, self.next, self.back):
            widget.visible = step is not None
        self.next_lesson.visible = False
        self._intro.visible = step is None
        if step is None:
            self.exercise.show(())
            for text in (self._question, self._stage, self._reply, self._after):
                text.visible = False
            for button in (self.show_me, *self.answers):
                button.visible = False
            return
        lesson = self._lessons[self._name][0]
        done = sum((self._name, number) in self._passed for number in range(len(lesson.steps)))
        asked = sum(one.question is not None or one.task is not None for one in lesson.steps)
        self._place.content = style.paragraph(
            f"<b>{self._number + 1} of {len(lesson.steps)}</b>, {done} of {asked} tasks done; "
            f"about {lesson.minutes} minutes in all"
        )
        self._show(self._text, step.text, frame)
        question, task = step.question, step.task
        asking = question.text if question is not None else ""
        if task is not None:
            asking = f"{'✓' if passed else '➜'} {task.text}"
            if not passed or task.is_done(frame):
                asking = f"{asking} {task.now}".strip()
            elif resting:
                asking += " *Done; it need not stay so.*"
        self._show(self._question, asking, frame)
        stage = _STAGE.search(task.text) if task is not None else None
        self._stage.visible = stage is not None
        self._stage.content = _to_stage(int(stage[1])) if stage is not None else ""
        choices = question.choices if question is not None else ()
        for number, button in enumerate(self.answers):
            button.visible = number < len(choices)
            button.disabled = self.voted
            if number < len(choices):
                button.label = self._label(choices[number], number)
        reply = ""
        if question is not None and self.voted:
            reply = _VOTED
        elif question is not None and 0 <= self._answer < len(choices):
            choice = choices[self._answer]
            reply = f"**{'✓ Right.' if choice.right else '✗ No.'}** {choice.why}"
        self._show(self._reply, reply, frame)
        # what it says is so once the page is done, and may not be when it is turned to again
        told = self._done or (question is None and task is None)
        self._show(self._after, step.after if told else "", frame)
        self.exercise.show(step.exercises if passed else ())
        self.show_me.visible = task is not None and not self._done
        self.next.disabled = not passed
        self.next.visible = not self._is_last
        if self._is_last and self._following:
            self.next_lesson.visible = True
            self.next_lesson.disabled = not passed
        self.back.disabled = self._number == 0

    def _label(self, choice: AnswerChoice, number: int) -> str:
        """Text of an answer's button; the one that was given has a sign before it."""
        if number != self._answer or self.voted:
            return choice.text
        return f"{'✓' if choice.right else '✗'} {choice.text}"

    def _show(self, widget: viser.GuiMarkdownHandle, text: str, frame: Frame) -> None:
        """Write a text with its numbers and formulas, or hide the widget where there is none."""
        widget.visible = bool(text)
        content = with_formulas(filled(text, frame)) if text else ""
        if widget.content != content:
            widget.content = content

    def _press(self, name: str, event: Any) -> None:
        self._pressed.append(name)
        self._wake(event)


def _to_stage(number: int) -> str:
    """Button that leads from a task to its stage on a phone, where one sheet has both."""
    return (
        '<div class="abi-phone" style="margin:0 8px 6px">'
        f'<button class="abi-go" data-stage="{number}">Go to stage {number}</button> '
        "“Back to lesson”, above the scene, leads here again.</div>"
    )
