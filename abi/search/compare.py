"""Table of the searches that can be compared and stepped through, by name.

They run on request, not in every plan. A new one is a file beside this one, with a function from a
task to a trace, and an entry here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType

from abi.search.bellman_ford_rounds import bellman_ford_rounds
from abi.search.bidirectional_dijkstra import bidirectional_dijkstra
from abi.search.lazy_theta_star import lazy_theta_star
from abi.search.search import order_of_expansion
from abi.search.task import SearchTask
from abi.search.trace import SearchTrace, trace_of
from abi.search.weighted_a_star import best_first, weighted_a_star


@dataclass(frozen=True)
class ComparedSearch:
    """An entry of the table.

    Attributes:
        label: its name on the page.
        find: the search.
        exact: whether its path is always the cheapest of the graph.
        one_way: whether it can handle arcs in one direction only, such as one of negative cost.
        any_angle: whether its path may leave the edges; it then minimises the length.
    """

    label: str
    find: Callable[[SearchTask], SearchTrace]
    exact: bool
    one_way: bool
    any_angle: bool = False


def _as_planned(algorithm: str, factors: tuple[float, float], task: SearchTask) -> SearchTrace:
    """A* or Dijkstra as every plan runs them; as in the textbook where a cost is negative."""
    if task.arcs.negative is not None:
        return best_first(task, factors)
    order = order_of_expansion(algorithm, task.graph, task.weight)
    return trace_of(task.arcs, order, "best_first", factors, reopens=True)


def _bellman_ford(task: SearchTask) -> SearchTrace:
    """Bellman-Ford with a queue, as every plan runs it."""
    order = order_of_expansion("bellman_ford", task.graph, task.weight)
    return trace_of(task.arcs, order, "first_in", reopens=True)


COMPARED: Mapping[str, ComparedSearch] = MappingProxyType(
    {
        "a_star": ComparedSearch("A*", partial(_as_planned, "a_star", (1.0, 1.0)), True, True),
        "dijkstra": ComparedSearch(
            "Dijkstra", partial(_as_planned, "dijkstra", (1.0, 0.0)), True, True
        ),
        "bellman_ford": ComparedSearch("Bellman-Ford (queue)", _bellman_ford, True, False),
        "bellman_ford_rounds": ComparedSearch(
            "Bellman-Ford, by rounds", bellman_ford_rounds, True, True
        ),
        "weighted_a_star": ComparedSearch("weighted A*", weighted_a_star, False, True),
        "greedy_best_first": ComparedSearch(
            "greedy best-first", partial(best_first, factors=(0.0, 1.0)), False, True
        ),
        "bidirectional_dijkstra": ComparedSearch(
            "Dijkstra from both ends", bidirectional_dijkstra, True, False
        ),
        "lazy_theta_star": ComparedSearch(
            "Lazy Theta*", lazy_theta_star, False, False, any_angle=True
        ),
    }
)
"""The searches by name; the first three are those of every plan."""
