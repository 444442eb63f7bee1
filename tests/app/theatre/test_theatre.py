from __future__ import annotations

import re
from itertools import pairwise

import numpy as np
import pytest

from abi import load_scene, plan
from abi.planner.comparison import search_problem
from abi.search.compare import COMPARED
from abi.search.replay import SearchState, replay, with_next
from app.layers.search_step import (
    NODE_BUDGET,
    few,
    node_numbers,
    order_colours,
    waiting_colours,
)
from app.panels.stages import studies
from app.state.legend import SHOWN
from app.tab.session import Session
from app.teach.lesson import scene_of
from app.teach.lesson_file import load_lessons
from app.theatre.compared import compared, lettered
from app.theatre.text import describe, legend, node_row
from app.theatre.theatre import (
    Theatre,
    judge,
    labels,
    node_at,
    priorities,
    race_of,
    where,
)
from tests.app.fake_tab import FakeTab, comparison_table, drawn_node, drawn_points, labelled, until

PLAN = plan(load_scene("paper"))


def state_of(name: str, step: int, w: float = 1.0) -> SearchState:
    return replay(COMPARED[name].find(search_problem(PLAN, w)), step)


@pytest.mark.parametrize("seed", range(20))
def test_a_click_means_the_node_under_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform(0, 6, (60, 3))
    nodes = rng.permutation(60)[:40].astype(np.int32)
    eye, target = np.array([20.0, -9.0, 8.0]), int(nodes[3])
    ray = points[target] - eye
    found = node_at(points, nodes, eye, ray / np.linalg.norm(ray))
    rays = points[nodes] - eye
    angles = np.arccos(
        np.clip(rays @ ray / np.linalg.norm(rays, axis=1) / np.linalg.norm(ray), -1, 1)
    )
    assert found in nodes[angles < 0.01]
    assert np.linalg.norm(points[found] - eye) <= np.linalg.norm(ray) + 1e-9
    assert node_at(points, nodes, eye, -ray / np.linalg.norm(ray)) == -1
    assert node_at(points, nodes[:0], eye, ray) == -1


@pytest.mark.parametrize("name", COMPARED)
def test_guesses_are_judged_with_a_reason(name: str) -> None:
    state = state_of(name, 3)
    if state.following >= 0:
        assert judge(state, state.following)[0]
        right, why = judge(state, int(state.closed[0]))
        assert not right
        assert "has been visited" in why
        unreached = int(np.flatnonzero(~np.isfinite(state.cost))[0])
        assert "not been reached" in judge(state, unreached)[1]
    end = replay(state.trace, state.trace.steps)
    assert judge(end, 0) == (False, "The search has ended: nothing comes next.")


def test_a_sum_is_what_the_search_makes_least() -> None:
    state = state_of("weighted_a_star", 2, 1.5)
    node = int(state.open[0])
    assert f"{state.promise(state.open[:1])[0]:.3f}" in judge(state, node)[1]
    assert "0.5·g + 1.5·h" in judge(state, node)[1]


@pytest.mark.parametrize("name", COMPARED)
def test_what_is_written_has_the_numbers_of_the_step(name: str) -> None:
    state = state_of(name, 5)
    text = describe(Theatre(name, state), PLAN.scene)
    rounds = state.trace.queue == "rounds"
    assert f"{len(state.open)} {'of them cheaper' if rounds else 'waiting'}" in text
    assert COMPARED[name].label in text
    end = replay(state.trace, state.trace.steps)
    ended = describe(Theatre(name, end), PLAN.scene)
    assert f"{end.trace.length:.3f} cm" in ended
    # as the table of all searches counts
    assert f"{end.trace.steps} of {end.trace.steps}: " in ended
    assert rounds or f": {end.trace.steps} visited" in ended
    assert "next" not in legend(Theatre(name, end))
    shares = order_colours(end, end.closed)
    assert 0 <= shares.min() <= shares.max() <= 1


@pytest.mark.parametrize("name", COMPARED)
def test_nodes_that_may_be_next_are_the_least_of_what_orders_them(name: str) -> None:
    for step in (0, 1, 4, 9):
        state = state_of(name, min(step, COMPARED[name].find(search_problem(PLAN)).steps - 1))
        if state.trace.queue == "rounds":
            assert not Theatre(name, state).ringed.size
            continue
        ringed, values = set(Theatre(name, state).ringed.tolist()), priorities(state)
        assert state.following in ringed
        least = {int(n) for n, x in zip(state.open, values, strict=True) if x <= values.min()}
        # a search from both ends alternates between two orders
        assert state.trace.sides == 2 or least <= ringed
        text = legend(Theatre(name, state))
        assert ("tie" in text) == (len(ringed) > 1)
        assert ("tie for the least" in describe(Theatre(name, state), PLAN.scene)) == (
            len(ringed) > 1
        )


