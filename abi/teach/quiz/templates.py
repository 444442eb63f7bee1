"""The templates of questions by name, and questions made from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from abi import arguments
from abi.errors import ArgumentError
from abi.teach.quiz import blackboard, curves, in_scenes, motion
from abi.teach.quiz.question import QuizQuestion

Template = Callable[[np.random.Generator], QuizQuestion]
"""Function that makes a question of random numbers; its name is the template's."""

_BY_TITLE: Mapping[str, Template] = MappingProxyType(
    {
        "Does an edge meet a box?": in_scenes.edge_passes,
        "How far is a point from a box?": in_scenes.box_distance,
        "How long is the shortest path?": blackboard.shortest_length,
        "The path with the fewest edges": blackboard.fewest_edges,
        "The order of Dijkstra's algorithm": blackboard.expansion_order,
        "A round of Bellman-Ford": blackboard.bellman_ford_round,
        "Which node comes next?": in_scenes.next_node,
        "g, h and f of a node": in_scenes.priority_of_node,
        "Is a heuristic consistent?": in_scenes.consistent,
        "What a control point moves": curves.pieces_moved,
        "What a curve's point hangs on": curves.points_influencing,
        "A knot more": curves.points_after_knot,
        "A point of a B-spline": curves.point_of_curve,
        "Where is the speed limit hit?": motion.speed_limit_hit,
        "How fast does it become?": motion.peak_speed,
        "How long does a motion take?": motion.duration,
        "Which elbow?": motion.which_elbow,
        "How far an arm reaches": motion.reachable_distance,
    }
)
"""The templates by what their questions are about."""
_BY_NAME = {make.__name__: make for make in _BY_TITLE.values()}
_TITLES: Mapping[str, str] = MappingProxyType(
    {make.__name__: title for title, make in _BY_TITLE.items()}
)


def templates() -> Mapping[str, str]:
    """What the questions of each template are about, by its name, in the order of the stages."""
    return _TITLES


def question(template: str, seed: int) -> QuizQuestion:
    """The question of a template and a seed; reproducible.

    Raises:
        ArgumentError: there is no such template, or the seed is below 0.
    """
    if template not in _BY_NAME:
        raise ArgumentError("template", template, f"one of {', '.join(_BY_NAME)}")
    seed = arguments.integer("seed", seed, 0, arguments.LARGEST_ID)
    number = list(_BY_NAME).index(template)
    return _BY_NAME[template](np.random.default_rng([seed, number]))
