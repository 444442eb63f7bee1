"""Any-angle search over the nodes of a mesh, between convex obstacles.

Compiled by numba; it runs uncompiled too, on plain lists. A mesh is described in
``abi.tet_mesh.adjacency_kernels``, a primitive in ``abi.obstacles.primitive_kernels``.

In a lattice every few nodes may be enough: they form a coarser lattice in the middle of the fine
one. Start and goal are its last two nodes.
"""

from __future__ import annotations

import heapq

import numpy as np

from abi.arrays import BoolArray, ByteArray, FloatArray, IntArray
from abi.compilation.jitable import jitable
from abi.compiled import FLAGS, FLOATS, compiled
from abi.obstacles.primitive_kernels import WIDTH
from abi.obstacles.primitive_tree_kernels import blocked
from abi.obstacles.vector_kernels import Vec3, distance
from abi.tet_mesh.adjacency_kernels import (
    CSR,
    INTERIOR_DIRECTIONS,
    NO_ADJACENCY,
    Adjacency,
    MeshSizes,
    cell,
    node_at,
    row_place,
    y_and_z_origins,
)

_POINT = (0.0, 0.0, 0.0)


_Places = tuple[FloatArray, FloatArray, FloatArray]
"""Coordinates x, y and z, (n,) each, [unit], world, of the nodes that are searched."""


@jitable
def _coarse(shape: MeshSizes, stride: int) -> MeshSizes:
    """The mesh that is searched."""
    kind, nx, ny, nz, _, _, directions, cross, most = shape
    if kind == CSR:
        return shape
    nx, ny, nz = nx // stride, ny // stride, nz // stride
    corners = (nx + 1) * (ny + 1) * (nz + 1)
    nodes = corners + (nx * ny * nz if cross else 0)
    return MeshSizes(kind, nx, ny, nz, corners, nodes, directions, cross, most)


@jitable
def _fine(shape: MeshSizes, coarse: MeshSizes, stride: int, node: int) -> tuple[int, int, int]:
    """Place of a node of the coarse lattice in half cells of the fine one."""
    a, b, c = cell(coarse, node)
    return (
        stride * a + (shape.nx - stride * coarse.nx) // 2 * 2,
        stride * b + (shape.ny - stride * coarse.ny) // 2 * 2,
        stride * c + (shape.nz - stride * coarse.nz) // 2 * 2,
    )


@jitable
def _places(
    adjacency: Adjacency,
    coarse: MeshSizes,
    stride: int,
    excluded: BoolArray,
    ends: tuple[Vec3, Vec3],
) -> tuple[FloatArray, FloatArray, FloatArray, ByteArray]:
    """Places x, y, z of all nodes, start and goal the last, and 1 for those that do not count."""
    shape, _, _, places, _, _ = adjacency
    y0, z0 = y_and_z_origins(shape)
    first, last = coarse.nodes, coarse.nodes + 1
    x, y, z = np.empty(last + 1), np.empty(last + 1), np.empty(last + 1)
    closed = np.zeros(last + 1, np.uint8)
    for node in range(coarse.nodes):
        if shape.kind == CSR:
            x[node], y[node], z[node] = row_place(places, shape.nodes, node)
            closed[node] = excluded[node]
        else:
            a, b, c = _fine(shape, coarse, stride, node)
            x[node], y[node], z[node] = places[a], places[y0 + b], places[z0 + c]
            closed[node] = excluded[node_at(shape, a, b, c)]
    x[first], y[first], z[first] = ends[0]
    x[last], y[last], z[last] = ends[1]
    return x, y, z, closed


@jitable(forceinline=True)
def _neighbours(
    coarse: MeshSizes,
    node: int,
    steps: IntArray,
    indptr: IntArray,
    indices: IntArray,
    near: IntArray,
) -> int:
    """Write the neighbours of a node of the mesh to ``near``; their number."""
    count = 0
    if coarse.kind == CSR:
        for k in range(indptr[node], indptr[node + 1]):
            near[count] = indices[k]
            count += 1
        return count
    a, b, c = cell(coarse, node)
    for k in range(INTERIOR_DIRECTIONS):
        sign = -1 if k < coarse.cross and a & 1 else 1
        i = a + sign * steps[3 * k]
        j = b + sign * steps[3 * k + 1]
        h = c + sign * steps[3 * k + 2]
        if 0 <= i <= 2 * coarse.nx and 0 <= j <= 2 * coarse.ny and 0 <= h <= 2 * coarse.nz:
            near[count] = node_at(coarse, i, j, h)
            count += 1
    return count


@jitable
def _nodes_near(places: _Places, node: int, reach: float, near: IntArray) -> int:
    """Write the nodes of the mesh that are near to start or goal to ``near``; their number."""
    x, y, z = places
    p, count = (x[node], y[node], z[node]), 0
    for other in range(len(x) - 2):
        if distance(p, (x[other], y[other], z[other])) <= reach:
            near[count] = other
            count += 1
    return count