@pytest.mark.parametrize("name", COMPARED)
@pytest.mark.parametrize("voted", [False, True])
def test_nothing_gives_the_next_node_away_while_it_is_asked(name: str, voted: bool) -> None:
    state = state_of(name, 5, 1.5)
    rounds = state.trace.queue == "rounds"
    line = state.trace.queue == "first_in"
    for lesson in (False, True):
        for node, said in ((-1, ""), (int(state.open[0]), "yes")):
            asked = Theatre(name, state, asking=True, voted=voted, clicked=node, said=said)
            assert asked.ringed.size == 0
            told = legend(asked, lesson)
            assert "abi-ring" not in told
            assert "abi-scale" not in told
            assert "tie" not in told
            assert f"{priorities(state).min():.3f}" not in told
            assert rounds or len(np.unique(waiting_colours(asked, state.open), axis=0)) == 1
            numbers = node_numbers(asked, PLAN.scene)
            assert numbers["formula"] is None
            assert rounds or "?" in node_row(asked, int(state.open[1])) or line
    following = state.following
    wrong = int(state.closed[0])
    known = Theatre(name, state, asking=True, clicked=wrong, said="no", is_wrong=True)
    if rounds:
        return
    assert following in known.ringed
    assert "abi-ring" in legend(known)
    assert len(np.unique(waiting_colours(known, state.open), axis=0)) > 1
    assert line or labels(state, following)[2] in node_row(known, following)


@pytest.mark.parametrize(
    ("name", "w"), [("a_star", 1.0), ("dijkstra", 1.0), ("weighted_a_star", 1.5)]
)
def test_a_sum_adds_up_as_it_is_told_and_a_tie_looks_like_one(name: str, w: float) -> None:
    tied = 0
    for step in range(0, 10, 2):
        state = state_of(name, step, w)
        for node in state.open.tolist():
            g, h, f = (float(x.replace(",", "")) for x in labels(state, node))
            exact = state.promise(np.array([node], np.int32))[0]
            assert abs(f - exact) <= 0.0005 + 1e-9
            assert abs(g - state.cost[node]) <= 0.0005 + 1e-9
            if name == "a_star":
                assert round(g + h, 3) == f
        equal = [node for node in state.open.tolist() if state.is_least(node)]
        tied += len(equal) > 1
        assert len({labels(state, node)[2] for node in equal}) <= 1
        letters = compared(state).tolist()
        least = {labels(state, node)[2] for node in letters if state.may_follow(node)}
        assert len(least) == 1
        assert least.isdisjoint(
            labels(state, node)[2] for node in letters if not state.may_follow(node)
        )
    assert tied or name != "a_star"


def test_what_is_wrong_is_told_with_as_many_digits_as_it_takes() -> None:
    for step in range(1, 12):
        state = state_of("a_star", step)
        for node in set(state.open.tolist()) - set(state.candidates().tolist()):
            own, least = re.findall(r"[\d.]+", judge(state, node)[1].split(" = ")[-1])[:2]
            assert float(own) > float(least.rstrip("."))


@pytest.mark.parametrize("name", ["a_star", "dijkstra"])
def test_a_search_goes_on_with_the_one_chosen_of_several_that_tie(name: str) -> None:
    chosen, state = 0, state_of(name, 0)
    first, step = state.trace, 0
    while step < state.trace.steps:
        state = replay(state.trace, step)
        others = [node for node in state.candidates().tolist() if state.is_least(node)]
        node = next((one for one in others if one != state.following), state.following)
        own = with_next(state, node)
        assert own is not None
        if node != state.following:
            chosen += 1
            right, why = judge(state, node, goes_on=True)
            assert right
            assert "goes on with yours" in why
        step += 1
        state = replay(own, step)
        assert state.current == node
        assert node not in state.open
    assert chosen > 0
    assert state.trace.length == pytest.approx(first.length)
    # each node had the least f when its turn came
    for step in range(state.trace.steps):
        before = replay(state.trace, step)
        assert before.is_least(before.following)


def test_a_search_that_trusts_h_more_takes_its_own_of_several_and_says_which() -> None:
    told = 0
    for step in range(COMPARED["greedy_best_first"].find(search_problem(PLAN)).steps):
        state = state_of("greedy_best_first", step)
        for node in set(state.candidates().tolist()) - {state.following}:
            assert with_next(state, node) is None
            assert where(state, state.following) in judge(state, node)[1]
            after = replay(state.trace, step + 1)
            asked = Theatre("greedy_best_first", after, asking=True, clicked=node)
            assert node not in lettered(asked).values() or node == after.following
            told += 1
    assert told or len(state_of("greedy_best_first", 0).open) == 1


