"""Check of lessons: goes through every page and reports all faults at once."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from pathlib import Path

from abi.errors import BLOCKED, AbiError
from abi.planner.planner import Planner
from app.state.frame import Frame
from app.teach.lesson import Lesson, Step
from app.teach.lesson_file import (
    LessonFault,
    Place,
    fault_at,
    lesson_files,
    read_lesson,
    unknown_layers,
)
from app.teach.measures import MEASURES, names_in
from app.teach.measures import text as now
from app.teach.rehearsal import Take, rehearsal

_SINGLE = re.compile(r"(?<!\{)\{\s*([a-z_]+\.[a-z_.0-9]+)\s*\}(?!\})")
_NOTHING = "–"


def check_folder(folder: Path, layers: Collection[str]) -> tuple[LessonFault, ...]:
    """All faults in the lessons of a folder, by file and line.

    Each page's scene is planned; what its texts quote must exist there, a task must not be done
    before it is begun, and its ``shown_by`` must do it.

    Args:
        folder: of lessons and the scenes that they name.
        layers: names that ``shown`` may have.

    Raises:
        AbiError: the folder has no lesson.
    """
    faults: set[LessonFault] = set()
    for file in lesson_files(folder):
        lesson, found = read_lesson(file)
        faults |= set(found)
        if lesson is not None:
            faults |= {*unknown_layers(file, lesson, layers), *check_pages(file, lesson)}
    return tuple(sorted(faults))


def check_pages(file: Path, lesson: Lesson) -> Iterator[LessonFault]:
    """Faults that show when the pages of a lesson are gone through in order."""
    take = rehearsal(file.parent, Planner())
    for number, step in enumerate(lesson.steps):
        yield from _check_page(file, ("steps", number), step, take)


def _check_page(file: Path, page: tuple[str, int], step: Step, take: Take) -> Iterator[LessonFault]:
    """Faults of one page, in the order in which a student would meet them."""
    try:
        frame = take(step.set)
    except AbiError as error:
        yield fault_at(file, (*page, "set"), error.message)
        return
    fault = frame.plan.error
    if fault is not None and fault.kind in BLOCKED:
        yield fault_at(file, (*page, "set"), fault.message, doubtful=True)
    yield from _check_texts(file, _texts_before(page, step), frame)
    if step.task is not None:
        task, place = step.task, (*page, "task")
        if task.is_done(frame):
            yield fault_at(file, (*place, "until"), "it is met before anything is done.")
        try:
            frame = take(task.shown_by)
        except AbiError as wrong:
            yield fault_at(file, (*place, "shown_by"), wrong.message)
        for missed in (one for one in task.until if not one.holds(frame)):
            yield fault_at(
                file, (*place, "shown_by"), f"it does not do the task: {missed.missed(frame)}."
            )
    try:
        frame = take(step.reveal)
    except AbiError as wrong:
        yield fault_at(file, (*page, "reveal"), wrong.message)
    yield from _check_texts(file, _texts_after(page, step), frame)


def _texts_before(page: Place, step: Step) -> Iterator[tuple[Place, str]]:
    """Texts shown before the page is passed, with their locations."""
    yield (*page, "text"), step.text
    if step.task is not None:
        yield (*page, "task", "text"), step.task.text
        yield (*page, "task", "now"), step.task.now
    if step.question is not None:
        yield (*page, "question", "text"), step.question.text
        for number, choice in enumerate(step.question.choices):
            place = (*page, "question", "choices", number)
            yield (*place, "text"), choice.text
            if not choice.right:
                yield (*place, "why"), choice.why


def _texts_after(page: Place, step: Step) -> Iterator[tuple[Place, str]]:
    """Texts shown after the page is passed, with their locations."""
    yield (*page, "after"), step.after
    for number, choice in enumerate(step.question.choices if step.question else ()):
        if choice.right:
            yield (*page, "question", "choices", number, "why"), choice.why


def _check_texts(
    file: Path, texts: Iterator[tuple[Place, str]], frame: Frame
) -> Iterator[LessonFault]:
    """Faults of the measures that texts quote."""
    for place, content in texts:
        for name in names_in(content):
            if now(name, frame) == _NOTHING:
                yield fault_at(file, place, f"{name} has no value here, so it reads “–”.")
        for name in _SINGLE.findall(content):
            if name in MEASURES:
                yield fault_at(file, place, f"a number needs two braces: {{{{{name}}}}}.")
