"""Taut paths between convex solids, from given paths and from short ones along solids' edges.

The short ones are found in a visibility graph. Plain Python that numba compiles with its caller;
uncompiled it runs on lists. Waypoints are in [unit], world.
"""

from __future__ import annotations

import math

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, IDS, compiled
from abi.obstacles.primitive_kernels import WIDTH
from abi.obstacles.primitive_tree_kernels import any_within, blocker
from abi.obstacles.vector_kernels import Vec3, axpy, distance, dot, sub, vec3_at
from abi.search.taut.tighten_kernels import (
    SPACE,
    FreeSpace,
    in_bounds,
    is_clear,
    kind_of,
    length_of,
    tighten,
)

_SUPPORT = 0.02  # the part of a squared length that counts as none: edges are round, in fact
_SLACK = 1.015  # ratio to the shortest length so far up to which a path by waypoints is tightened
_LEAST_GAIN = 5e-6  # part of the length that a cut corner must gain


@jitable
def _best_share(p: Vec3, edge: Vec3, a: Vec3, b: Vec3) -> float:
    """Part of an edge from p at which the path from a by the edge to b is shortest."""
    squared_length = dot(edge, edge)
    if squared_length == 0:
        return 0.0
    # the path by a line is shortest where the mirror image of one end about it is in line
    foot_a, foot_b = dot(sub(a, p), edge) / squared_length, dot(sub(b, p), edge) / squared_length
    off_a, off_b = distance(a, axpy(foot_a, edge, p)), distance(b, axpy(foot_b, edge, p))
    if off_a + off_b == 0:
        return 0.0
    return min(max((foot_a * off_b + foot_b * off_a) / (off_a + off_b), 0.0), 1.0)


