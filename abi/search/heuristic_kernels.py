"""The length of the shortest way to the goal where nothing is in the way: A*'s heuristic.

Plain Python that numba compiles with its caller.

A metric is a tuple of numbers: 1, 2 for a goal on a face of the box, or 0 for none; the cost of a
cell along x, y and z; twice the cost of the way from a corner to a centre; the goal (3), in half
cells or for rows [unit], world; where there are all diagonals, the cost along x, y and z, of the
diagonals across xy, xz and yz, and of the whole diagonal.
"""

from __future__ import annotations

import math

from numba.extending import register_jitable

from abi.tet_mesh.adjacency_kernels import KUHN, ROWS, Shape

Metric = tuple[float, ...]

NO_METRIC: Metric = (0.0,) * 15
"""That of Dijkstra's algorithm."""

ON_A_FACE = 2.0
"""How the metric begins where the goal is on a face of the box."""


@register_jitable
def to_go(shape: Shape, metric: Metric, a: float, b: float, c: float) -> float:
    """A bound from below of the cost from a place to the goal; the place as the goal is given.

    For rows the straight line. In a lattice the cost of the steps that lead there, which is exact
    where nothing is in the way. Two things remain of the box around ``bcc``: its faces have
    diagonals that the inside has not. Whoever uses a face goes to it and back, which is as far as
    to the goal's image in the face, and pays at least the norm that has all diagonals. On the face
    goal and image are as far. So the least of all four ways never changes along an edge by more
    than the edge costs. A goal on a face is its own image there, and no way is then shorter.
    """
    if shape[0] == ROWS:
        x, y, z = a - metric[5], b - metric[6], c - metric[7]
        return math.sqrt(x * x + y * y + z * z) * metric[1]
    x, y, z = 0.5 * (a - metric[5]), 0.5 * (b - metric[6]), 0.5 * (c - metric[7])
    if shape[0] == KUHN:
        return _with_diagonals(metric, max(x, 0.0), max(y, 0.0), max(z, 0.0)) + _with_diagonals(
            metric, max(-x, 0.0), max(-y, 0.0), max(-z, 0.0)
        )
    x, y, z = abs(x), abs(y), abs(z)
    if metric[0] == ON_A_FACE:
        return _with_diagonals(metric, x, y, z)
    u, v, w = 0.5 * (a + metric[5]), 0.5 * (b + metric[6]), 0.5 * (c + metric[7])
    u, v, w = min(u, 2 * shape[1] - u), min(v, 2 * shape[2] - v), min(w, 2 * shape[3] - w)
    return min(
        min(_by_centres(metric, x, y, z), _with_diagonals(metric, u, y, z)),
        min(_with_diagonals(metric, x, v, z), _with_diagonals(metric, x, y, w)),
    )


@register_jitable
def _by_centres(metric: Metric, x: float, y: float, z: float) -> float:
    """Least cost of a step of x, y, z >= 0 cells along the axes and by way of centres.

    By way of t pairs of centres one gets up to t along each axis, and the rest along the axes. That
    is convex in t and least at the second or the third largest of x, y and z.
    """
    low = min(x, min(y, z))
    middle = x + y + z - low - max(x, max(y, z))
    p, q, r = metric[1], metric[2], metric[3]
    few = low * metric[4] + (x - low) * p + (y - low) * q + (z - low) * r
    many = middle * metric[4]
    many += max(x - middle, 0.0) * p + max(y - middle, 0.0) * q + max(z - middle, 0.0) * r
    return min(few, many)


@register_jitable
def _with_diagonals(metric: Metric, x: float, y: float, z: float) -> float:
    """Least cost of a step of x, y, z >= 0 cells along the axes and all diagonals of the cells.

    The cost of a set of axes, its diagonal, is submodular; so this is its Lovász extension (Lovász,
    Submodular functions and convexity, 1983): as far as the shortest goes by the cells' diagonals,
    then by those of the face of the other two, and the rest along the longest.
    """
    # not by min and max, which look for NaN too
    low, high = (x, y) if x < y else (y, x)
    low = z if z < low else low
    high = z if z > high else high
    axis = metric[9] if high == y else metric[8]
    axis = metric[10] if high == z else axis
    face = metric[12] if low == y else metric[11]
    face = metric[13] if low == x else face
    middle = x + y + z - low - high
    return low * metric[14] + (middle - low) * face + (high - middle) * axis
