"""Nodes and edges as the compiled kernels see them: a lattice without tables, or compressed rows.

What is here is plain Python that numba compiles with its caller; uncompiled it runs on lists. Only
numbers and tuples are handed over: arrays would be counted in and out at every call, which takes
longer than most of what is called. A mesh and its open edges are described by (``adjacency``):

shape
    a tuple: kind (``ROWS``, ``KUHN`` or ``BCC``), cells along x, y and z, corners, nodes,
    directions, those of them that join a corner to a centre, the most edges of a node in the mesh.
offsets, steps, places
    of a lattice see ``Stencil``, ``places`` being its axes. Of rows ``places`` are x, y
    and z of the nodes, one after the other, and the other two are empty.
indptr, indices
    of rows: where each node's edges begin (n + 1,), and the neighbours (2e,); empty for a lattice.
exits
    (n,) bits: the directions that are open, and ``LINKED``, the only one that counts in rows.
weights
    of the directions (d,), or of the edges of the rows (2e,), inf where one is shut.
tails, heads, link_weights
    (m,) ends and weights of the edges to start and goal, where these are no nodes of the mesh. They
    then have the ids that follow those of the mesh.
"""

from __future__ import annotations

import math

from numba.extending import register_jitable

Shape = tuple[int, int, int, int, int, int, int, int, int]

ROWS, KUHN, BCC = 0, 1, 2

NO_SHAPE: Shape = (ROWS, 0, 0, 0, 0, 0, 0, 0, 0)
"""That of a mesh without nodes."""

LINKED = 30
"""The bit of a node that has an edge to start or goal beside those of the mesh."""

SIDES = 14
"""Directions of a node that is not on the box; those above are diagonals of its faces."""


@register_jitable
def cell(shape: Shape, node: int) -> tuple[int, int, int]:
    """Place of a lattice node in half cells."""
    side = 0 if node < shape[4] else 1
    node -= side * shape[4]
    column, layer = shape[2] + 1 - side, shape[3] + 1 - side
    # divisions take longer, and half a node more is far from what rounding could change
    line = int((node + 0.5) * (1 / layer))
    i = int((line + 0.5) * (1 / column))
    return 2 * i + side, 2 * (line - i * column) + side, 2 * (node - line * layer) + side


@register_jitable
def node_at(shape: Shape, a: int, b: int, c: int) -> int:
    """Node of a lattice at a place in half cells, all three even, or all three odd."""
    column, layer = shape[2], shape[3]
    if a % 2 == 0:
        return ((a // 2) * (column + 1) + b // 2) * (layer + 1) + c // 2
    return shape[4] + ((a // 2) * column + b // 2) * layer + c // 2


@register_jitable
def across(shape: Shape, a: int, b: int, c: int) -> int:
    """In ``bcc`` the centre of the cube whose low corner is at a place; that corner of a centre.

    The place is in half cells. At the high end of an axis there is no such cube; its centres have
    directions relative to it.
    """
    side = 1 - (a & 1)
    column, layer = shape[2] + 1 - side, shape[3] + 1 - side
    return side * shape[4] + ((a >> 1) * column + (b >> 1)) * layer + (c >> 1)


@register_jitable
def ones(bits: int) -> int:
    """How many directions are among the bits of a node."""
    bits &= (1 << LINKED) - 1
    bits -= (bits >> 1) & 0x55555555
    bits = (bits & 0x33333333) + ((bits >> 2) & 0x33333333)
    bits = (bits + (bits >> 4)) & 0x0F0F0F0F
    return ((bits * 0x01010101) >> 24) & 63


@register_jitable
def half_cells(
    origin: float, following: float, cells: int, low: float, high: float, odd: int
) -> tuple[int, int]:
    """First and last half cell, even or odd, that may lie in low..high along an axis."""
    step = following - origin
    first = max(math.floor((low - origin) / step), 0)
    last = min(math.ceil((high - origin) / step), cells)
    return 2 * first + odd, 2 * last - odd
