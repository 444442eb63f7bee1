from __future__ import annotations

import asyncio
import json
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest

from app.panels.teach.classroom import ClassroomPanel
from app.panels.teach.poll_text import bars
from app.server.server import Server, start
from app.state.appearance import PLAIN
from app.tab.session import Session
from app.teach.classroom import Classroom
from app.teach.poll import MAX_CHOICES
from benchmarks.classroom import follow
from benchmarks.tabs import SCENE
from tests.app.fake_tab import FakeTab, until


@pytest.fixture(scope="module")
def room() -> Iterator[tuple[Server, Classroom]]:
    classroom = Classroom()
    running = start(port=0, scene="paper", classroom=classroom, look=PLAIN)
    yield running, classroom
    running.stop()


def open_tab(server: Server, teach: str = "") -> tuple[FakeTab, Session]:
    known = set(server.sessions)
    fake = FakeTab(server.url)
    until(lambda: bool(set(server.sessions) - known))
    session = server.sessions[next(iter(set(server.sessions) - known))]
    query = {"teach": teach} if teach else {}
    report = json.dumps({"state": "", "query": query, "dark": False})
    fake.set(session._memory._box, report)
    until(lambda: session.plan is not None)
    return fake, session


def panel(session: Session) -> ClassroomPanel:
    assert session._view.classroom is not None
    return session._view.classroom


def over_scene(session: Session) -> str:
    return session.panels.layout.overlay.shown.get("class", "")


@pytest.mark.slow
def test_a_class_follows_works_alone_and_answers(room: tuple[Server, Classroom]) -> None:
    server, classroom = room
    teacher, taught = open_tab(server, classroom.secret)
    students = [open_tab(server) for _ in range(3)]
    until(lambda: panel(taught).teaches)
    assert not any(panel(session).teaches for _, session in students)
    assert classroom.students == 3

    # followed, unless a student works on his own
    alone, free = students[2]
    alone.set(panel(free).follow, False)
    until(lambda: not panel(free).follow.value)
    teacher.set(panel(taught).lead, True)
    teacher.set(taught.panels.stages.fields["mesh.pitch"], 1.1)
    for _, session in students[:2]:
        until(lambda session=session: session.frame.plan.scene.mesh.pitch == 1.1)  # type: ignore[misc]
    teacher.set(panel(taught).lead, False)
    until(lambda: taught.resting)
    assert free.frame.plan.scene.mesh.pitch == 1.3

    # asked and counted, the last answer of each
    teacher.set(panel(taught).asking.question, "Which <b>?")
    for box, text in zip(panel(taught).asking.choices, ("one", "two"), strict=False):
        teacher.set(box, text)
    teacher.set(panel(taught).asking.right, "answer 2")
    teacher.set(panel(taught).asking.ask_own, True)
    for _, session in students:
        until(lambda session=session: panel(session).answers[1].visible)  # type: ignore[misc]
        # over the scene, too, where it is seen from every tab of the panel
        until(lambda session=session: "Which &lt;b&gt;?" in over_scene(session))  # type: ignore[misc]
    assert not over_scene(taught)
    for (fake, session), choice in zip(students, (0, 1, 1), strict=True):
        fake.set(panel(session).answers[choice], True)
        until(lambda session=session: not over_scene(session))  # type: ignore[misc]
    until(lambda: classroom.counts() == (1, 2))
    students[0][0].set(panel(students[0][1]).answers[1], True)
    until(lambda: classroom.counts() == (0, 3))
    until(lambda: "3 of 3 have answered" in panel(taught)._text.content)
    assert "<b>?" not in panel(taught)._text.content
    # nobody's answer is seen before all are
    assert "two" not in panel(taught)._text.content
    teacher.set(panel(taught).asking.reveal, True)
    until(lambda: "✓ two: <b>3</b>" in panel(taught)._text.content)
    assert "Right: 100 %" in panel(taught)._text.content
    for _, session in students:
        until(lambda session=session: "two: <b>3</b>" in panel(session)._text.content)  # type: ignore[misc]
        assert not panel(session).answers[0].visible

    # a second round hides them again
    teacher.set(panel(taught).asking.again, True)
    until(lambda: panel(students[1][1]).answers[1].visible)
    assert classroom.counts() == (0, 0)
    assert "two: <b>3</b>" not in panel(taught)._text.content
    for fake, session in students:
        fake.set(panel(session).answers[0], True)
    until(lambda: "3 of 3 have answered" in panel(taught)._text.content)
    assert not panel(taught).asking.again.visible
    teacher.set(taught.panels.lecture.toggle, True)
    until(lambda: "3 of 3 have answered" in over_scene(taught))

    for fake, _ in (*students, (teacher, taught)):
        fake.close()
    until(lambda: classroom.students == 0)
    # tabs that no browser has named cannot be recognised again
    assert classroom.counts() == (0, 0)
    classroom.close_poll()
    assert classroom.poll is None


