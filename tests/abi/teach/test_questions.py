"""Questions for any seed: their keys by other libraries, and what every question has."""

from __future__ import annotations

import pytest

from abi.errors import ArgumentError
from abi.teach.quiz.templates import question, templates
from benchmarks.question_oracles import ORACLES, answer


@pytest.mark.parametrize("name", templates())
def test_the_key_is_what_another_way_finds(name: str) -> None:
    for seed in range(12):
        made = question(name, seed)
        assert answer(name, made) == made.right, seed


@pytest.mark.parametrize("name", templates())
def test_a_question_is_whole_and_the_same_for_its_seed(name: str) -> None:
    rights = set()
    for seed in range(30, 42):
        made = question(name, seed)
        assert made.text == question(name, seed).text
        assert 2 <= len(made.choices) == len(set(made.choices)) <= 4
        assert made.text.endswith("?")
        assert made.why.endswith(".")
        rights.add(made.right)
        assert made.scene is None or made.scene.obstacles
    assert len(rights) > 1  # no place is always right
    assert question(name, 30).text != question(name, 31).text


def test_every_template_has_another_way_to_its_answer() -> None:
    assert set(templates()) == ORACLES
    assert len(templates()) >= 12


def test_an_oracle_finds_a_wrong_key() -> None:
    made = question("shortest_length", 0)
    assert answer("fewest_edges", made) != made.right


def test_what_is_no_template_is_refused() -> None:
    with pytest.raises(ArgumentError, match="template is 'other'"):
        question("other", 0)
    with pytest.raises(ArgumentError, match="seed"):
        question("duration", -1)
