"""Visibility of the nodes of a mesh from a point.

Compiled by numba; it runs uncompiled too. A primitive is a row of numbers, see
``abi.obstacles.primitive_kernels``; a mesh is described in ``abi.tet_mesh.adjacency_kernels``.
"""

from __future__ import annotations

import numpy as np

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.compiled import FLAGS, FLOATS, compiled
from abi.obstacles.primitive_tree_kernels import blocked
from abi.obstacles.vector_kernels import Vec3, distance
from abi.tet_mesh.adjacency_kernels import (
    CSR,
    NO_ADJACENCY,
    Adjacency,
    half_cells_within,
    node_at,
    row_place,
    y_and_z_origins,
)


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
