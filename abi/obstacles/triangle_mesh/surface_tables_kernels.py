"""A surface as kernels take it: its tables, its grid of signed distances, its place in the world.

What is asked in the world is answered in the surface's body frame: centred on its bounding box, in
the unit of its file.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.compilation.borrowed import borrowed, held
from abi.compilation.jitable import jitable
from abi.compilation.plain import kept_lists
from abi.compiled import FLOATS, compiled
from abi.obstacles.primitive_kernels import Axes, in_body
from abi.obstacles.triangle_mesh.bvh import NO_DIPOLES, NO_TREE, Dipoles, TriangleTree
from abi.obstacles.triangle_mesh.segment_kernels import near_triangle
from abi.obstacles.triangle_mesh.triangle_kernels import DEPTH, is_inside, nearest_triangle
from abi.obstacles.vector_kernels import Vec3, sub

_TOUCHING = 1e-9
"""Part of the surface's size and a step that counts as touching it."""

_SHORT = 1 / 16
"""Part of a value by which it may be too near to 0, beyond the slack: far away, all of a round
surface is about as near, and the nearest triangle takes long to find."""


class DistanceGrid(NamedTuple):
    """A signed distance s at the nodes of a grid around a surface.

    s is 1-Lipschitz, so between its value at any node g and at a point x

        s(g) - |x - g| <= s(x) <= s(g) + |x - g|.

    A value may be too large, without its sign, by the slack, and too small by the slack and 1/16 of
    itself.

    Attributes:
        values: signed distances, flat, those along z one after the other.
        counts: numbers of nodes along x, y and z, each at least 2.
        low: first node.
        step: distance between neighbouring nodes, the same along each axis.
        box: low and high corner of the surface; outside, s is at least the distance to the box.
        slack: see above.
    """

    values: FloatArray
    counts: tuple[int, int, int]
    low: Vec3
    step: float
    box: tuple[Vec3, Vec3]
    slack: float


NO_GRID = DistanceGrid(
    FLOATS, (2, 2, 2), (0.0, 0.0, 0.0), 1.0, ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), 0.0
)
"""In an example: a grid."""


@jitable
def distance_bounds(grid: DistanceGrid, x: Vec3) -> tuple[float, float]:
    """Lower and upper bound of the signed distance at a point, from the eight nodes around it."""
    values, (nx, ny, nz), low, step, (inner, outer), slack = grid
    a = max(inner[0] - x[0], x[0] - outer[0], 0.0)
    b = max(inner[1] - x[1], x[1] - outer[1], 0.0)
    c = max(inner[2] - x[2], x[2] - outer[2], 0.0)
    beyond = a * a + b * b + c * c
    lower = math.sqrt(beyond) if beyond > 0.0 else -math.inf
    upper = math.inf
    u, v, w = (x[0] - low[0]) / step, (x[1] - low[1]) / step, (x[2] - low[2]) / step
    i = int(min(max(u, 0.0), nx - 2.0))
    j = int(min(max(v, 0.0), ny - 2.0))
    k = int(min(max(w, 0.0), nz - 2.0))
    u, v, w = u - i, v - j, w - k
    node = (i * ny + j) * nz + k
    for p in range(2):
        for q in range(2):
            aside = (u - p) * (u - p) + (v - q) * (v - q)
            at = node + (p * ny + q) * nz
            for r in range(2):
                away = step * math.sqrt(aside + (w - r) * (w - r))
                lower = max(lower, values[at + r] - away)
                upper = min(upper, values[at + r] + away)
    # of what all nodes say, too: a bound towards 0 grows by no less than the distance in it
    lower *= 1.0 + _SHORT if lower < 0.0 else 1.0
    upper *= 1.0 + _SHORT if upper > 0.0 else 1.0
    return lower - slack, upper + slack