@jitable
def _visible_parent(
    places: _Places,
    closed: ByteArray,
    cost: FloatArray,
    obstacles: tuple[FloatArray, FloatArray],
    node: int,
    near: IntArray,
    most: float,
) -> int:
    """The best expanded neighbour that a node sees, which sets the node's cost; or -1."""
    x, y, z = places
    primitives, margins = obstacles
    first, last = len(x) - 2, len(x) - 1
    to_last = 2 if node == last else 0
    p = (x[node], y[node], z[node])
    # what is longer is not wanted
    least = most - distance(p, (x[last], y[last], z[last]))
    origin = -1
    for other in near:
        q = (x[other], y[other], z[other])
        through = cost[other] + distance(q, p)
        if closed[other] == 1 and through < least:
            limits = ((1 if other == first else 0) + to_last) * (len(primitives) // WIDTH)
            if not blocked(primitives, margins, limits, q, p):
                least = through
                origin = other
    cost[node] = least if origin >= 0 else np.inf
    return origin


@jitable
def _path_through(places: _Places, parent: IntArray, first: int, last: int) -> FloatArray:
    """Points of the path from one node to another, flat, [unit]."""
    x, y, z = places
    found = [z[last], y[last], x[last]]
    node = last
    while node != first:
        node = int(parent[node])
        found.extend([z[node], y[node], x[node]])
    return np.array(found[::-1])


@compiled(example=(NO_ADJACENCY, FLAGS, 1, 1.0, (_POINT, _POINT), (FLOATS, FLOATS), 2.0))
def any_angle(
    adjacency: Adjacency,
    excluded: BoolArray,
    stride: int,
    reach: float,
    ends: tuple[Vec3, Vec3],
    obstacles: tuple[FloatArray, FloatArray],
    most: float,
) -> FloatArray:
    """Lazy Theta* (Nash, Koenig and Tovey, 2010): a path whose segments need not be edges.

    A node takes over its neighbour's parent unseen; whether they see each other is tested when the
    node is expanded, and if they do not, the best expanded neighbour that it sees is its parent.

    Args:
        adjacency: the mesh.
        excluded: (n,) nodes of it that do not count.
        stride: of a lattice every so many nodes along each direction count.
        reach: start and goal are neighbours of the nodes that are so near, [unit].
        ends: start and goal, [unit], world.
        obstacles: primitives, rows one after the other (k WIDTH,), and the distances from them that
            a segment keeps (4k,), [unit]: in general, from the start, to the goal, from the start
            to the goal.
        most: length that the path must be below, [unit].

    Returns:
        The points of the path, one after the other, (3m,), [unit], world; empty when there is none.
    """
    shape, _, steps, _, indptr, indices = adjacency
    coarse = _coarse(shape, stride)
    first, last = coarse.nodes, coarse.nodes + 1
    # closed is 1, too, where a node was expanded
    x, y, z, closed = _places(adjacency, coarse, stride, excluded, ends)
    places = x, y, z
    cost, parent = np.full(last + 1, np.inf), np.full(last + 1, first, np.int32)
    cost[first] = 0.0
    (start, goal), (primitives, margins) = ends, obstacles
    near = np.empty(last + 1, np.int32)  # a list would be grown and freed for each node
    to_go = distance(start, goal)
    queue = [(to_go, to_go, first)]
    while len(queue) > 0 and closed[last] == 0:
        node = heapq.heappop(queue)[2]
        if closed[node] == 1:
            continue
        p = (x[node], y[node], z[node])
        if node < first:
            count = _neighbours(coarse, node, steps, indptr, indices, near)
        else:
            count = _nodes_near(places, node, reach, near)
        if node == first or distance(p, goal) <= reach:
            near[count] = last
            count += 1
        if node == last or distance(p, start) <= reach:
            near[count] = first
            count += 1
        origin = int(parent[node])
        limits = (1 if origin == first else 0) + (2 if node == last else 0)
        limits *= len(primitives) // WIDTH
        if node != first and blocked(
            primitives, margins, limits, (x[origin], y[origin], z[origin]), p
        ):
            origin = _visible_parent(places, closed, cost, obstacles, node, near[:count], most)
            if origin < 0:
                continue  # until a neighbour that it sees is expanded
            parent[node] = origin
        closed[node] = 1
        so_far, p = cost[origin], (x[origin], y[origin], z[origin])
        for k in range(count):
            other = near[k] + 0  # as wide as the queue's
            if closed[other] == 1:
                continue
            q = (x[other], y[other], z[other])
            through = so_far + distance(p, q)
            if through < cost[other]:
                to_go = distance(q, goal)
                if through + to_go < most:
                    cost[other] = through
                    parent[other] = origin
                    heapq.heappush(queue, (through + to_go, to_go, other))
    return np.empty(0) if closed[last] == 0 else _path_through(places, parent, first, last)
