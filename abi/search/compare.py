"""Table of the searches that can be compared and stepped through, by name.

Those of every plan come first; the others run on request. A new one of these is a function from a
problem to a trace, in a file beside this one unless it is as short as those here, and an entry.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType

from abi.arrays import read_only
from abi.search.bellman_ford_rounds import bellman_ford_rounds
from abi.search.heap_kernels import best_first_order, bidirectional_order
from abi.search.lazy_theta_star import lazy_theta_star
from abi.search.search import SEARCHES, PlannedSearch
from abi.search.search_problem import SearchProblem
from abi.search.trace import SearchTrace, trace_of


@dataclass(frozen=True)
class ComparedSearch:
    """An entry of the table.

    Attributes:
        label: its name on the page.
        find: the search.
        exact: whether its path is always the cheapest of the graph.
        substitute: the search that takes its place where an arc leads in one direction only, such
            as one of negative cost; None if it can handle them itself.
        any_angle: whether its path may leave the edges; it then minimises the length.
    """

    label: str
    find: Callable[[SearchProblem], SearchTrace]
    exact: bool
    substitute: str | None = None
    any_angle: bool = False


def _best_first(factors: tuple[float, float], problem: SearchProblem) -> SearchTrace:
    """Minimise a g + b h, as in the textbook: no node is expanded twice.

    Greedy search, (0, 1), expands the node that seems nearest to the goal, whatever it cost;
    nothing bounds how much longer than the shortest its path may be.
    """
    arcs = problem.arcs
    order = best_first_order(arcs.rows, arcs.estimates, (arcs.start, arcs.goal), factors)
    return trace_of(arcs, order, "best_first", factors)


def _weighted_a_star(problem: SearchProblem) -> SearchTrace:
    """Minimise (2 - w) g + w h (Pohl, 1970): Dijkstra at w = 0, A* at 1, greedy at 2.

    It trusts the heuristic more, for fewer nodes but a longer path. That costs at most
    max(w / (2 - w), 1) times the least (Likhachev, Gordon and Thrun, 2003), though no node is
    expanded twice, because the heuristic is consistent.
    """
    w = problem.heuristic_weight
    return _best_first((2.0 - w, w), problem)


def _bidirectional_dijkstra(problem: SearchProblem) -> SearchTrace:
    """Search from start and goal until their radii add up to the cost of the best path found.

    Two small balls instead of a large one.
    """
    arcs = problem.arcs
    order = bidirectional_order(arcs.rows, (arcs.start, arcs.goal))
    return trace_of(arcs, order, "best_first", sides=2, reopens=True)


def _as_planned(search: PlannedSearch, problem: SearchProblem) -> SearchTrace:
    """A search as every plan runs it, or the textbook version if a cost is negative."""
    if problem.arcs.negative is not None:
        return _best_first(search.factors, problem)
    _, _, order, _ = search.expand(problem.graph, problem.weight)
    return trace_of(problem.arcs, read_only(order), search.queue, search.factors, reopens=True)


def _planned(search: PlannedSearch) -> ComparedSearch:
    """The table entry of a search of every plan."""
    substitute = None if search.queue == "best_first" else "bellman_ford_rounds"
    return ComparedSearch(search.label, partial(_as_planned, search), True, substitute)


COMPARED: Mapping[str, ComparedSearch] = MappingProxyType(
    {name: _planned(one) for name, one in SEARCHES.items()}
    | {
        "bellman_ford_rounds": ComparedSearch("Bellman-Ford, by rounds", bellman_ford_rounds, True),
        "weighted_a_star": ComparedSearch("weighted A*", _weighted_a_star, False),
        "greedy_best_first": ComparedSearch(
            "greedy best-first", partial(_best_first, (0.0, 1.0)), False
        ),
        "bidirectional_dijkstra": ComparedSearch(
            "Dijkstra from both ends", _bidirectional_dijkstra, True, "dijkstra"
        ),
        "lazy_theta_star": ComparedSearch(
            "Lazy Theta*", lazy_theta_star, False, "dijkstra", any_angle=True
        ),
    }
)
"""The searches by name; the first are those of every plan."""