@jitable
def steepest(grid: DistanceGrid, x: Vec3) -> Vec3:
    """About the direction in which the signed distance grows fastest at a point, a unit vector.

    0 where the nodes around it do not tell.
    """
    values, (nx, ny, nz), low, step, _, _ = grid
    i = int(min(max((x[0] - low[0]) / step, 0.0), nx - 2.0))
    j = int(min(max((x[1] - low[1]) / step, 0.0), ny - 2.0))
    k = int(min(max((x[2] - low[2]) / step, 0.0), nz - 2.0))
    a = (i * ny + j) * nz + k
    b, c, d = a + nz, a + ny * nz, a + ny * nz + nz
    u = values[c] + values[c + 1] + values[d] + values[d + 1]
    u -= values[a] + values[a + 1] + values[b] + values[b + 1]
    v = values[b] + values[b + 1] + values[d] + values[d + 1]
    v -= values[a] + values[a + 1] + values[c] + values[c + 1]
    w = values[a + 1] + values[b + 1] + values[c + 1] + values[d + 1]
    w -= values[a] + values[b] + values[c] + values[d]
    size = math.sqrt(u * u + v * v + w * w) * (1.0 + 1e-12)
    return (u / size, v / size, w / size) if size > 0.0 else (0.0, 0.0, 0.0)


@jitable
def _before(values: FloatArray, place: tuple[int, int, int], strides: tuple[int, int, int]) -> Vec3:
    """Values at the nodes before a node along x, y and z; inf where there are none."""
    i, j, k = place
    at = i * strides[0] + j * strides[1] + k
    return (
        values[at - strides[0]] if i > 0 else math.inf,
        values[at - strides[1]] if j > 0 else math.inf,
        values[at - 1] if k > 0 else math.inf,
    )


@jitable
def _foreseen(before: Vec3, step: float, slack: float) -> tuple[float, float]:
    """Upper bound of a node's distance, and by how much it may be found too large."""
    least, most = 0.0, math.inf
    for value in before:
        if abs(value) < math.inf:
            least = max(least, abs(value) - slack - step)
            most = min(most, abs(value) * (1.0 + _SHORT) + slack + step)
    return most * (1.0 + 1e-9), slack + least * _SHORT / (1.0 + _SHORT)


@jitable
def _side(
    tree: TriangleTree, x: Vec3, free: float, before: Vec3, step: float, waiting: IntArray
) -> int:
    """Check whether a node is inside (1), outside (0), or the nodes before it do not tell (-1).

    One before is on the same side where balls around both that nothing is in overlap, or where
    nothing is between. ``free`` is the radius of the node's, less the slack of the other.
    """
    for value in before:
        if step < abs(value) + free < math.inf:
            return 1 if value < 0.0 else 0
    touching = _TOUCHING * (step + tree.size)
    nodes = (x[0] - step, x[1], x[2]), (x[0], x[1] - step, x[2]), (x[0], x[1], x[2] - step)
    for k in range(3):
        value = before[k]
        if (
            value < math.inf
            and near_triangle(tree, nodes[k], x, touching, (0.0, 0.0, 0.0), waiting) < 0
        ):
            return 1 if value < 0.0 else 0
    return -1


@jitable
def side_of(grid: DistanceGrid, tree: TriangleTree, x: Vec3, waiting: IntArray) -> int:
    """Check whether a point near a closed surface is inside (1), outside (0), or unknown (-1).

    It is on the side of a node around it when nothing is between.
    """
    values, (nx, ny, nz), low, step, _, slack = grid
    i = int(min(max((x[0] - low[0]) / step, 0.0), nx - 2.0))
    j = int(min(max((x[1] - low[1]) / step, 0.0), ny - 2.0))
    k = int(min(max((x[2] - low[2]) / step, 0.0), nz - 2.0))
    touching = _TOUCHING * (step + tree.size)
    for corner in range(8):
        p, q, r = i + corner // 4, j + corner // 2 % 2, k + corner % 2
        value = values[(p * ny + q) * nz + r]
        node = (low[0] + p * step, low[1] + q * step, low[2] + r * step)
        if (
            abs(value) > slack
            and near_triangle(tree, node, x, touching, (0.0, 0.0, 0.0), waiting) < 0
        ):
            return 1 if value < 0.0 else 0
    return -1


