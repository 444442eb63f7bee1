"""A path pulled taut between convex solids, and others that go round these by their edges."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable

from abi.arrays import FloatArray, IntArray
from abi.compiled import FLOATS, IDS, compiled
from abi.obstacles.vector_kernels import Vec3, vec3_at
from abi.taut.free_space_kernels import SPACE, FreeSpace
from abi.taut.tighten_kernels import length_of, tighten
from abi.taut.visibility_graph_kernels import places, ways

_SAME = 1e-6  # parts of the length: nearer than this two strings are one,
_CLOSE = 2e-4  # and as near as this either may be the shorter one once its corners are cut


class Effort(NamedTuple):
    """How much is tried.

    Attributes:
        samples: places evenly apart on each edge.
        slack: how many times as long as the shortest so far a way by places may be.
        ways: how many of these are looked at.
        worth: part of the length that a cut corner must win.
    """

    samples: int
    slack: float
    ways: int
    worth: float


@register_jitable
def _shortest(lengths: list[float]) -> list[int]:
    """The shortest path, after that which is close behind, if there is one."""
    best, second = 0, -1
    for k in range(len(lengths)):
        if lengths[k] < lengths[best]:
            best = k
    for k in range(len(lengths)):
        behind = lengths[k] - lengths[best]
        if _SAME * lengths[best] < behind < _CLOSE * lengths[best] and (
            second < 0 or lengths[k] < lengths[second]
        ):
            second = k
    return [second, best] if second >= 0 else [best]


@register_jitable
def _add(path: list[Vec3], points: list[Vec3], ends: list[int], lengths: list[float]) -> None:
    """Put a path behind others."""
    points.extend(path)
    ends.append(len(points))
    lengths.append(length_of(path))


@compiled(example=(FLOATS, IDS, FLOATS, SPACE, Effort(1, 1.0, 1, 1e-6)))
def pull(
    given: FloatArray, begins: IntArray, edges: FloatArray, space: FreeSpace, effort: Effort
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Tighten paths, and the shortest ways by places on the edges; cut the corners of the best.

    Where two are nearly as short, those of both are cut.

    Args:
        given: the paths, one after the other, all between the same ends, of two points or more,
            their segments clear, flat (3 n,), [unit], world.
        begins: index of the point where each begins, and where the last ends (q + 1,), q >= 1.
        edges: both ends of each edge, one after the other, flat (6 e,), [unit], world.
        space: free space.
        effort: how much is tried.

    Returns:
        The new paths, one after the other (m, 3), [unit], world; where each begins, and where the
        last ends (p + 1,); and their lengths (p,), [unit].
    """
    start, goal = vec3_at(given, 0), vec3_at(given, len(given) - 3)
    points, ends, lengths = [start][:0], [0], [0.0] * 0
    for k in range(len(begins) - 1):
        path = [vec3_at(given, 3 * i) for i in range(begins[k], begins[k + 1])]
        _add(tighten(path, space, math.inf), points, ends, lengths)
    most = effort.slack * min(lengths)
    spots, labels = places(edges, start, goal, effort.samples, most, space)
    path = [start][:0]
    for node in ways(spots, labels, space, most, effort.ways):
        path.append(spots[node])
        if node == 1:
            if length_of(path) <= effort.slack * min(lengths):
                _add(tighten(path, space, math.inf), points, ends, lengths)
            path.clear()
    for k in _shortest(lengths):
        path = points[ends[k] : ends[k + 1]]
        _add(tighten(path, space, effort.worth), points, ends, lengths)
    return np.array(points), np.array(ends), np.array(lengths)
