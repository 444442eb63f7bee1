"""Graph, ends and heuristic as the compiled searches take them, and the path that results.

A*'s heuristic is the length of the shortest path to the goal in the empty lattice. Compiled by
numba, or with its caller; it runs uncompiled too. A primitive is a row of numbers, see
``abi.obstacles.primitive_kernels``; a mesh is described in ``abi.tet_mesh.adjacency_kernels``.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.compilation.jitable import jitable
from abi.compiled import FLAGS, FLOATS, IDS, compiled
from abi.obstacles.primitive_tree_kernels import blocked
from abi.obstacles.vector_kernels import Vec3, distance, vec3_at
from abi.tet_mesh.adjacency_kernels import (
    CSR,
    KUHN,
    NO_ADJACENCY,
    Adjacency,
    MeshSizes,
    half_cells_within,
    node_at,
    row_place,
    y_and_z_origins,
)

NONE, INSIDE, ON_A_FACE = 0, 1, 2


class Metric(NamedTuple):
    """Data of A*'s heuristic: the goal, and what the edges of a lattice's cell cost.

    Attributes:
        kind: ``NONE`` for Dijkstra's algorithm; ``ON_A_FACE`` where the goal is on a face of the
            box, else ``INSIDE``.
        goal: in half cells; of rows [unit], world.
        axes: costs along x, y and z; of rows the cost of a unit of length, three times.
        faces: of the diagonals across yz, xz and xy, where there are any.
        diagonal: of the whole diagonal, where there is one.
        centres: of the way by the cell's centre from corner to corner.
    """

    kind: int
    goal: Vec3
    axes: Vec3
    faces: Vec3
    diagonal: float
    centres: float


ZERO = (0.0, 0.0, 0.0)

NO_METRIC = Metric(NONE, ZERO, ZERO, ZERO, 0.0, 0.0)
"""That of Dijkstra's algorithm."""


@jitable(forceinline=True)
def to_go(shape: MeshSizes, metric: Metric, place: Vec3) -> float:
    """Lower bound of the cost from a place to the goal; the place is given as the goal is.

    For rows the straight line. In a lattice the cost of the steps that lead there, which is exact
    where nothing is in the way. Two things remain of the box around ``bcc``: its faces have
    diagonals that the inside has not. Whoever uses a face goes to it and back, which is as far as
    to the goal's image in the face, and pays at least the norm that has all diagonals. On the face
    goal and image are as far. So the least of all four ways never changes along an edge by more
    than the edge costs. A goal on a face is its own image there, and no way is then shorter.
    """
    kind, goal, axes, _, _, _ = metric
    x, y, z = place[0] - goal[0], place[1] - goal[1], place[2] - goal[2]
    if shape.kind == CSR:
        return math.sqrt(x * x + y * y + z * z) * axes[0]
    x, y, z = 0.5 * x, 0.5 * y, 0.5 * z
    if shape.kind == KUHN:
        return _with_diagonals(metric, max(x, 0.0), max(y, 0.0), max(z, 0.0)) + _with_diagonals(
            metric, max(-x, 0.0), max(-y, 0.0), max(-z, 0.0)
        )
    x, y, z = abs(x), abs(y), abs(z)
    if kind == ON_A_FACE:
        return _with_diagonals(metric, x, y, z)
    u, v, w = 0.5 * (place[0] + goal[0]), 0.5 * (place[1] + goal[1]), 0.5 * (place[2] + goal[2])
    u, v, w = min(u, 2 * shape.nx - u), min(v, 2 * shape.ny - v), min(w, 2 * shape.nz - w)
    return min(
        min(_by_centres(metric, x, y, z), _with_diagonals(metric, u, y, z)),
        min(_with_diagonals(metric, x, v, z), _with_diagonals(metric, x, y, w)),
    )


@jitable
def _by_centres(metric: Metric, x: float, y: float, z: float) -> float:
    """Least cost of a step of x, y, z >= 0 cells along the axes and by way of centres.

    By way of t pairs of centres one gets up to t along each axis, and the rest along the axes. That
    is convex in t and least at the second or the third largest of x, y and z.
    """
    low = min(x, min(y, z))
    middle = x + y + z - low - max(x, max(y, z))
    p, q, r = metric.axes
    few = low * metric.centres + (x - low) * p + (y - low) * q + (z - low) * r
    many = middle * metric.centres
    many += max(x - middle, 0.0) * p + max(y - middle, 0.0) * q + max(z - middle, 0.0) * r
    return min(few, many)


@jitable
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
    axes, faces = metric.axes, metric.faces
    axis = axes[1] if high == y else axes[0]
    axis = axes[2] if high == z else axis
    face = faces[1] if low == y else faces[2]
    face = faces[0] if low == x else face
    middle = x + y + z - low - high
    return low * metric.diagonal + (middle - low) * face + (high - middle) * axis


