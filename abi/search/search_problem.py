"""Problem of a search to compare: a graph, its costs and the settings."""

from __future__ import annotations

from dataclasses import dataclass

from abi.obstacles.obstacle_set import ObstacleSet
from abi.search.arcs import Arcs
from abi.search.graph import Graph
from abi.search.heuristic import Weight


@dataclass(frozen=True, eq=False)
class SearchProblem:
    """A graph, and the settings of the searches that are compared on it.

    Attributes:
        graph: stage 2.
        arcs: its arcs, perhaps with one of a negative cost.
        weight: what is minimised.
        heuristic_weight: w of weighted A*, 0 to 2, which minimises (2 - w) g + w h.
        obstacles: those that the graph keeps clear of.
        margin: distance that any-angle legs keep from them, [unit].
    """

    graph: Graph
    arcs: Arcs
    weight: Weight
    heuristic_weight: float
    obstacles: ObstacleSet
    margin: float