def test_on_the_grid_of_the_lesson_on_searches_no_two_nodes_tie() -> None:
    lesson, folder = load_lessons(None)["03-search"]
    setting = lesson.steps[0].set
    assert setting is not None
    problem = search_problem(plan(scene_of(setting, PLAN.scene, folder)))
    trace = COMPARED["a_star"].find(problem)
    assert trace.steps > 15
    assert all(len(replay(trace, step).candidates()) == 1 for step in range(trace.steps))
    assert setting.search is not None
    shown = replay(COMPARED["dijkstra"].find(problem), setting.search.step or 0)
    assert len(shown.candidates()) == 1


def test_of_many_nodes_the_same_part_is_drawn_at_every_step() -> None:
    n = 200_000
    nodes = np.arange(n, dtype=np.int32)
    part = set(few(nodes, n).tolist())
    assert 0.8 * NODE_BUDGET < len(part) < 1.2 * NODE_BUDGET
    assert set(few(nodes[::3], n).tolist()) == part & set(nodes[::3].tolist())
    assert len(few(nodes[:5000], 5000)) == 5000


def test_the_chosen_search_is_in_the_race() -> None:
    for name in COMPARED:
        assert name in race_of(name)
        assert len(set(race_of(name))) == 3


def drawn(session: Session) -> list[object]:
    clouds = (drawn_node(session, f"/theatre/{name}") for name in ("closed", "open", "current"))
    return [
        *map(bytes, map(drawn_points, clouds)),
        bytes(drawn_node(session, "/theatre/path").points),
    ]


