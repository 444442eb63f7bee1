"""A*'s heuristic: the length of the shortest path to the goal in the empty lattice.

Plain Python that numba compiles with its caller.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from abi.compilation.jitable import jitable
from abi.obstacles.vector_kernels import Vec3
from abi.tet_mesh.adjacency_kernels import CSR, KUHN, MeshSizes

NONE, INSIDE, ON_A_FACE = 0, 1, 2


class Norm(NamedTuple):
    """Costs of a cell of a lattice.

    Attributes:
        axes: along x, y and z; of rows the cost of a unit of length, three times.
        faces: of the diagonals across yz, xz and xy, where there are any.
        diagonal: of the whole diagonal, where there is one.
        centres: of the way by the cell's centre from corner to corner.
    """

    axes: Vec3
    faces: Vec3
    diagonal: float
    centres: float


class Metric(NamedTuple):
    """A heuristic towards a goal.

    Attributes:
        kind: ``NONE`` for Dijkstra's algorithm; ``ON_A_FACE`` where the goal is on a face of the
            box, else ``INSIDE``.
        norm: the costs of a cell.
        goal: in half cells; of rows [unit], world.
    """

    kind: int
    norm: Norm
    goal: Vec3


_ZERO = (0.0, 0.0, 0.0)

NO_METRIC = Metric(NONE, Norm(_ZERO, _ZERO, 0.0, 0.0), _ZERO)
"""That of Dijkstra's algorithm."""


@jitable(forceinline=True)
def to_go(shape: MeshSizes, metric: Metric, place: Vec3) -> float:
    """A bound from below of the cost from a place to the goal; the place as the goal is given.

    For rows the straight line. In a lattice the cost of the steps that lead there, which is exact
    where nothing is in the way. Two things remain of the box around ``bcc``: its faces have
    diagonals that the inside has not. Whoever uses a face goes to it and back, which is as far as
    to the goal's image in the face, and pays at least the norm that has all diagonals. On the face
    goal and image are as far. So the least of all four ways never changes along an edge by more
    than the edge costs. A goal on a face is its own image there, and no way is then shorter.
    """
    kind, norm, goal = metric
    x, y, z = place[0] - goal[0], place[1] - goal[1], place[2] - goal[2]
    if shape.kind == CSR:
        return math.sqrt(x * x + y * y + z * z) * norm.axes[0]
    x, y, z = 0.5 * x, 0.5 * y, 0.5 * z
    if shape.kind == KUHN:
        return _with_diagonals(norm, max(x, 0.0), max(y, 0.0), max(z, 0.0)) + _with_diagonals(
            norm, max(-x, 0.0), max(-y, 0.0), max(-z, 0.0)
        )
    x, y, z = abs(x), abs(y), abs(z)
    if kind == ON_A_FACE:
        return _with_diagonals(norm, x, y, z)
    u, v, w = 0.5 * (place[0] + goal[0]), 0.5 * (place[1] + goal[1]), 0.5 * (place[2] + goal[2])
    u, v, w = min(u, 2 * shape.nx - u), min(v, 2 * shape.ny - v), min(w, 2 * shape.nz - w)
    return min(
        min(_by_centres(norm, x, y, z), _with_diagonals(norm, u, y, z)),
        min(_with_diagonals(norm, x, v, z), _with_diagonals(norm, x, y, w)),
    )


@jitable
def _by_centres(norm: Norm, x: float, y: float, z: float) -> float:
    """Least cost of a step of x, y, z >= 0 cells along the axes and by way of centres.

    By way of t pairs of centres one gets up to t along each axis, and the rest along the axes. That
    is convex in t and least at the second or the third largest of x, y and z.
    """
    low = min(x, min(y, z))
    middle = x + y + z - low - max(x, max(y, z))
    p, q, r = norm.axes
    few = low * norm.centres + (x - low) * p + (y - low) * q + (z - low) * r
    many = middle * norm.centres
    many += max(x - middle, 0.0) * p + max(y - middle, 0.0) * q + max(z - middle, 0.0) * r
    return min(few, many)


@jitable
def _with_diagonals(norm: Norm, x: float, y: float, z: float) -> float:
    """Least cost of a step of x, y, z >= 0 cells along the axes and all diagonals of the cells.

    The cost of a set of axes, its diagonal, is submodular; so this is its Lovász extension (Lovász,
    Submodular functions and convexity, 1983): as far as the shortest goes by the cells' diagonals,
    then by those of the face of the other two, and the rest along the longest.
    """
    # not by min and max, which look for NaN too
    low, high = (x, y) if x < y else (y, x)
    low = z if z < low else low
    high = z if z > high else high
    axes, faces = norm.axes, norm.faces
    axis = axes[1] if high == y else axes[0]
    axis = axes[2] if high == z else axis
    face = faces[1] if low == y else faces[2]
    face = faces[0] if low == x else face
    middle = x + y + z - low - high
    return low * norm.diagonal + (middle - low) * face + (high - middle) * axis