@jitable
def edge_waypoints(
    edges: FloatArray, start: Vec3, goal: Vec3, samples: int, most: float, space: FreeSpace
) -> tuple[list[Vec3], list[int]]:
    """Start, goal, and points on edges by which a path between them may be short.

    On each edge: ``samples`` points evenly apart, and the one by which the path between the ends is
    shortest; those that keep the general margin, lie in the box and are not too far off.

    Args:
        edges: (12 e,) both ends of each and the normals of its faces, [unit], world.
        start: start.
        goal: goal.
        samples: number on each edge.
        most: length that a path from start to goal by a waypoint must be below, [unit].
        space: free space.

    Returns:
        The waypoints (n,), and numbers of their edges (n,).
    """
    margin = 0.0
    for s in range(len(space.margins) // 4):
        margin = max(margin, space.margins[s])
    waypoints, labels = [start, goal], [-1, -1]
    for e in range(len(edges) // 12):
        p = vec3_at(edges, 12 * e)
        edge = sub(vec3_at(edges, 12 * e + 3), p)
        best = _best_share(p, edge, start, goal)
        q = axpy(best, edge, p)
        if distance(q, start) + distance(q, goal) >= most:
            continue
        for k in range(samples + 1 if dot(edge, edge) > 0 else 1):
            q = axpy(best if k == 0 else k / (samples + 1), edge, p)
            if (
                in_bounds(space, q)
                and distance(q, start) + distance(q, goal) < most
                and not any_within(space.solids, margin, q)
            ):
                waypoints.append(q)
                labels.append(e)
    return waypoints, labels


@jitable
def _same_labels(parent: list[int], labels: list[int], node: int, other: int) -> bool:
    """Check whether the paths to two waypoints go by the same labels, repeats counted once."""
    while True:
        if labels[node] != labels[other]:
            return False
        label = labels[node]
        while node != 0 and labels[node] == label:
            node = parent[node]
        while other != 0 and labels[other] == label:
            other = parent[other]
        if node == 0 or other == 0:
            return node == other


@jitable
def _reconstruct_paths(parent: list[int], lasts: list[int]) -> list[int]:
    """The paths from 0 to 1 whose last waypoints are ``lasts``, one after the other."""
    nodes = [0] * 0
    for last in lasts:
        path = [1, last]
        while path[-1] != 0:
            path.append(parent[path[-1]])
        nodes.extend(path[::-1])
    return nodes


@jitable
def _supports(edges: FloatArray, label: int, d: Vec3) -> bool:
    """Check whether a line in direction d can touch an edge without entering its solid.

    A shortest path enters and leaves an edge only along such lines.
    """
    if label < 0:
        return True
    n, m = vec3_at(edges, 12 * label + 6), vec3_at(edges, 12 * label + 9)
    result: bool = dot(n, d) * dot(m, d) <= _SUPPORT * dot(d, d)
    return result


@jitable
def short_paths(
    waypoints: list[Vec3],
    labels: list[int],
    edges: FloatArray,
    space: FreeSpace,
    most: float,
    paths: int,
    weight: float,
    sights: int,
) -> list[int]:
    """Short paths from the first waypoint to the second by waypoints that see each other.

    A* on the visibility graph: of the shortest paths to each waypoint that sees the second, the
    first in order of length that go by other labels than those before. The first of all is the
    shortest path there is, up to the weight. Whether two waypoints see each other is tested only
    where it matters, and not where the line between them would enter the solid of an edge.

    Args:
        waypoints: n >= 2.
        labels: (n,) edges of the waypoints, from the third on; negative ones are of none.
        edges: (12 e,) both ends of each and the normals of its faces, [unit], world.
        space: free space.
        most: length that the paths must be below, [unit].
        paths, weight, sights: as for :func:`taut_paths`.

    Returns:
        Indices of the paths, one after the other, each from 0 to 1 (m,); empty when there is none.
    """
    solids, margins = space.solids, space.margins
    cost = [math.inf] * len(waypoints)
    parent = [0] * len(waypoints)
    to_go = [distance(waypoint, waypoints[1]) for waypoint in waypoints]
    unexpanded = list(range(2, len(waypoints)))
    lasts = [0] * 0
    guess = -1
    node, cost[0] = 0 if to_go[0] < most else -1, 0.0
    while node >= 0 and len(lasts) < paths and sights > 0:
        here, so_far = waypoints[node], cost[node]
        if _supports(edges, labels[node], sub(waypoints[1], here)) and is_clear(
            space, kind_of(node, 1, 1), here, waypoints[1]
        ):
            new = True
            for other in lasts:
                if _same_labels(parent, labels, node, other):
                    new = False
            if new:
                lasts.append(node)
        first = kind_of(node, 0, 1) * (len(solids) // WIDTH)
        last, node, at, least = node, -1, 0, math.inf
        for k in range(len(unexpanded)):
            i = unexpanded[k]
            through = so_far + distance(here, waypoints[i])
            d = sub(waypoints[i], here)
            if (
                through < cost[i]
                and through + to_go[i] < most
                and _supports(edges, labels[last], d)
                and _supports(edges, labels[i], d)
            ):
                sights -= 1
                # a solid that blocked one line is likely to block the next one too
                blocking = blocker(solids, margins, first, guess, here, waypoints[i])
                if blocking >= 0:
                    guess = blocking
                else:
                    cost[i] = through
                    parent[i] = last
            if cost[i] + weight * to_go[i] < least:
                node, at, least = i, k, cost[i] + weight * to_go[i]
        if node >= 0:
            unexpanded[at] = unexpanded[len(unexpanded) - 1]
            unexpanded.pop()
    return _reconstruct_paths(parent, lasts)


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


@compiled(example=(FLOATS, IDS, FLOATS, SPACE, 1, 1, 1.0, 1))
def taut_paths(
    given: FloatArray,
    begins: IntArray,
    edges: FloatArray,
    space: FreeSpace,
    samples: int,
    paths: int,
    weight: float,
    sights: int,
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
        samples: waypoints evenly apart on each edge.
        paths: number of paths by waypoints.
        weight: of the distance to go in the search for such paths; they may be longer by that.
        sights: lines of sight that this search may test; what was found until then counts.

    Returns:
        The new paths, one after the other (m, 3), [unit], world; where each begins, and where the
        last ends (p + 1,); and their lengths (p,), [unit].
    """
    start, goal = vec3_at(given, 0), vec3_at(given, len(given) - 3)
    points, ends, lengths = [start][:0], [0], [0.0] * 0
    for k in range(len(begins) - 1):
        path = [vec3_at(given, 3 * i) for i in range(begins[k], begins[k + 1])]
        _add(tighten(path, space, math.inf), points, ends, lengths)
    most = _SLACK * min(lengths)
    waypoints, labels = edge_waypoints(edges, start, goal, samples, most, space)
    path = [start][:0]
    for node in short_paths(waypoints, labels, edges, space, most, paths, weight, sights):
        path.append(waypoints[node])
        if node == 1:
            if length_of(path) <= _SLACK * min(lengths):
                _add(tighten(path, space, math.inf), points, ends, lengths)
            path.clear()
    for k in _shortest(lengths):
        path = points[ends[k] : ends[k + 1]]
        _add(tighten(path, space, _LEAST_GAIN), points, ends, lengths)
    return np.array(points), np.array(ends), np.array(lengths)