@compiled(example=(NO_TREE, NO_DIPOLES, True, (2, 2, 2), (0.0, 0.0, 0.0), 1.0, 0.0))
def grid_values(
    tree: TriangleTree,
    dipoles: Dipoles,
    closed: bool,
    counts: tuple[int, int, int],
    low: Vec3,
    step: float,
    slack: float,
) -> FloatArray:
    """Signed distances at the nodes of a grid, as near as :class:`DistanceGrid` says.

    The nodes before each bound its distance, and mostly tell its side.

    Args:
        tree: over the triangles.
        dipoles: of the nodes of the tree.
        closed: whether the surface has an inside.
        counts, low, step: see :class:`DistanceGrid`.
        slack: see above.
    """
    nx, ny, nz = counts
    strides = (ny * nz, nz, 1)
    values = np.empty(nx * ny * nz)
    own = np.empty(DEPTH, np.int32), np.empty(DEPTH), np.empty(128, np.int32)
    waiting, squares, stack = borrowed(own)
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                x = (low[0] + i * step, low[1] + j * step, low[2] + k * step)
                before = _before(values, (i, j, k), strides)
                most, error = _foreseen(before, step, slack)
                distance, _ = nearest_triangle(tree, x, most, error, waiting, squares)
                side = 0
                if closed:
                    side = -1
                    if distance > error:
                        free = distance - error - slack
                        side = _side(tree, x, free, before, step, waiting)
                    if side < 0:
                        side = 1 if is_inside(tree, dipoles, x, stack) else 0
                distance -= error - slack
                values[i * strides[0] + j * strides[1] + k] = -distance if side == 1 else distance
    held(own)
    return values


SAMPLES = 32
"""Parts into which a segment that enters a solid is cut to bound its depth."""

TOUCHING = 1e-12
"""Part of the surface's size that counts as touching it."""


class SurfaceTables(NamedTuple):
    """A surface as the kernels take it, in its body frame.

    Attributes:
        tree: over its triangles.
        dipoles: of the nodes of the tree.
        grid: signed distances around it.
        closed: whether it has an inside.
        extent: longest side of its bounding box.
        error: bound of the error of a point's distance where that is 0, and of what it grows by
            with the distance.
    """

    tree: TriangleTree
    dipoles: Dipoles
    grid: DistanceGrid
    closed: bool
    extent: float
    error: tuple[float, float]

    def plain(self) -> SurfaceTables:
        """The grid with lists instead of arrays, which are kept as long as it is."""
        return kept_lists(self.grid.values, 0, self)


class Placement(NamedTuple):
    """Pose of the body frame in the world.

    Attributes:
        origin: its origin, [unit], world.
        axes: its axes, in the world.
        factor: scene's [unit] per unit of the body frame.
    """

    origin: Vec3
    axes: Axes
    factor: float


class DescentWorkspace(NamedTuple):
    """Room for descents of a tree.

    Attributes:
        waiting: (``DEPTH``,) nodes.
        squares: (``DEPTH``,) their squared distances.
        stack: (128,) nodes of a tree of dipoles.
        latest: (1,) place of the triangle that the last segment was too near to, or -1: the next
            one, beside it, often is, too.
        nearest: (1,) place of the triangle that the last point was nearest to, or -1.
        samples: (``SAMPLES`` + 1,) signed distances along a segment, or bounds of them from below.
        known: (``SAMPLES`` + 1,) which are no bounds.
    """

    waiting: IntArray
    squares: FloatArray
    stack: IntArray
    latest: IntArray
    nearest: IntArray
    samples: FloatArray
    known: BoolArray


NO_TABLES = SurfaceTables(NO_TREE, NO_DIPOLES, NO_GRID, True, 1.0, (0.0, 0.0))
"""In an example: a surface."""

NO_PLACEMENT = Placement((0.0, 0.0, 0.0), ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), 1.0)
"""In an example: a placement."""


@jitable
def new_room() -> DescentWorkspace:
    """Room for descents."""
    waiting, stack = np.empty(DEPTH, np.int32), np.empty(128, np.int32)
    latest, nearest = np.full(1, -1, np.int32), np.full(1, -1, np.int32)
    samples, known = np.empty(SAMPLES + 1), np.zeros(SAMPLES + 1, np.bool_)
    return DescentWorkspace(waiting, np.empty(DEPTH), stack, latest, nearest, samples, known)


@jitable
def to_surface(placement: Placement, p: Vec3) -> Vec3:
    """A point of the world in the body frame."""
    x, y, z = in_body(placement.axes, sub(p, placement.origin))
    return x / placement.factor, y / placement.factor, z / placement.factor
