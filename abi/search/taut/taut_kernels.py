"""Taut paths between convex solids, from given paths and from short ones along solids' edges."""

from __future__ import annotations

import math

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, IDS, compiled
from abi.obstacles.vector_kernels import Vec3, vec3_at
from abi.search.taut.free_space_kernels import SPACE, FreeSpace
from abi.search.taut.tighten_kernels import length_of, tighten
from abi.search.taut.visibility_graph_kernels import PathSearchEffort, edge_waypoints, short_paths

_SAME = 1e-6  # part of the length: two paths that differ by less are the same one,
_CLOSE = 2e-4  # by less than this, either may be the shorter once its corners are cut


@jitable
def _shortest(lengths: list[float]) -> list[int]:
    """Index of the shortest path, before it that of the second if it is nearly as short."""
    best, second = 0, -1
    for k in range(len(lengths)):
        if lengths[k] < lengths[best]:
            best = k
    for k in range(len(lengths)):
        excess = lengths[k] - lengths[best]
        if _SAME * lengths[best] < excess < _CLOSE * lengths[best] and (
            second < 0 or lengths[k] < lengths[second]
        ):
            second = k
    return [second, best] if second >= 0 else [best]


@jitable
def _add(path: list[Vec3], points: list[Vec3], ends: list[int], lengths: list[float]) -> None:
    """Append a path to packed paths."""
    points.extend(path)
    ends.append(len(points))
    lengths.append(length_of(path))


@compiled(example=(FLOATS, IDS, FLOATS, SPACE, PathSearchEffort(1, 1.0, 1, 1e-6, 1.0, 1)))
def taut_paths(
    given: FloatArray,
    begins: IntArray,
    edges: FloatArray,
    space: FreeSpace,
    effort: PathSearchEffort,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Tighten paths, and short ones by waypoints on the edges; cut the corners of the best.

    Where two are nearly as short, the corners of both are cut.

    Args:
        given: the paths, one after the other, all between the same ends, of two points or more,
            their segments clear, flat (3 n,), [unit], world.
        begins: index of the point where each begins, and where the last ends (q + 1,), q >= 1.
        edges: both ends of each edge, one after the other, flat (12 e,), see
            ``obstacle_edges``.
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
    waypoints, labels = edge_waypoints(edges, start, goal, effort.samples, most, space)
    path = [start][:0]
    for node in short_paths(waypoints, labels, edges, space, most, effort):
        path.append(waypoints[node])
        if node == 1:
            if length_of(path) <= effort.slack * min(lengths):
                _add(tighten(path, space, math.inf), points, ends, lengths)
            path.clear()
    for k in _shortest(lengths):
        path = points[ends[k] : ends[k + 1]]
        _add(tighten(path, space, effort.least_gain), points, ends, lengths)
    return np.array(points), np.array(ends), np.array(lengths)
