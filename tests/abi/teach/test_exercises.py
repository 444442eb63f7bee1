"""The exercises: errors that students make are caught, and what is right is accepted."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from typing import Any

import networkx
import numpy as np
import pytest

import abi.teach
from abi.search.search import search
from abi.teach.boxes import segment_meets
from abi.teach.exercise import Exercise, Trial
from abi.teach.hidden_scenes import SCENES, graph_of, hidden_scenes
from abi.teach.student_main import answers_of
from abi.teach.student_process import Answers, job_of, read
from abi.teach.topics.priority import expanded_by_a_star, first_fault
from abi.teach.verdict import SEED, ExerciseVerdict, judged
from tests.abi.teach.right_students import RIGHT
from tests.abi.teach.wrong_students import WRONG
from tests.thorough import of_each_kind

_ALL = tuple(abi.teach.exercises().values())


@cache
def trials_of(one: Exercise, seed: int) -> tuple[Trial, ...]:
    """Hidden trials, which students' functions get as JSON and cannot change."""
    return one.trials(seed)


def verdict_of(one: Exercise, function: Callable[..., Any], seed: int = SEED) -> ExerciseVerdict:
    """The verdict without the process, which takes most of the time."""
    trials = trials_of(one, seed)
    job = json.loads(json.dumps(job_of(function, one.name, one.caller, [t.calls for t in trials])))
    lines = (json.dumps(line).encode() for line in answers_of(job))
    return judged(one, trials, read(lines, len(trials)))


@pytest.mark.parametrize(("name", "function"), RIGHT)
def test_a_right_function_is_accepted(name: str, function: Callable[..., Any]) -> None:
    found = verdict_of(abi.teach.exercises()[name], function)
    assert found.passed, found.sentence


@pytest.mark.parametrize(("name", "function"), WRONG)
def test_a_wrong_function_is_caught_with_a_case(name: str, function: Callable[..., Any]) -> None:
    found = verdict_of(abi.teach.exercises()[name], function)
    assert not found.passed
    case = found.counterexample
    assert case is not None
    assert case.scene.obstacles
    assert found.sentence.endswith(".")
    assert len(found.sentence) < 420


@pytest.mark.parametrize("one", _ALL, ids=lambda one: one.name)
def test_whole_numbers_beyond_all_floats_are_no_answers(one: Exercise) -> None:
    large = 10**400
    for value in (large, [large, 0], [large] * 3, [[large] * 3] * 2):
        assert not verdict_of(one, lambda *_, value=value: value).passed
        trials = trials_of(one, SEED)
        answers = Answers(tuple([value] * len(trial.calls) for trial in trials))
        assert one.name == "priority" or not judged(one, trials, answers).passed
    long = verdict_of(one, lambda *_: 10**5000)
    assert one.name == "priority" or "that no float can hold" in long.sentence


def test_a_search_that_stops_before_the_goal_is_no_right_one() -> None:
    graph = graph_of(hidden_scenes(SEED)[0])
    order = list(expanded_by_a_star(graph))
    assert first_fault(graph, order) is None
    for steps in (0, 1, len(order) - 1):
        number, sentence = first_fault(graph, order[:steps]) or (-1, "")
        assert number == steps
        assert "before it is at the goal" in sentence


def test_there_are_thirty_of_each() -> None:
    assert len(RIGHT) >= 30
    assert len(WRONG) >= 30
    names = set(abi.teach.exercises())
    assert {name for name, _ in RIGHT} == {name for name, _ in WRONG} == names


@pytest.mark.slow
@pytest.mark.parametrize("seed", of_each_kind([1, 77], 77))
def test_other_scenes_accept_what_is_right_and_catch_what_is_wrong(seed: int) -> None:
    for solutions, passed in ((RIGHT, True), (WRONG, False)):
        for name, function in dict(solutions).items():
            assert verdict_of(abi.teach.exercises()[name], function, seed).passed is passed


@pytest.mark.parametrize("one", _ALL, ids=lambda one: one.name)
def test_an_exercise_tells_what_to_do_and_begins_with_an_error(one: Exercise) -> None:
    names: dict[str, Any] = {}
    exec(one.starter, names)
    assert not verdict_of(one, names[one.name]).passed
    assert len(one.starter.splitlines()) <= 15
    assert len(one.trials(SEED)) == SCENES


def test_a_wrong_search_parts_from_the_right_one_at_its_last_step() -> None:
    case = verdict_of(abi.teach.exercises()["priority"], lambda g, h: h).counterexample
    assert case is not None
    assert case.steps[: case.parting] == case.right_steps[: case.parting]
    assert len(case.steps) == case.parting + 1
    assert case.right_steps[-1] == graph_of(hidden_scenes(SEED)[0]).goal


def test_the_right_search_is_a_shortest_path_by_networkx() -> None:
    for scene in hidden_scenes(SEED):
        own = graph_of(scene)
        graph, points = own.to_networkx(), own.points
        order = expanded_by_a_star(own)
        shortest = networkx.dijkstra_path_length(graph, own.start, own.goal, weight="length")
        away = networkx.single_source_dijkstra_path_length(graph, own.start, weight="length")
        straight = {node: math.dist(points[node], points[own.goal]) for node in graph}
        must = {node for node in away if away[node] + straight[node] < shortest - 1e-9}
        may = {node for node in away if away[node] + straight[node] < shortest + 1e-9}
        assert must <= set(order) <= may
        assert search("dijkstra", own, "length").expanded >= len(order)


def test_a_segment_meets_a_box_where_it_has_a_point_of_it() -> None:
    random = np.random.default_rng(0)
    for _ in range(300):
        a, b = random.integers(-4, 5, (2, 3)).tolist()
        low = random.integers(-3, 1, 3).tolist()
        high = [x + int(random.integers(1, 4)) for x in low]
        exact = segment_meets([Fraction(x) for x in a], [Fraction(x) for x in b], (low, high))
        # by lattice: all coordinates that can be extreme are at multiples of 1 / (differences)
        shares = {Fraction(0), Fraction(1)}
        for p, q, lo, hi in zip(a, b, low, high, strict=True):
            if p != q:
                shares |= {Fraction(lo - p, q - p), Fraction(hi - p, q - p)}
        points = [
            [p + s * (q - p) for p, q in zip(a, b, strict=True)] for s in shares if 0 <= s <= 1
        ]
        inside = any(
            all(lo <= x <= hi for x, lo, hi in zip(point, low, high, strict=True))
            for point in points
        )
        assert exact == inside
