from __future__ import annotations

import re

import numpy as np
import pytest

from abi import load_scene, plan
from abi.planner.comparison import search_problem
from abi.search.compare import COMPARED
from abi.search.replay import replay
from app.theatre.compared import LETTERS, asks_for_sums, compared, letter_label, lettered
from app.theatre.text import describe, question
from app.theatre.theatre import Theatre, order_label, priorities, where

PLAN = plan(load_scene("drag-a-box"))


@pytest.mark.parametrize("name", COMPARED)
def test_numbers_of_the_nodes_that_are_compared_tell_which_is_next(name: str) -> None:
    trace = COMPARED[name].find(search_problem(PLAN))
    if trace.queue == "rounds":
        assert not len(compared(replay(trace, 1)))
        return
    places = set()
    for step in range(trace.steps):
        state = replay(trace, step)
        nodes = compared(state)
        assert len(set(nodes.tolist())) == len(nodes) <= len(LETTERS)
        assert set(nodes.tolist()) <= set(state.open.tolist())
        order = dict(zip(state.open.tolist(), priorities(state), strict=True))
        numbers = np.array([order[node] for node in nodes.tolist()])
        right = np.array([state.may_follow(node) for node in nodes.tolist()])
        # others may be right, too: searches take what differs by a thousandth for equal
        assert right[numbers <= numbers.min()].all()
        assert right.sum() <= 2 or not len(np.setdiff1d(state.open, [*state.candidates(), *nodes]))
        places.add(int(numbers.argmin()))
    # no place in the table is always the right one's
    assert len(places) > 1


def test_who_is_asked_reads_letters_and_their_numbers_and_a_vote_reads_none() -> None:
    state = replay(COMPARED["a_star"].find(search_problem(PLAN)), 6)
    asked = Theatre("a_star", state, asking=True)
    text = describe(asked, PLAN.scene)
    assert "".join(lettered(asked)) == LETTERS
    for letter, node in lettered(asked).items():
        assert f">{letter}</b> {where(state, node)}" in text
    assert "one of A to E" in question(asked)
    assert not len(lettered(Theatre("a_star", state)))
    voted = Theatre("a_star", state, asking=True, voted=True)
    assert not len(lettered(voted))
    assert "one of those that wait" in question(voted)


@pytest.mark.parametrize("name", ["a_star", "dijkstra", "greedy_best_first"])
def test_a_node_keeps_its_letter_while_it_waits(name: str) -> None:
    trace = COMPARED[name].find(search_problem(PLAN))
    before: dict[str, int] = {}
    kept = 0
    for step in range(trace.steps):
        asked = Theatre(
            name,
            replay(trace, step),
            asking=True,
            kept=tuple(before.get(letter, -1) for letter in LETTERS),
        )
        now = lettered(asked)
        assert len(set(now.values())) == len(now)
        assert asked.state.following in now.values()
        ties = set(asked.state.candidates().tolist())
        assert (
            not set(now.values()) <= ties or set(asked.state.open.tolist()) <= ties or len(now) < 3
        )
        for letter, node in before.items():
            kept += now.get(letter) == node
            assert node not in now.values() or now[letter] == node
        before = now
    assert kept > trace.steps


@pytest.mark.parametrize("name", COMPARED)
def test_the_numbers_at_the_letters_are_added_and_tell_which_is_next(name: str) -> None:
    trace = COMPARED[name].find(search_problem(PLAN))
    for step in range(0, trace.steps, 3):
        asked = Theatre(name, replay(trace, step), asking=True)
        nodes, told = [*lettered(asked).values()], describe(asked, PLAN.scene).count("<td>?</td>")
        if not asks_for_sums(asked):
            assert not told
            assert all(letter_label(asked, k) == order_label(asked.state, k) for k in nodes)
            continue
        # of Dijkstra's g is told, which no sum is made of
        assert told == (0 if trace.factors == (1.0, 0.0) else len(nodes))
        numbers = [re.findall(r"[\d.]+", letter_label(asked, k)) for k in nodes]
        sums = [np.dot(trace.factors[: len(each)], np.array(each, float)) for each in numbers]
        assert asked.state.may_follow(nodes[int(np.argmin(np.round(sums, 6)))])