@pytest.mark.slow
def test_steps_forward_and_back_show_the_same(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    panel, nodes = session.panels.theatre, session.client.scene._handle_from_node_name

    def at(step: int) -> bool:
        theatre = session.frame.theatre
        return theatre is not None and theatre.state.step == step and session.resting

    fake.set(panel.on, True)
    until(lambda: at(0))
    pictures = [drawn(session)]
    for step in (1, 2, 3):
        fake.set(panel.one, "1 ▶")
        until(lambda step=step: at(step))  # type: ignore[misc]
        pictures.append(drawn(session))
    assert all(one != other for one, other in pairwise(pictures))
    for step in (2, 1, 0):
        fake.set(panel.one, "◀ 1")
        until(lambda step=step: at(step))  # type: ignore[misc]
        assert drawn(session) == pictures[step]
    fake.set(panel.step, 3)
    until(lambda: at(3))
    assert drawn(session) == pictures[3]
    fake.set(panel.race, True)
    until(lambda: bool(session.frame.theatre.race))  # type: ignore[union-attr]
    assert drawn_node(session, "/race").visible
    assert [name for name, _ in session.frame.theatre.race] == list(race_of("a_star"))  # type: ignore[union-attr]
    fake.set(panel.on, False)
    until(lambda: session.frame.theatre is None and "/race" not in nodes)


@pytest.mark.slow
def test_a_search_follows_its_plan_and_takes_any_edge(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    panel = session.panels.theatre
    fake.set(panel.on, True)
    until(lambda: session.frame.theatre is not None)
    fake.drag(session.panels.ends.gizmos["start"], [0.0, 2.0, 0.0])
    until(lambda: session.resting and session.plan.scene.start[1] == 2.0)  # type: ignore[union-attr]
    graph = session.frame.plan.graph
    assert graph is not None
    until(
        lambda: (
            session.frame.theatre is not None
            and session.frame.theatre.state.trace.arcs.points is graph.points
        )
    )
    fake.set(panel.edges, "one, with a cycle")
    fake.set(panel.algorithm, COMPARED["bellman_ford_rounds"].label)
    until(
        lambda: (
            session.frame.theatre is not None and len(session.frame.theatre.state.trace.cycle) > 0
        )
    )
    fake.set(panel.algorithm, COMPARED["bidirectional_dijkstra"].label)
    until(lambda: session.frame.theatre is not None and session.frame.theatre.name == "dijkstra")
    fake.set(labelled(session, "Compare all searches"), True)
    until(lambda: comparison_table(session).visible)
    for label in (one.label for one in COMPARED.values()):
        assert label in comparison_table(session).content


def test_the_search_is_seen_alone_while_it_is_stepped_through(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    panel, usual = session.panels.theatre, session.frame.shown
    fake.set(panel.on, True)
    until(lambda: not {"arm", "bspline", "a_star", "names"} & session.frame.shown)
    assert {"workspace", "obstacles", "edges"} <= session.frame.shown
    fake.set(panel.on, False)
    until(lambda: session.frame.shown == usual)


def test_a_search_opens_with_the_one_of_stage_three_at_its_first_step(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    panel = session.panels.theatre
    fake.set(session.panels.stages.fields["search.algorithm"], "Dijkstra")
    until(lambda: session.resting and session.frame.plan.scene.search.algorithm == "dijkstra")
    panel.set(on=True, algorithm="greedy_best_first", step=4)  # as a lesson does
    fake.set(panel.edges, "one")
    until(lambda: session.frame.theatre is not None and session.frame.theatre.state.step == 4)
    fake.set(panel.on, False)
    until(lambda: session.frame.theatre is None and panel.step.value == 0)
    fake.set(panel.on, True)
    until(lambda: session.frame.theatre is not None)
    opened = session.frame.theatre
    assert opened is not None
    assert (opened.name, opened.state.step) == ("dijkstra", 0)
    assert opened.state.trace.arcs.negative is None


def test_a_lesson_says_itself_what_is_shown_beside_a_search(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    lessons = session.panels.lessons
    until(lambda: len(lessons.choice.options) > 12)
    fake.set(lessons.choice, lessons.choice.options[-1])
    until(lambda: lessons.progress.chosen and session.frame.shown < SHOWN)
    shown = session.frame.shown
    assert "arm" in shown
    fake.set(session.panels.theatre.on, True)
    until(lambda: session.frame.theatre is not None)
    assert session.frame.shown == shown


@pytest.mark.slow
def test_at_its_end_a_search_can_be_played_again(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    panel = session.panels.theatre
    fake.set(panel.on, True)
    until(lambda: session.frame.theatre is not None)
    steps = session.frame.theatre.state.trace.steps  # type: ignore[union-attr]
    fake.set(panel.step, steps - 2)
    until(lambda: session.frame.theatre.state.step == steps - 2)  # type: ignore[union-attr]
    fake.set(panel.play, True)
    until(lambda: session.frame.theatre.state.done)  # type: ignore[union-attr]
    until(lambda: session.resting and panel.play.label == "Play the search")


@pytest.mark.parametrize("name", COMPARED)
def test_what_takes_no_negative_edge_says_what_is_shown_instead(
    tab: tuple[FakeTab, Session], name: str
) -> None:
    fake, session = tab
    panel = session.panels.theatre
    fake.set(panel.on, True)
    fake.set(panel.edges, "one")
    fake.set(panel.algorithm, COMPARED[name].label)
    takes_it = COMPARED[name].substitute is None
    until(
        lambda: (
            session.frame.theatre is not None
            and session.frame.theatre.state.trace.arcs.negative is not None
            and (session.frame.theatre.name == name) == takes_it
            and panel.algorithm.value == COMPARED[session.frame.theatre.name].label
        )
    )


def test_a_step_is_kept_and_comes_back(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    panel = session.panels.theatre
    assert panel.kept == ""
    panel.set(on=True, algorithm="dijkstra", step=25)
    fake.set(panel.edges, "one")
    until(lambda: session.frame.theatre is not None and session.frame.theatre.state.step == 25)
    kept = session.state().theatre
    panel.restore("")
    assert not panel.on.value
    for nonsense in ("{", "[]", '{"algorithm": "none"}', '{"edges": "three"}', '{"step": -1}'):
        panel.restore(nonsense)
        assert not panel.on.value
    panel.restore(kept)
    until(lambda: session.state().theatre == kept)
    assert session.frame.theatre is not None
    assert session.frame.theatre.name == "dijkstra"
    assert session.frame.theatre.state.step == 25


@pytest.mark.slow
def test_the_comparison_follows_a_small_plan(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    fake, session = tab
    button, table = labelled(session, "Compare all searches"), comparison_table(session)
    fake.set(button, True)
    until(lambda: table.visible)
    before = table.content
    fake.set(session.panels.stages.fields["mesh.pitch"], 0.9)
    until(lambda: session.resting and table.content != before)
    assert "Theta" in table.content

    monkeypatch.setattr(studies, "_LIVE", -1.0)  # as if the searches took long
    fake.set(session.panels.stages.fields["mesh.pitch"], 1.3)
    until(lambda: "press again" in table.content)
    fake.set(button, True)
    until(lambda: "Theta" in table.content)


def test_the_comparison_says_when_there_is_no_graph(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    size = session.panels.editor.sizes.size
    fake.set(session.panels.editor._position.handle, (0.0, 0.0, 0.0))
    fake.set(size, (9.0, 9.0, 9.0))
    until(lambda: session.resting and session.frame.plan.graph is None)
    fake.set(labelled(session, "Compare all searches"), True)
    until(lambda: "no graph" in comparison_table(session).content)
