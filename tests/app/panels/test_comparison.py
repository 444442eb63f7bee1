"""The comparison of searches in a tab, with the one that mends the search before."""

from __future__ import annotations

import re

import pytest

from abi import load_scene, plan
from abi.planner.comparison import compare, search_problem
from abi.search.arcs import Arcs
from abi.search.lifelong_a_star import lifelong_a_star
from app.panels.stages.comparison import _table
from app.tab.session import Session
from tests.app.fake_tab import FakeTab, comparison_table, labelled, until


@pytest.mark.slow
def test_the_search_before_is_mended(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    fake.set(labelled(session, "Compare all searches"), True)
    table = comparison_table(session)
    until(lambda: table.visible)
    assert "Move an obstacle and compare again" in table.content

    until(lambda: session.resting)
    before = session.frame.plan
    x, y, z = before.scene.obstacles[0].position
    fake.drag(session.panels.obstacles.gizmos[0], [x, y + 0.4, z])
    until(lambda: session.frame.plan is not before and session.resting)
    until(lambda: bool(table.visible) and "last plan" in table.content)
    now = session.frame.plan
    assert before.graph is not None
    assert now.graph is not None
    arcs = (Arcs.of(graph, "length") for graph in (before.graph, now.graph))
    (_, _, order, _), changed = lifelong_a_star(*arcs)
    assert changed > 0
    found = re.search(r"edges of (\d+) nodes have changed.* visits <b>(\d+)</b>", table.content)
    assert found is not None
    assert (int(found[1]), int(found[2])) == (changed, len(order))

    # between other ends there is nothing to mend
    fake.set(session.panels.history.undo, True)
    until(lambda: session.frame.plan.scene == before.scene and session.resting)
    fake.drag(session.panels.ends.gizmos["goal"], [5.0, 6.0, 6.0])
    until(lambda: session.frame.plan.scene.goal == (5.0, 6.0, 6.0) and session.resting)
    until(lambda: "Move an obstacle and compare again" in table.content)


def test_lengths_and_numbers_of_edges_are_not_compared() -> None:
    paper = load_scene("paper")
    for weight, gap in (("length", "−9.4 %"), ("hops", "–")):
        problem = search_problem(plan(paper.replace(search={"weight": weight})))
        found = compare(problem)
        rows = re.findall(r"<tr>(.*?)</tr>", _table(found, problem, "cm"))
        cells = [re.findall(r"<td>(?:<span[^>]*>)?(.*?)(?:</span>)?</td>", row) for row in rows]
        gaps = {row[0]: row[3] for row in cells if row}
        assert gaps["Lazy Theta*"] == gap
        assert gaps["A*"] == gaps["Dijkstra"] == "="
        # nodes and rounds are not compared, nor times that say more of the machine
        visited = {row[0]: row[4] for row in cells if row}
        assert [
            name for name, count in visited.items() if not count.replace(",", "").isdigit()
        ] == ["Bellman-Ford, by rounds"]
        assert visited["Bellman-Ford, by rounds"].endswith(" rounds")
        assert all(row[6].endswith(("µs", "ms", " s")) for row in cells if row)
