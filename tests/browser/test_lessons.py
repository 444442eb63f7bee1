"""Lessons, walked through as a student does: first the wrong answers, then the right one."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
import pytest
from playwright.sync_api import Browser

from app.server.server import Server
from app.tab.session import Session
from app.teach.lesson import Step
from tests.browser.conftest import Tabs
from tests.browser.page import Page
from tests.shipped_lessons import LESSONS
from tests.thorough import of_each_kind

_KEPT = "() => localStorage.getItem('abi-lessons')"
_IS_TURNED = "() => document.documentElement.classList.contains('abi-turned')"


@pytest.fixture(scope="module")
def desk(chromium: Browser, server: Server) -> Iterator[Tabs]:
    """Where one student sits."""
    tabs = Tabs(chromium, server)
    yield tabs
    tabs.close()


@pytest.fixture(scope="module")
def student(desk: Tabs) -> Page:
    """A tab of its own for these lessons, one after the other, as in a class."""
    page = desk()
    page.click("Pause")
    return page


# all are gone through without a browser, in tests/app/teach
@pytest.mark.slow
@pytest.mark.parametrize("name", of_each_kind(LESSONS, *list(LESSONS)[::7]))
def test_a_student_walks_through(name: str, student: Page, server: Server) -> None:
    page, session = student, server.sessions[student.client]
    lesson = LESSONS[name][0]
    panel = session.panels.lessons
    page.click("Learn")
    page.until(lambda: len(panel.choice.options) > len(LESSONS), "the list of lessons")
    title = panel.progress.titles[list(LESSONS).index(name)]
    page.click(title)
    for number, step in enumerate(lesson.steps):
        page.reads(f"{number + 1} of {len(lesson.steps)}, ")
        _do(step, page, session)
        if number + 1 < len(lesson.steps):
            page.click("Next")
    _end(page)
    page.until(lambda: panel.choice.value == "choose a lesson", "the end of the lesson")


def _end(page: Page) -> None:
    """End a lesson by the button over the scene."""
    over = page.tab.locator("#abi-overlay")
    over.get_by_role("button", name="End lesson", exact=True).click()


def _do(step: Step, page: Page, session: Session) -> None:
    if step.question is not None:
        on = page.tab.get_by_role("button", name="Next", exact=True)
        assert not on.count() or on.is_disabled()  # the last page has none
        for choice in sorted(step.question.choices, key=lambda choice: choice.right):
            page.click(choice.text)
            page.reads("✓ Right." if choice.right else "✗ No.")
    if step.task is not None:
        page.click("Show me")
    panel = session.panels.lessons
    page.until(lambda: panel.progress.is_passed and not panel.waiting, "the step is done")
    page.until(lambda: session.resting, "rest")


def test_a_lesson_is_found_again_after_a_reload(student: Page, desk: Tabs, server: Server) -> None:
    page, session = student, server.sessions[student.client]
    panel = session.panels.lessons
    page.click("Learn")
    page.until(lambda: len(panel.choice.options) > len(LESSONS), "the list of lessons")
    page.click(panel.progress.titles[1])
    page.reads("Lesson 2 of ")
    page.until(lambda: session.resting, "rest")
    page.until(lambda: page.tab.evaluate(_KEPT) == panel.progress.kept, "the lesson to be kept")
    desk.reload(page)
    page.reads("Lesson 2 of ")
    assert page.is_open("Result")
    page.click("Back to lesson")
    page.until(lambda: page.is_open("Learn"), "the tab with the lesson")
    over = page.tab.locator("#abi-overlay").get_by_role("button", name="End lesson", exact=True)
    over.click()
    page.until(lambda: not server.sessions[page.client].frame.lesson, "the end of the lesson")


def test_a_drag_goes_on_when_it_has_done_the_task(student: Page, server: Server) -> None:
    page, session = student, server.sessions[student.client]
    panel = session.panels.lessons
    page.click("Learn")
    page.until(lambda: len(panel.choice.options) > len(LESSONS), "the list of lessons")
    page.click(panel.progress.titles[1])
    page.click("Straight through the plate")
    page.click("Next")
    page.reads("➜ Drag the plate")
    assert page.tab.evaluate(_IS_TURNED)  # what came under the pointer looks as all others do
    page.tab.mouse.move(600, 300)
    assert not page.tab.evaluate(_IS_TURNED)
    page.settle()
    gizmo = session.panels.obstacles.gizmos[0].name
    places = []

    def ticked() -> None:
        page.until(lambda: panel.progress.is_passed and session.resting, "the task to be done")
        places.append(page.position(gizmo))

    start = page.pixel(gizmo)
    end = start[0] - 200, start[1]
    page.drag(start, end, midway=ticked)
    page.until(lambda: session.resting, "rest")
    assert np.linalg.norm(np.subtract(page.position(gizmo), places[0])) > 1
    assert page.pixel(gizmo) == pytest.approx(end, abs=12)
    page.click("Undo")  # where the task is not done, no number stands beside its tick
    page.reads("✓ Drag the plate")
    page.reads("it need not stay so")
    assert " do." not in page.text().split("✓ Drag the plate")[1].split("need not")[0]
    _end(page)


def test_the_stage_that_a_task_speaks_of_comes_into_sight(student: Page, server: Server) -> None:
    page, panel = student, server.sessions[student.client].panels.lessons
    page.tab.set_viewport_size({"width": 1280, "height": 480})
    page.click("Learn")
    page.until(lambda: len(panel.choice.options) > len(LESSONS), "the list of lessons")
    page.click(panel.progress.titles[0])
    page.click("They are removed")
    page.reads("✓ Right.")
    page.settle()
    heading = page.tab.get_by_text(re.compile("^1 · Mesh")).first
    page.tab.mouse.move(150, 300)
    page.tab.mouse.wheel(0, 2000)
    page.until(lambda: heading.bounding_box()["y"] < 0, "the heading to leave")  # type: ignore[index]
    page.click("Next")
    page.until(lambda: heading.bounding_box()["y"] > 0, "the heading", 20)  # type: ignore[index]
    page.tab.set_viewport_size({"width": 1280, "height": 720})
    _end(page)
