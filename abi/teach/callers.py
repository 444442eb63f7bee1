"""Ways to call a student's function: alone, in a best-first search, or with a clearance test.

They run in the student's process, so that they import only Python's own library.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType
from typing import Any

from abi.teach.boxes import segment_meets_any

Function = Callable[..., Any]


def _alone(function: Function, arguments: list[Any]) -> Any:
    """Call the function with its arguments; points are tuples."""
    return function(*map(_with_tuples, arguments))


def _in_search(function: Function, arguments: list[Any]) -> list[int]:
    """Expand nodes in the order of the function's priorities, least first, until the goal.

    Args:
        function: priority of (g, h).
        arguments: a graph as rows (``indptr``, ``indices``, ``lengths``), its points, start, goal.

    Returns:
        The nodes in the order of their expansion; none is expanded twice.
    """
    graph = arguments[0]
    indptr, indices, lengths = graph["indptr"], graph["indices"], graph["lengths"]
    points, start, goal = graph["points"], graph["start"], graph["goal"]
    cost = {start: 0.0}
    heap = [(function(0.0, math.dist(points[start], points[goal])), 0, start)]
    closed: set[int] = set()
    order = []
    entered = 0
    while heap:
        _, _, node = heapq.heappop(heap)
        if node in closed:
            continue
        closed.add(node)
        order.append(node)
        if node == goal:
            break
        for place in range(indptr[node], indptr[node + 1]):
            other, g = indices[place], cost[node] + lengths[place]
            if other not in closed and g < cost.get(other, math.inf):
                cost[other], entered = g, entered + 1
                priority = function(g, math.dist(points[other], points[goal]))
                if priority is None:
                    raise TypeError("it returned None; perhaps a return is missing")
                heapq.heappush(heap, (priority, entered, other))
    return order


def _with_clear_test(function: Function, arguments: list[Any]) -> Any:
    """Call the function with a path and a test whether a segment is clear of boxes."""
    path, boxes = arguments
    return function([tuple(point) for point in path], partial(_is_clear, boxes))


def _is_clear(boxes: list[Any], a: Any, b: Any) -> bool:
    return not segment_meets_any(a, b, boxes)


def _with_tuples(value: Any) -> Any:
    """Convert lists of numbers, such as points, to tuples; lists of lists stay lists."""
    if isinstance(value, list):
        inner = [_with_tuples(part) for part in value]
        return inner if inner and isinstance(inner[0], tuple) else tuple(inner)
    return value


CALLERS: Mapping[str, Callable[[Function, list[Any]], Any]] = MappingProxyType(
    {"alone": _alone, "search": _in_search, "clear_test": _with_clear_test}
)
"""The callers by name."""