def test_only_the_secret_makes_a_teacher(room: tuple[Server, Classroom]) -> None:
    server, classroom = room
    fake, session = open_tab(server, "guess")
    assert not panel(session).teaches
    shown = classroom.view
    fake.set(panel(session).send, True)
    until(lambda: session.resting)
    assert classroom.view == shown
    fake.close()
    assert not classroom.is_teacher("")
    assert not classroom.is_teacher("ä")
    assert classroom.is_teacher(classroom.secret)


@pytest.mark.slow
def test_a_student_takes_the_teachers_plan_and_undo_brings_back_the_own_work(
    room: tuple[Server, Classroom],
) -> None:
    server, classroom = room
    teacher, taught = open_tab(server, classroom.secret)
    student, session = open_tab(server)
    until(lambda: panel(taught).teaches)
    student.set(session.panels.stages.fields["mesh.pitch"], 1.2)
    until(lambda: session.resting and session.frame.plan.scene.mesh.pitch == 1.2)
    gizmos = list(session.panels.obstacles.gizmos)
    teacher.set(panel(taught).lead, True)
    for x in (1.0, 1.5, 2.0):
        teacher.drag(taught.panels.obstacles.gizmos[0], [x, 3.0, 3.0])
        until(lambda x=x: session.frame.plan.scene.obstacles[0].position[0] == x)  # type: ignore[misc]
    until(lambda: taught.resting and session.resting)
    # planned once for all, and what is in place stays there
    assert session.frame.plan is taught.frame.plan
    assert session.panels.obstacles.gizmos == gizmos
    teacher.set(panel(taught).lead, False)
    student.set(session.panels.history.undo, True)
    until(lambda: session.frame.plan.scene.mesh.pitch == 1.2)
    for fake in (teacher, student):
        fake.close()
    until(lambda: classroom.students == 0)


def test_a_teachers_secret_can_outlast_the_server() -> None:
    assert Classroom("mine").is_teacher("mine")
    assert not Classroom("mine").is_teacher("")
    assert not Classroom().is_teacher(Classroom().secret)


def test_a_question_needs_two_answers_and_counts_its_own() -> None:
    classroom = Classroom()
    woken: list[int] = []
    classroom.join(1, lambda: woken.append(1))
    assert not classroom.ask("Why?", ("one", " ", "", ""))
    assert not classroom.ask(" ", ("one", "two"))
    assert classroom.poll is None
    assert classroom.counts() == ()
    assert classroom.ask("Why?", ("one", "two", "three", "four", "five"))
    assert classroom.poll is not None
    assert len(classroom.poll.choices) == MAX_CHOICES
    classroom.answer(1, classroom.poll.number, 9)
    classroom.answer(1, classroom.poll.number + 1, 1)
    assert classroom.counts() == (0, 0, 0, 0)
    classroom.answer(1, classroom.poll.number, 2)
    assert classroom.counts() == (0, 0, 1, 0)
    assert classroom.answer_of(1) == 2
    assert classroom.ask("And now?", ("a", "b"))
    assert classroom.counts() == (0, 0)
    # students need not know how the others answer
    assert len(woken) == 2
    # a bar is as long as its part of those who answered
    assert "width:100%" in bars(("a", "b"), (0, 2), 2)
    assert bars(("a", "b"), (1, 1), 2).count("width:50%") == 2


def test_all_tabs_of_a_student_have_one_answer() -> None:
    classroom = Classroom()
    woken: list[int] = []
    for tab, student in enumerate(("a", "a", "b", "", "")):
        classroom.join(tab, lambda tab=tab: woken.append(tab))  # type: ignore[misc]
        classroom.recognise(tab, student)
    classroom.teach(4, lambda: woken.append(4))
    assert classroom.ask("Why?", ("one", "two"))
    woken.clear()
    for tab, choice in ((0, 0), (2, 0), (1, 1), (3, 1)):
        classroom.answer(tab, 1, choice)
    # a's last answer in either tab, b's, and that of a tab which says no name
    assert classroom.counts() == (1, 2)
    assert [classroom.answer_of(tab) for tab in range(4)] == [1, 1, 0, 1]
    assert classroom.students == 3
    # the teacher sees each, and a student's other tab what was answered in this one
    assert sorted(woken) == [0, 1, 4, 4, 4, 4]
    classroom.leave(0)
    assert classroom.counts() == (1, 2)
    classroom.leave(1)
    # a student who reloads or leaves has answered all the same
    assert classroom.counts() == (1, 2)
    assert classroom.students == 2
    assert classroom.taking_part == 3
    # one that says only later who it is does not count twice
    classroom.recognise(3, "b")
    assert classroom.counts() == (1, 1)
    classroom.recognise(9, "b")
    assert classroom.students == 1


@pytest.mark.slow
def test_every_student_sees_what_the_teacher_moves_and_every_answer_counts() -> None:
    classroom = Classroom()
    server = start(port=0, scene=SCENE, classroom=classroom, look=PLAIN)
    work = follow(server.url, classroom.secret, tabs=4, moves=2, settle=0.5, pause=0.2)
    try:
        # in a thread of its own: browser tests leave a loop running in the main one
        with ThreadPoolExecutor(1) as pool:
            result = pool.submit(asyncio.run, work).result()
    finally:
        server.stop()
    assert result["wrong"] == 0
    assert result["answers"]
