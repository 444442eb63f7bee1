"""Practice: streaks, mastery, quizzes, and what comes back after a reload."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from abi.teach.quiz.templates import question, templates
from app.server.server import start
from app.state.appearance import PLAIN
from app.teach.practice import MASTERY, Practice, decoded, quiz
from tests.app.fake_tab import opened, until

_NAMES = list(templates())


def right(practice: Practice) -> Practice:
    assert practice.question is not None
    return practice.answered(practice.question.right)


def wrong(practice: Practice) -> Practice:
    asked = practice.question
    assert asked is not None
    return practice.answered((asked.right + 1) % len(asked.choices))


def test_five_in_a_row_are_mastery_and_an_error_begins_again() -> None:
    practice = Practice().begun(["duration"])
    for _ in range(MASTERY - 1):
        practice = right(practice).next()
    practice = wrong(practice).next()
    assert practice.streaks["duration"] == 0
    for number in range(MASTERY):
        assert not practice.mastered
        practice = right(practice)
        assert practice.streaks["duration"] == number + 1
        practice = practice.next()
    assert practice.mastered == {"duration"}
    assert (practice.asked, practice.right) == (2 * MASTERY, 2 * MASTERY - 1)


def test_a_second_answer_to_the_same_question_does_not_count() -> None:
    practice = wrong(Practice().begun(["duration"]))
    assert right(practice) == practice


def test_what_is_mastered_is_asked_no_more_while_others_are_left() -> None:
    practice = Practice(mastered=frozenset({"duration"})).begun(["duration", "peak_speed"])
    for _ in range(MASTERY):
        assert practice.template == "peak_speed"
        practice = right(practice).next()


def test_a_wrong_answer_brings_the_subject_again() -> None:
    practice = Practice().begun(_NAMES)
    for _ in range(5):
        template = practice.template
        practice = wrong(practice).next()
        assert practice.template == template


def test_a_quiz_asks_what_was_chosen() -> None:
    found = decoded(quiz(["next_node", "which_elbow"]))
    assert found is not None
    begun = found.begun(found.chosen, found.quiz)
    assert begun.quiz
    assert set(begun.chosen) == {"next_node", "which_elbow"}
    assert begun.template in begun.chosen


@given(st.text(max_size=60))
def test_no_text_does_harm(text: str) -> None:
    assert decoded(text) is None


@pytest.mark.parametrize(
    "text",
    [
        '{"chosen": ["other"]}',
        '{"chosen": ["duration"], "template": "peak_speed"}',
        '{"chosen": ["duration"], "seed": -1}',
        '{"chosen": ["duration"], "mastered": ["x"]}',
        '{"asked": -1}',
    ],
)
def test_a_damaged_practice_is_none(text: str) -> None:
    assert decoded(text) is None


@pytest.mark.slow
def test_a_tab_asks_and_its_memory_brings_the_question_back() -> None:
    server = start(port=0, scene="paper", look=PLAIN)
    try:
        fake, session = opened(server)
        panel = session.panels.practice
        fake.set(panel.subject, "Does an edge meet a box?")
        until(lambda: panel.practice.template == "edge_passes" and panel.answers[1].visible)
        assert not panel.next.visible
        asked = question("edge_passes", panel.practice.seed)
        assert asked.text.split(",")[0] in panel._question.content
        fake.set(panel.answers[asked.right], True)
        until(lambda: panel.next.visible)
        assert "Right" in panel._reply.content

        fake.set(panel.look, True)
        shown = asked.scene
        assert shown is not None
        until(lambda: session.scene.obstacles == shown.obstacles and panel.back.visible)
        kept = session.state()
        assert decoded(kept.practice) == panel.practice
        fake.set(panel.back, True)
        until(lambda: len(session.scene.obstacles) == 1 and session.scene != shown)

        other, second = opened(server)
        second.panels.practice.restore(kept.practice)
        second.panels.practice.draw(second.frame)
        assert second.panels.practice.practice == panel.practice
        fake.set(panel.next, True)
        until(lambda: panel.practice.answer < 0)

        other.close()
    finally:
        server.stop()
