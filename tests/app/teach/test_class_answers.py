"""A class's answers: rounds, what outlasts a reload and a killed server, places, and results."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.panels.teach.poll_text import question_text
from app.server.server import start
from app.state.appearance import PLAIN
from app.tab.session import Session
from app.teach.class_table import table
from app.teach.classroom import Classroom
from app.teach.poll import Poll
from tests.app.fake_tab import FakeTab, until
from tests.app.teach.test_classroom import open_tab, over_scene, panel

_POLL = Poll(
    1,
    "Why?",
    ("one", "two"),
    right=1,
    why="Because.",
    lesson="Lesson 1",
    asked_at="2026-11-27T12:00:00+00:00",
)


def rows(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def test_votes_settings_and_words_outlast_a_server_that_is_killed(tmp_path: Path) -> None:
    file = tmp_path / "record"
    before = Classroom("mine", file)
    before.join(1, print)
    before.recognise(1, "a")
    before.name(1, "heron")
    before.set(True, ("draft", "x", "y"))
    before.ask("Why?", ("one", "two"), right=1)
    before.answer(1, 1, 1)
    before.reveal()
    before.ask_again()
    before.answer(1, 1, 0)

    after = Classroom("mine", tmp_path / "record")  # nothing was closed
    assert after.poll == before.poll
    assert after.counts() == (1, 0)
    assert (after.lead, after.draft) == (True, ("draft", "x", "y"))
    after.join(7, print)
    after.recognise(7, "a")
    assert after.answer_of(7) == 0
    assert after.word(7) == "heron"
    after.ask("And now?", ("a", "b"))
    assert after.poll is not None
    assert after.poll.number == 2
    after.end()
    assert not (tmp_path / "record").exists()
    assert Classroom("mine", tmp_path / "record").poll is None


def test_results_that_are_kept_are_a_table_for_spreadsheets(tmp_path: Path) -> None:
    target = tmp_path / "results.csv"
    classroom = Classroom("mine", results=target)
    for tab, student in enumerate("ab"):
        classroom.join(tab, print)
        classroom.recognise(tab, student)
    classroom.name(0, "=1+1")
    classroom.ask("Why?", ("one", "two"), right=1)
    classroom.answer(0, 1, 1)
    classroom.answer(1, 1, 0)
    classroom.ask_place("Where?", ((1.0, 2.0, 3.0),))
    classroom.answer(1, 2, (1.0, 2.0, 3.0))
    classroom.end()
    found = rows(target.read_text(encoding="utf-8-sig"))
    assert [row["student"] for row in found] == ["'=1+1", "student 2", "student 2"]
    assert [row["answer"] for row in found] == ["two", "one", "(1, 2, 3)"]
    assert [row["right"] for row in found] == ["yes", "no", "yes"]
    # and the class goes on with it
    assert Classroom(None, results=target).poll == classroom.poll


def test_a_damaged_record_is_none(tmp_path: Path) -> None:
    (tmp_path / "record").write_bytes(b'{"asked": 3}')
    assert Classroom("mine", tmp_path / "record").poll is None


@given(
    st.lists(st.integers(0, 1), min_size=1, max_size=9),
    st.lists(st.integers(0, 1), min_size=1, max_size=9),
)
def test_the_gain_is_the_part_of_what_was_missing(first: list[int], second: list[int]) -> None:
    rounds = tuple(
        {f"student {k}": answer for k, answer in enumerate(answers)} for answers in (first, second)
    )
    asked = replace(_POLL, rounds=rounds, revealed=True)
    missing = first.count(0) / len(first)
    gain = asked.gain
    if missing == 0:
        assert gain is None
    else:
        assert gain is not None
        reached = first.count(1) / len(first) + gain * missing
        assert math.isclose(reached, second.count(1) / len(second), abs_tol=1e-12)
    written = rows(table([asked], {}))
    assert len(written) == len(first) + len(second)
    assert all(
        (row["lesson"], row["asked at"]) == (_POLL.lesson, _POLL.asked_at) for row in written
    )


def test_nothing_is_told_before_it_is_revealed() -> None:
    hidden = replace(_POLL, rounds=({"student a": 1},))
    told = question_text(hidden, 2, answered=True)
    assert "1 of 2 have answered" in told
    assert not {"two", "Because", "✓", "Right"} & set(told.replace(".", " ").split())
    shown = question_text(replace(hidden, revealed=True), 2, answered=True)
    assert "✓ two: <b>1</b>" in shown
    assert "Because." in shown
    for revealed in (False, True):
        second = replace(hidden, rounds=(*hidden.rounds, {}), revealed=revealed)
        assert ("answer again" in question_text(second, 2, answered=True)) is not revealed


def test_what_is_no_answer_is_not_counted() -> None:
    classroom = Classroom()
    classroom.join(1, print)
    classroom.ask("Why?", ("one", "two"))
    classroom.answer(1, 1, (0.0, 0.0, 0.0))
    assert classroom.answer_of(1) is None
    classroom.ask_place("Where?")
    classroom.answer(1, 2, 1)
    classroom.answer(1, 2, (math.nan, 0.0, 0.0))
    assert classroom.answer_of(1) is None


@pytest.mark.slow
def test_places_that_students_click_are_balls_in_the_teachers_scene() -> None:
    classroom = Classroom()
    server = start(port=0, scene="paper", classroom=classroom, look=PLAIN)
    try:
        teacher, taught = open_tab(server, classroom.secret)
        students = [open_tab(server) for _ in range(3)]
        until(lambda: panel(taught).teaches)
        teacher.set(panel(taught).asking.ask_place, True)
        until(lambda: not panel(taught).asking.ask_place.value)
        assert classroom.poll is None  # there was no question
        teacher.set(panel(taught).asking.question, "Where will the path pass?")
        teacher.set(panel(taught).asking.ask_place, True)
        until(lambda: classroom.poll is not None)
        graph = taught.frame.plan.graph
        assert graph is not None
        targets = [graph.start, graph.goal, graph.goal]
        for (fake, session), target in zip(students, targets, strict=True):
            until(lambda session=session: "Click or tap a node" in panel(session)._text.content)  # type: ignore[misc]
            click(fake, graph.points[target])
        until(lambda: "3 of 3 have answered" in panel(taught)._text.content)
        assert not balls(taught)
        assert [len(balls(session)) for _, session in students] == [1, 1, 1]

        teacher.set(panel(taught).asking.reveal, True)
        until(lambda: len(balls(taught)) == 2)
        assert sorted(balls(taught)) == sorted({tuple(graph.points[t].tolist()) for t in targets})
        # what is answered after that is seen at once, where none is told to be right
        click(students[0][0], graph.points[graph.goal])
        until(lambda: len(balls(taught)) == 1)
        teacher.set(panel(taught).asking.close_poll, True)
        until(lambda: not balls(taught))
    finally:
        server.stop()


@pytest.mark.slow
def test_the_next_node_of_a_lessons_search_is_voted_on_without_being_told() -> None:
    classroom = Classroom()
    server = start(port=0, scene="paper", classroom=classroom, look=PLAIN)
    try:
        teacher, taught = open_tab(server, classroom.secret)
        students = [open_tab(server) for _ in range(2)]
        until(lambda: panel(taught).teaches)
        teacher.set(panel(taught).lead, True)
        until(lambda: taught.resting and len(taught.panels.lessons.progress.titles) > 2)
        teacher.set(taught.panels.lessons.choice, taught.panels.lessons.progress.titles[2])
        both = [session for _, session in students]
        for one in (taught, *both):
            until(lambda one=one: step_of(one) == 24 and one.resting)  # type: ignore[misc]
            assert one.panels.theatre.ask.value
        assert all(session.panels.lessons.progress.chosen for session in both)
        teacher.set(panel(taught).asking.ask_next, True)
        (student, session), (_, second) = students
        for one in (taught, *both):
            until(lambda one=one: one.frame.theatre.voted)  # type: ignore[misc]
        assert session.frame.theatre is not None
        state = session.frame.theatre.state
        points = state.trace.arcs.points
        assert classroom.poll is not None
        assert classroom.poll.places == (tuple(points[state.following].tolist()),)

        # neither a click, nor a key, nor the lesson tells it
        assert session.panels.lessons.answers[1].disabled
        click(student, points[state.following])
        until(lambda: classroom.answer_of(session.client.client_id) is not None)
        assert classroom.poll.right_share() == 1
        wrong = points[next(node for node in state.open if node != state.following)]
        for fake, one in students:
            fake.set(one.panels.lessons.answers[1], True)
            one.panels.theatre.go(1, None)
            fake.set(one.panels.theatre.step, 30)
            click(fake, wrong)  # what is sent after that is read after that
        chosen = 2 * [tuple(wrong.tolist())]
        until(lambda: classroom.poll is not None and [*classroom.poll.answers.values()] == chosen)
        for _, one in students:
            until(lambda one=one: one.panels.theatre.step.value == 24 and one.resting)  # type: ignore[misc]
            theatre = one.frame.theatre
            assert theatre is not None
            assert (theatre.state.step, theatre.ringed.size, theatre.said) == (24, 0, "")
            assert one.panels.lessons.progress.asks

        # a right node that nobody has hit is marked, too
        assert classroom.poll.right_share() == 0
        assert classroom.poll.places[0] not in balls(taught)
        teacher.set(panel(taught).asking.reveal, True)
        for one in (taught, *both):
            until(lambda one=one: classroom.poll.places[0] in balls(one))  # type: ignore[misc]
        until(lambda: not session.panels.lessons.answers[1].disabled)
        classroom.answer(session.client.client_id, classroom.poll.number, classroom.poll.places[0])
        assert classroom.poll.right_share() == 0  # who has been told the answer gives none
        assert step_of(session) == 24
        teacher.set(panel(taught).asking.close_poll, True)
        until(lambda: classroom.poll is None)
        click(student, points[state.following])
        until(lambda: step_of(session) == 25)

        # who follows leaves the lesson with the teacher
        teacher.set(taught.panels.lessons.leave, True)
        until(lambda: not any(one.panels.lessons.progress.chosen for one in (taught, *both)))
        until(lambda: second.resting and second.frame.plan.scene == taught.frame.plan.scene)
        assert not over_scene(second)
    finally:
        server.stop()


def step_of(session: Session) -> int:
    theatre = session.frame.theatre
    return -1 if theatre is None else theatre.state.step


@pytest.mark.slow
def test_who_follows_again_is_back_and_a_reloaded_teacher_goes_on() -> None:
    classroom = Classroom()
    server = start(port=0, scene="paper", classroom=classroom, look=PLAIN)
    try:
        teacher, taught = open_tab(server, classroom.secret)
        student, session = open_tab(server)
        until(lambda: panel(taught).teaches)
        teacher.set(taught.panels.stages.fields["mesh.pitch"], 1.1)
        teacher.set(panel(taught).asking.question, "Draft?")
        teacher.set(panel(taught).asking.right, "answer 2")
        teacher.set(panel(taught).lead, True)
        until(lambda: session.frame.plan.scene.mesh.pitch == 1.1)
        student.set(panel(session).follow, False)
        student.set(session.panels.stages.fields["mesh.pitch"], 1.25)
        until(lambda: session.resting and session.frame.plan.scene.mesh.pitch == 1.25)
        student.set(panel(session).follow, True)
        until(lambda: session.frame.plan.scene.mesh.pitch == 1.1, 10)

        teacher.close()
        until(lambda: len(server.sessions) == 1)
        _, again = open_tab(server, classroom.secret)
        until(lambda: panel(again).teaches and bool(panel(again).lead.value))
        asking = panel(again).asking  # its boxes are filled one after the other
        until(lambda: (asking.question.value, asking.right.value) == ("Draft?", "answer 2"))
        until(lambda: again.frame.plan.scene.mesh.pitch == 1.1)
        assert session.frame.plan.scene.mesh.pitch == 1.1
    finally:
        server.stop()


def click(fake: FakeTab, target: object) -> None:
    """Click at a place of the scene, from above."""
    place = np.asarray(target, float)
    direction = np.array([0.2, 0.3, -0.93])
    direction /= np.linalg.norm(direction)
    fake.click(place - 30.0 * direction, direction)


def balls(session: Session) -> list[tuple[float, ...]]:
    return [place for place, *_ in tuple(panel(session)._balls)]  # which the tab may change
