"""A user's own search: the later stages take its path, and the page shows its steps."""

from __future__ import annotations

import heapq
import math
from typing import Any

import numpy as np
import pytest

import abi
from abi.errors import ArgumentError
from abi.export import html_page
from abi.planner.own_search import OWN, expanded_by_a_star, plan_with
from abi.search.graph import Graph

_SCENE = abi.load_scene("paper")


def textbook(graph: Graph) -> tuple[list[int], list[int]]:
    """A* with the straight distance."""
    cost, parent, order = {graph.start: 0.0}, {graph.start: -1}, []
    goal = graph.points[graph.goal]
    heap, closed = [(0.0, graph.start)], set()
    while heap:
        _, node = heapq.heappop(heap)
        if node in closed:
            continue
        closed.add(node)
        order.append(node)
        if node == graph.goal:
            break
        for place in range(graph.indptr[node], graph.indptr[node + 1]):
            other, g = int(graph.indices[place]), cost[node] + float(graph.lengths[place])
            if g < cost.get(other, math.inf):
                cost[other], parent[other] = g, node
                h = float(np.linalg.norm(graph.points[other] - goal))
                heapq.heappush(heap, (g + h, other))
    path = [graph.goal]
    while parent[path[-1]] >= 0:
        path.append(parent[path[-1]])
    return path[::-1], order


def detour(graph: Graph) -> list[int]:
    """The shortest path, after one step to and fro."""
    path, _ = textbook(graph)
    return [*path[:2], *path]


def test_the_later_stages_take_the_path_of_ones_own_search() -> None:
    ours, own = abi.plan(_SCENE), plan_with(_SCENE, textbook)
    assert ours.path is not None
    assert own.path is not None
    assert own.path.algorithm == OWN
    assert own.path.length == pytest.approx(ours.path.length)
    longer = plan_with(_SCENE, detour)
    assert longer.path is not None
    assert longer.path.length > own.path.length
    assert longer.bspline is not None
    assert longer.bspline.curve.control_points[1].tolist() == longer.path.points[1].tolist()
    assert longer.motion is not None


def test_the_page_tells_both_heuristics_and_plays_the_own_steps() -> None:
    own = plan_with(_SCENE, textbook)
    assert own.graph is not None
    assert own.path is not None
    assert own.path.expanded == len(textbook(own.graph)[1])
    straight, grid = expanded_by_a_star(own.graph)
    assert straight == own.path.expanded
    assert (straight, grid) == (101, 29)  # as the documentation says
    page = html_page.write(own, "plan.html").decode()
    assert f"A* visits {straight}" in page
    assert f"and {grid} with" in page
    assert "The path of your search" in page


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (lambda graph: [graph.goal, graph.start], "first node of the path"),
        (lambda graph: [graph.start], "last node of the path"),
        (lambda graph: [graph.start, graph.goal], "an edge from each to the next"),
        (lambda graph: [graph.start, 10**6, graph.goal], "path"),
    ],
)
def test_what_is_no_path_is_refused(wrong: Any, told: str) -> None:
    with pytest.raises(ArgumentError, match=told):
        plan_with(_SCENE, wrong)


def test_a_search_without_a_path_is_a_plan_that_says_so() -> None:
    assert plan_with(_SCENE, lambda graph: []).error is not None
