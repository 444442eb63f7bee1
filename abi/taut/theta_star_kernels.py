"""Any-angle search over the nodes of a mesh, between convex solids.

Compiled by numba; ``any_angle`` runs uncompiled too, by its ``py_func`` on plain lists. A mesh is
described in ``abi.tet_mesh.adjacency_kernels``, a solid in ``abi.obstacles.primitive_kernels``.

Of a lattice every few nodes may do: they are a coarser lattice, in the middle of the fine one.
Start and goal are its last two nodes.
"""

from __future__ import annotations

import heapq

import numpy as np
from numba.extending import register_jitable

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.compiled import FLAGS, FLOATS, IDS, compiled
from abi.obstacles.primitive_kernels import WIDTH, blocked
from abi.obstacles.vector_kernels import Vec3, distance
from abi.tet_mesh.adjacency_kernels import BCC, NO_SHAPE, ROWS, SIDES, Shape, cell, node_at


@register_jitable
def _coarse(shape: Shape, stride: int) -> Shape:
    """The mesh that is searched."""
    if shape[0] == ROWS:
        return shape
    nx, ny, nz = shape[1] // stride, shape[2] // stride, shape[3] // stride
    corners = (nx + 1) * (ny + 1) * (nz + 1)
    nodes = corners + (nx * ny * nz if shape[0] == BCC else 0)
    return shape[0], nx, ny, nz, corners, nodes, shape[6], shape[7], shape[8]


@register_jitable
def _fine(shape: Shape, coarse: Shape, stride: int, node: int) -> tuple[int, int, int]:
    """Place of a node of the coarse lattice in half cells of the fine one."""
    a, b, c = cell(coarse, node)
    return (
        stride * a + (shape[1] - stride * coarse[1]) // 2 * 2,
        stride * b + (shape[2] - stride * coarse[2]) // 2 * 2,
        stride * c + (shape[3] - stride * coarse[3]) // 2 * 2,
    )


@register_jitable
def _neighbours(
    coarse: Shape, steps: IntArray, indptr: IntArray, indices: IntArray, node: int, near: list[int]
) -> None:
    """Add the neighbours of a node of the mesh to ``near``."""
    if coarse[0] == ROWS:
        for k in range(indptr[node], indptr[node + 1]):
            near.append(int(indices[k]))
        return
    a, b, c = cell(coarse, node)
    for k in range(SIDES):
        sign = -1 if k < coarse[7] and a & 1 else 1
        i = a + sign * steps[3 * k]
        j = b + sign * steps[3 * k + 1]
        h = c + sign * steps[3 * k + 2]
        if 0 <= i <= 2 * coarse[1] and 0 <= j <= 2 * coarse[2] and 0 <= h <= 2 * coarse[3]:
            near.append(node_at(coarse, i, j, h))


_POINT = (0.0, 0.0, 0.0)


@compiled(
    example=(NO_SHAPE, IDS, FLOATS, IDS, IDS, FLAGS, 1, 1.0, _POINT, _POINT, FLOATS, FLOATS, 2.0)
)
def any_angle(
    shape: Shape,
    steps: IntArray,
    places: FloatArray,
    indptr: IntArray,
    indices: IntArray,
    excluded: BoolArray,
    stride: int,
    reach: float,
    start: Vec3,
    goal: Vec3,
    solids: FloatArray,
    margins: FloatArray,
    most: float,
) -> FloatArray:
    """Lazy Theta* (Nash, Koenig and Tovey, 2010): a path whose segments need not be edges.

    A node takes over its neighbour's parent unseen; whether they see each other is tested when the
    node is expanded, and if they do not, the best expanded neighbour that it sees is its parent.

    Args:
        shape, steps, places, indptr, indices: the mesh.
        excluded: (n,) nodes of it that do not count.
        stride: of a lattice every so many nodes along each direction count.
        reach: start and goal are neighbours of the nodes that are so near, [unit].
        start, goal: [unit], world.
        solids: (k WIDTH,) rows, one after the other.
        margins: (4k,) distance from each solid that a segment keeps, [unit]: in general, from the
            start, to the goal, from the start to the goal.
        most: length that the path must be below, [unit].

    Returns:
        The points of the path, one after the other, (3m,), [unit], world; empty when there is none.
    """
    coarse = _coarse(shape, stride)
    nodes, y0 = coarse[5], 2 * shape[1] + 1
    z0 = y0 + 2 * shape[2] + 1
    first, last = nodes, nodes + 1
    solid_count = len(solids) // WIDTH
    x, y, z = np.empty(nodes + 2), np.empty(nodes + 2), np.empty(nodes + 2)
    closed = np.zeros(nodes + 2, np.uint8)
    for node in range(nodes):
        if shape[0] == ROWS:
            x[node], y[node] = places[node], places[nodes + node]
            z[node], closed[node] = places[2 * nodes + node], excluded[node]
        else:
            a, b, c = _fine(shape, coarse, stride, node)
            x[node], y[node], z[node] = places[a], places[y0 + b], places[z0 + c]
            closed[node] = excluded[node_at(shape, a, b, c)]
    x[first], y[first], z[first] = start
    x[last], y[last], z[last] = goal
    cost = np.full(nodes + 2, np.inf)
    parent = np.full(nodes + 2, first, np.int32)
    near = [0] * 0
    cost[first] = 0.0
    to_go = distance(start, goal)
    queue = [(to_go, to_go, first)]
    while len(queue) > 0 and closed[last] == 0:
        node = heapq.heappop(queue)[2]
        if closed[node] == 1:
            continue
        px, py, pz = x[node], y[node], z[node]
        near.clear()
        if node < nodes:
            _neighbours(coarse, steps, indptr, indices, node, near)
        else:
            for other in range(nodes):
                if distance((px, py, pz), (x[other], y[other], z[other])) <= reach:
                    near.append(other)
        if node == first or distance((px, py, pz), goal) <= reach:
            near.append(last)
        if node == last or distance((px, py, pz), (x[first], y[first], z[first])) <= reach:
            near.append(first)
        origin = int(parent[node])
        to_last = 2 if node == last else 0
        limits = ((1 if origin == first else 0) + to_last) * solid_count
        if node != first and blocked(
            solids, margins, limits, (x[origin], y[origin], z[origin]), (px, py, pz)
        ):
            # what is longer is not wanted
            cost[node] = most - distance((px, py, pz), goal)
            origin = -1
            for other in near:
                ox, oy, oz = x[other], y[other], z[other]
                through = cost[other] + distance((ox, oy, oz), (px, py, pz))
                if closed[other] == 1 and through < cost[node]:
                    limits = ((1 if other == first else 0) + to_last) * solid_count
                    if not blocked(solids, margins, limits, (ox, oy, oz), (px, py, pz)):
                        cost[node] = through
                        origin = other
            if origin < 0:
                cost[node] = np.inf
                continue  # until a neighbour that it sees is expanded
            parent[node] = origin
        closed[node] = 1
        so_far, px, py, pz = cost[origin], x[origin], y[origin], z[origin]
        for other in near:
            if closed[other] == 1:
                continue
            qx, qy, qz = x[other], y[other], z[other]
            through = so_far + distance((px, py, pz), (qx, qy, qz))
            if through < cost[other]:
                to_go = distance((qx, qy, qz), goal)
                if through + to_go < most:
                    cost[other] = through
                    parent[other] = origin
                    heapq.heappush(queue, (through + to_go, to_go, other))
    found = [0.0] * 0
    node = last
    while closed[last] == 1:
        found.extend([z[node], y[node], x[node]])
        if node == first:
            break
        node = int(parent[node])
    return np.array(found[::-1])
