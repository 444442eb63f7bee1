"""The lesson player: pages, questions before the answer, tasks that wait for the student."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from typing import Any

import viser

from abi import assets
from abi.errors import SceneError
from abi.scene.scene import Scene
from app.panels.teach.exercise_start import add_exercise_buttons, send_asked
from app.panels.widgets import Wake
from app.state.frame import Frame
from app.teach.lesson import (
    NO_LESSONS,
    AnswerChoice,
    Library,
    Setting,
    Step,
    scene_of,
)
from app.teach.lesson_progress import LessonProgress
from app.teach.measures import filled
from app.ui import notices, page, style
from app.ui.cards import card, cards
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
    """Widgets of the player.

    Attributes:
        progress: where the student is.
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
        self._library = library
        self.progress = LessonProgress()
        self._left = ""
        self.voted = False
        self._cue: Setting | None = None
        self._ended = False
        self._pressed: list[str] = []
        self._drawn: tuple[object, ...] = ()
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
        self.exercises = add_exercise_buttons(gui, wake)
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
    def waiting(self) -> bool:
        """Whether there is a cue to follow."""
        return self._cue is not None

    def restore(self, text: str) -> None:
        """Go on where a kept text says; ignore one that says nothing of these lessons."""
        if not text or text == self.progress.kept:
            return
        if self.progress.lessons is NO_LESSONS:
            self._list()
        if place := self.progress.take(text):
            self.progress.name, self.progress.number = place
            self.progress.done = place in self.progress.passed  # with all that was revealed
            self.choice.value = self.progress.title(self.progress.name)

    def follow(self, text: str) -> bool:
        """Go where the teacher is; whether that ended a lesson, without a scene to go back to."""
        self.restore(text)
        if not self.progress.chosen or self.progress.take(text) is not None:
            return False
        self._go("", 0)
        self._ended = False
        self.choice.value = _NONE
        return True

    def recall(self, text: str) -> None:
        """Take over what was passed in tabs that are closed; its lesson goes on where it stood."""
        self._left = text

    def cue(self, scene: Scene) -> tuple[Setting, Scene] | None:
        """Setting of the lesson now and its scene, from ``scene`` on; None for none."""
        self._take_presses()
        if self._cue is None:
            return None
        setting, self._cue = self._cue, None
        folder = self.progress.lessons[self.progress.name][1]
        try:
            return setting, scene_of(setting, scene, folder)
        except SceneError as error:
            notices.notify_refusal(self._client, "The lesson cannot change this", error.message)
            return None

    def left(self) -> bool:
        """Check whether a lesson was finished, or left, since the last call."""
        ended, self._ended = self._ended, False
        return ended

    def draw(self, frame: Frame) -> None:
        """Show the page with the frame's numbers; go on where its task is done."""
        progress = self.progress
        resting = not (frame.interactive or frame.plan.partial or not frame.current)
        if resting and progress.lessons is NO_LESSONS:
            self._list()
        step = progress.step
        if (
            step is not None
            and step.task is not None
            and not progress.done
            and resting
            and self._cue is None
            and step.task.is_done(frame)
            and (step.reveal == Setting() or not self._held())
        ):
            self._pass(step)
        if step is None:
            state = progress.lessons is NO_LESSONS, progress.finished, len(progress.passed)
            if state != self._drawn:
                self._drawn = state
                self._write(frame, resting)
                self._intro.content = _INTRO + self._cards()
            return
        place = progress.name, progress.number, progress.answer, progress.is_passed, progress.done
        drawn = (frame.plan, frame.theatre, frame.bent, resting, self.voted, *place)
        if drawn != self._drawn:
            self._drawn = drawn
            self._write(frame, resting)
        if resting and self._pointed != (progress.name, progress.number):
            self._pointed = progress.name, progress.number
            if step.task is not None and (stage := _STAGE.search(step.task.text)):
                page.call(self._client, "showStage", int(stage[1]))

    def _list(self) -> None:
        """List the lessons, which take longer to read than a frame."""
        self.progress.lessons = self._library()
        self.choice.options = (_NONE, *self.progress.titles)

    def _cards(self) -> str:
        """The lessons to choose from, as HTML; the one to go on with stands out."""
        following = self.progress.following
        entries = []
        for name, (lesson, _) in self.progress.lessons.items():
            note = f"{lesson.minutes} minutes"
            if self.progress.is_complete(name):
                note += " · ✓ done"
            elif name == following:
                note += " · next"
            picture = assets.path("pictures", "lessons", f"{name}.webp")
            title = self.progress.title(name)
            entries.append(card(self.choice, title, note, picture, name == following))
        return cards(entries)

    def _take_presses(self) -> None:
        """Do what the student pressed or chose since the last call."""
        send_asked(self._client, self.exercises, self.progress.exercises)
        titles = self.progress.titles
        chosen = self.choice.value
        name = list(self.progress.lessons)[titles.index(chosen)] if chosen in titles else ""
        if name != self.progress.name:
            place, self._left = self.progress.take(self._left) if name else None, ""
            self._go(name, place[1] if place is not None and place[0] == name else 0)
        while self._pressed:
            self._take(self._pressed.pop(0))

    def _take(self, press: str) -> None:
        progress = self.progress
        step = progress.step
        if step is None:
            return
        if press == "back" and progress.number > 0:
            self._go(progress.name, progress.number - 1)
        elif press == "next" and progress.is_passed and not progress.is_last:
            self._go(progress.name, progress.number + 1)
        elif press == "lesson" and progress.is_passed and progress.following:
            progress.finished = progress.name
            self._go(progress.following, 0)
            self.choice.value = progress.title(progress.name)
        elif press == "leave":
            if progress.is_passed and progress.is_last:
                progress.finished = progress.name
            self.choice.value = _NONE
            self._go("", 0)
        elif press == "show" and step.task is not None:
            self._cue = step.task.shown_by
        elif press.isdigit() and step.question is not None and not self.voted:
            number = int(press)
            if number < len(step.question.choices):
                progress.answer = number
                if step.question.choices[number].right and not progress.done:
                    self._pass(step)

    def _go(self, name: str, number: int) -> None:
        """Turn to a page; no name ends the lesson."""
        self._ended |= bool(self.progress.name) and not name
        self.progress.turn_to(name, number)
        step = self.progress.step
        self._cue = None if step is None else step.set

    def _pass(self, step: Step) -> None:
        """Reveal what the page has kept back."""
        self.progress.pass_page()
        # what sets nothing would still write the panels anew, in the middle of a drag
        self._cue = None if step.reveal == Setting() else step.reveal

    def _write(self, frame: Frame, resting: bool) -> None:
        """Write the page into the widgets; unless ``resting`` the plan may lack some numbers."""
        progress = self.progress
        step, passed = progress.step, progress.is_passed
        for widget in (self._place, self._text, self.next, self.back):
            widget.visible = step is not None
        self.next_lesson.visible = False
        self._intro.visible = step is None
        for button in self.exercises.values():
            button.visible = bool(progress.exercises)
        if step is None:
            for text in (self._question, self._stage, self._reply, self._after):
                text.visible = False
            for button in (self.show_me, *self.answers):
                button.visible = False
            return
        lesson, done = progress.lesson, progress.passed_pages
        asked = sum(one.question is not None or one.task is not None for one in lesson.steps)
        self._place.content = style.paragraph(
            f"<b>{progress.number + 1} of {len(lesson.steps)}</b>, {done} of {asked} tasks done; "
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
        elif question is not None and 0 <= progress.answer < len(choices):
            choice = choices[progress.answer]
            reply = f"**{'✓ Right.' if choice.right else '✗ No.'}** {choice.why}"
        self._show(self._reply, reply, frame)
        # what it says is so once the page is done, and may not be when it is turned to again
        told = progress.done or (question is None and task is None)
        self._show(self._after, step.after if told else "", frame)
        self.show_me.visible = task is not None and not progress.done
        self.next.disabled = not passed
        self.next.visible = not progress.is_last
        if progress.is_last and progress.following:
            self.next_lesson.visible = True
            self.next_lesson.disabled = not passed
        self.back.disabled = progress.number == 0

    def _label(self, choice: AnswerChoice, number: int) -> str:
        """Text of an answer's button; the one that was given has a sign before it."""
        if number != self.progress.answer or self.voted:
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
