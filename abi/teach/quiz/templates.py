"""The templates of questions by name, and questions made from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from abi import arguments
from abi.errors import ArgumentError
from abi.teach.quiz import blackboard, curves, in_scenes, motion
from abi.teach.quiz.question import QuizQuestion


@dataclass(frozen=True)
class Template:
    """A template.

    Attributes:
        title: what its questions are about.
        make: makes one of random numbers.
    """

    title: str
    make: Callable[[np.random.Generator], QuizQuestion]


_TEMPLATES: Mapping[str, Template] = MappingProxyType(
    {
        "edge_passes": Template("Does an edge meet a box?", in_scenes.edge_passes),
        "box_distance": Template("How far is a point from a box?", in_scenes.box_distance),
        "shortest_length": Template("How long is the shortest path?", blackboard.shortest_length),
        "fewest_edges": Template("The path with the fewest edges", blackboard.fewest_edges),
        "expansion_order": Template(
            "The order of Dijkstra's algorithm", blackboard.expansion_order
        ),
        "bellman_ford_round": Template("A round of Bellman-Ford", blackboard.bellman_ford_round),
        "next_node": Template("Which node comes next?", in_scenes.next_node),
        "priority_of_node": Template("g, h and f of a node", in_scenes.priority_of_node),
        "consistent": Template("Is a heuristic consistent?", in_scenes.consistent),
        "pieces_moved": Template("What a control point moves", curves.pieces_moved),
        "points_influencing": Template("What a curve's point hangs on", curves.points_influencing),
        "points_after_knot": Template("A knot more", curves.points_after_knot),
        "point_of_curve": Template("A point of a B-spline", curves.point_of_curve),
        "speed_limit_hit": Template("Where is the speed limit hit?", motion.speed_limit_hit),
        "peak_speed": Template("How fast does it become?", motion.peak_speed),
        "duration": Template("How long does a motion take?", motion.duration),
        "which_elbow": Template("Which elbow?", motion.which_elbow),
        "reachable_distance": Template("How far an arm reaches", motion.reachable_distance),
    }
)


def templates() -> Mapping[str, Template]:
    """The templates by name, in the order of the stages."""
    return _TEMPLATES


def question(template: str, seed: int) -> QuizQuestion:
    """The question of a template and a seed; reproducible.

    Raises:
        ArgumentError: there is no such template, or the seed is below 0.
    """
    if template not in _TEMPLATES:
        raise ArgumentError("template", template, f"one of {', '.join(_TEMPLATES)}")
    seed = arguments.integer("seed", seed, 0, arguments.LARGEST_ID)
    number = list(_TEMPLATES).index(template)
    return _TEMPLATES[template].make(np.random.default_rng([seed, number]))