LITTLE = 1e-11
"""Part of the largest weight by which a cost must fall to be worth it."""


class Problem(NamedTuple):
    """A graph, and the path that is searched in it.

    Attributes:
        adjacency: the mesh.
        open_directions: (n,) as bits, and ``LINKED_BIT``, the only bit of rows.
        weights: of the directions (d,), or of the edges of the rows (2 e,), inf where shut.
        tails, heads, link_weights: (m,) ends and weights of the edges of start and goal where
            these are no nodes of the mesh; they then have the ids that follow those of the mesh.
        start, goal: node ids.
        own: how many of the two are no nodes of the mesh.
        largest: an upper bound of the weights, above 0; the estimates of nodes one edge away
            from the same node differ by at most four times as much.
        metric: the heuristic.
    """

    adjacency: Adjacency
    open_directions: IntArray
    weights: FloatArray
    tails: IntArray
    heads: IntArray
    link_weights: FloatArray
    start: int
    goal: int
    own: int
    largest: float
    metric: Metric


EXAMPLE = (Problem(NO_ADJACENCY, IDS, FLOATS, IDS, IDS, FLOATS, 0, 0, 1, 1.0, NO_METRIC),)
"""Example of a problem, for the compiler."""


@compiled(example=(IDS, 1))
def reconstruct_path(parent: IntArray, goal: int) -> IntArray:
    """Nodes (k,) from the start, whose parent is -1, to the goal; by their parents (n,)."""
    count = 1
    node = parent[goal]
    while node >= 0:
        count += 1
        node = parent[node]
    found = np.empty(count, np.int32)
    node = goal
    for k in range(count - 1, -1, -1):
        found[k] = node
        node = parent[node]
    return found


@compiled(example=(IDS, FLOATS, FLOATS))
def places_along(
    path: IntArray, places: FloatArray, own: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Places (3 k,) of a path's nodes (k,), and lengths (k - 1,) of its edges, [unit], world.

    By the places of the mesh's nodes (3 n,), and of start and goal that are no nodes of it.
    """
    points, lengths = np.empty(3 * len(path)), np.empty(len(path) - 1)
    for k in range(3 * len(path)):
        at = 3 * path[k // 3] + k % 3
        points[k] = places[at] if at < len(places) else own[at - len(places)]
    for k in range(len(lengths)):
        lengths[k] = distance(vec3_at(points, 3 * k + 3), vec3_at(points, 3 * k))
    return points, lengths


@compiled(example=(NO_ADJACENCY, FLOATS, FLOATS, FLAGS, (0.0, 0.0, 0.0), 0.0))
def visible_nodes(
    adjacency: Adjacency,
    primitives: FloatArray,
    margins: FloatArray,
    excluded: BoolArray,
    point: Vec3,
    reach: float,
) -> tuple[IntArray, FloatArray]:
    """The nodes that a point sees.

    Args:
        adjacency: the mesh.
        primitives: (k WIDTH,) rows, one after the other.
        margins: (k,) distance from the primitives that a line of sight keeps, [unit].
        excluded: (n,) nodes that do not count.
        point: [unit], world.
        reach: how far it looks, [unit].

    Returns:
        Nodes (m,) and the distances to them, [unit].
    """
    shape, _, _, places, _, _ = adjacency
    y0, z0 = y_and_z_origins(shape)
    rows = shape.kind == CSR
    low = (point[0] - reach, point[1] - reach, point[2] - reach)
    high = (point[0] + reach, point[1] + reach, point[2] + reach)
    found = 0
    nodes = np.empty(128, np.int32)
    distances = np.empty(128, np.float64)
    for odd in range(2 if shape.cross else 1):
        (a0, a1), (b0, b1), (c0, c1) = (0, 2 * shape.nodes - 2), (0, 0), (0, 0)
        if not rows:
            (a0, a1), (b0, b1), (c0, c1) = half_cells_within(shape, places, low, high, odd)
        for a in range(a0, a1 + 1, 2):
            for b in range(b0, b1 + 1, 2):
                for c in range(c0, c1 + 1, 2):
                    if rows:
                        node = a >> 1
                        place = row_place(places, shape.nodes, node)
                    else:
                        node = node_at(shape, a, b, c)
                        place = (places[a], places[y0 + b], places[z0 + c])
                    away = distance(place, point)
                    if away > reach or excluded[node]:
                        continue
                    if blocked(primitives, margins, 0, point, place):
                        continue
                    if found == len(nodes):
                        nodes = np.concatenate((nodes, np.empty_like(nodes)))
                        distances = np.concatenate((distances, np.empty_like(distances)))
                    nodes[found] = node
                    distances[found] = away
                    found += 1
    return nodes[:found], distances[:found]
