"""What a place sees of a mesh, and how near it is to the obstacles.

Compiled by numba; each runs uncompiled too, by its ``py_func``. A solid is a row of numbers, see
``abi.obstacles.primitive_kernels``; a mesh is described in ``abi.tet_mesh.adjacency_kernels``.
"""

from __future__ import annotations

import math

import numpy as np

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.compiled import FLAGS, FLOATS, compiled
from abi.obstacles.primitive_kernels import blocked
from abi.tet_mesh.adjacency_kernels import BCC, NO_SHAPE, ROWS, Shape, half_cells, node_at


@compiled(example=(NO_SHAPE, FLOATS, FLOATS, FLOATS, FLAGS, 0.0, 0.0, 0.0, 0.0))
def seen(
    shape: Shape,
    places: FloatArray,
    solids: FloatArray,
    margins: FloatArray,
    excluded: BoolArray,
    x: float,
    y: float,
    z: float,
    reach: float,
) -> tuple[IntArray, FloatArray]:
    """The nodes that a place sees.

    Args:
        shape, places: the mesh.
        solids: (k WIDTH,) rows, one after the other.
        margins: (k,) distance from the solids that a line of sight keeps, [unit].
        excluded: (n,) nodes that do not count.
        x, y, z: the place, [unit], world.
        reach: how far it looks, [unit].

    Returns:
        Nodes (m,) and the distances to them, [unit].
    """
    found = 0
    nodes = np.empty(128, np.int32)
    distances = np.empty(128, np.float64)
    count = shape[5]
    y0 = 2 * shape[1] + 1
    z0 = y0 + 2 * shape[2] + 1
    rows = shape[0] == ROWS
    for odd in range(2 if shape[0] == BCC else 1):
        a0, a1, b0, b1, c0, c1 = 0, 2 * count - 2, 0, 0, 0, 0
        if not rows:
            a0, a1 = half_cells(places[0], places[2], shape[1], x - reach, x + reach, odd)
            b0, b1 = half_cells(places[y0], places[y0 + 2], shape[2], y - reach, y + reach, odd)
            c0, c1 = half_cells(places[z0], places[z0 + 2], shape[3], z - reach, z + reach, odd)
        for a in range(a0, a1 + 1, 2):
            for b in range(b0, b1 + 1, 2):
                for c in range(c0, c1 + 1, 2):
                    if rows:
                        node = a >> 1
                        px, py, pz = places[node], places[count + node], places[2 * count + node]
                    else:
                        node = node_at(shape, a, b, c)
                        px, py, pz = places[a], places[y0 + b], places[z0 + c]
                    away = math.sqrt((px - x) ** 2 + (py - y) ** 2 + (pz - z) ** 2)
                    if away > reach or excluded[node]:
                        continue
                    if blocked(solids, margins, 0, (x, y, z), (px, py, pz)):
                        continue
                    if found == len(nodes):
                        nodes = np.concatenate((nodes, np.empty_like(nodes)))
                        distances = np.concatenate((distances, np.empty_like(distances)))
                    nodes[found] = node
                    distances[found] = away
                    found += 1
    return nodes[:found], distances[:found]
