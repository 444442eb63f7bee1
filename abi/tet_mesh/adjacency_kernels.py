"""Nodes and edges in the format of the kernels: a lattice without tables, or compressed rows.

Plain Python that numba compiles with its caller; uncompiled it runs on lists. In their inner loops
kernels pass numbers and tuples of numbers. Arrays would be reference-counted at every call, which
takes longer than most of the functions called. Helpers that need arrays there are always inlined,
get them one by one, and use all of them throughout, so that the compiler can omit the counting.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from abi.arrays import FloatArray, IntArray
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, IDS
from abi.obstacles.vector_kernels import Vec3

CSR, KUHN, BCC = 0, 1, 2

_ROUNDING = 1e-9  # of a step: what is outside by no more is taken for inside

Span = tuple[int, int]
"""First and last."""


class MeshSizes(NamedTuple):
    """Sizes of a mesh.

    Attributes:
        kind: ``CSR``, ``KUHN`` or ``BCC``.
        nx, ny, nz: cells of a lattice along its axes.
        corners: nodes of a lattice that are corners of cells; the others are their centres.
        nodes: number of nodes.
        directions: number of directions of a lattice.
        cross: those of them that join a corner to a centre, which come first.
        most: the most edges of a node.
    """

    kind: int
    nx: int
    ny: int
    nz: int
    corners: int
    nodes: int
    directions: int
    cross: int
    most: int


class Adjacency(NamedTuple):
    """The parts of a mesh that stay as they are; for a lattice see ``abi.tet_mesh.stencil``.

    Attributes:
        shape: its sizes.
        offsets: of a lattice (2 d,) what a direction adds to a node's id; of rows empty.
        steps: of a lattice (3 d,) half cells of the directions; of rows empty.
        places: coordinates along x, y and z, one after the other, [unit], world: of a lattice those
            of its half cells, of rows those of the nodes (3 n,).
        indptr: of rows (n + 1,) where each node's edges begin; of a lattice empty.
        indices: of rows (2 e,) the neighbours; of a lattice empty.
    """

    shape: MeshSizes
    offsets: IntArray
    steps: IntArray
    places: FloatArray
    indptr: IntArray
    indices: IntArray


NO_SHAPE = MeshSizes(CSR, 0, 0, 0, 0, 0, 0, 0, 0)
"""That of a mesh without nodes."""

NO_ADJACENCY = Adjacency(NO_SHAPE, IDS, IDS, FLOATS, IDS, IDS)
"""In an example: a mesh."""

LINKED_BIT = 30
"""The bit of a node that has an edge to start or goal beside those of the mesh."""

INTERIOR_DIRECTIONS = 14
"""Directions of a node that is not on the box; those above are diagonals of its faces."""

ALL_INTERIOR = (1 << INTERIOR_DIRECTIONS) - 1
"""The bits of these directions."""


@jitable
def cell(shape: MeshSizes, node: int) -> tuple[int, int, int]:
    """Place of a lattice node in half cells."""
    side = 0 if node < shape.corners else 1
    node -= side * shape.corners
    column, layer = shape.ny + 1 - side, shape.nz + 1 - side
    # divisions take longer, and half a node more is far from what rounding could change
    line = int((node + 0.5) * (1 / layer))
    i = int((line + 0.5) * (1 / column))
    return 2 * i + side, 2 * (line - i * column) + side, 2 * (node - line * layer) + side


@jitable
def cell_place(shape: MeshSizes, node: int) -> Vec3:
    """Place of a lattice node in half cells, as numbers that need not be whole."""
    a, b, c = cell(shape, node)
    return 1.0 * a, 1.0 * b, 1.0 * c


@jitable(forceinline=True)
def row_place(places: FloatArray, nodes: int, node: int) -> Vec3:
    """Place of a node of rows, [unit], world."""
    return places[node], places[nodes + node], places[2 * nodes + node]


@jitable
def y_and_z_origins(shape: MeshSizes) -> tuple[int, int]:
    """Starts of the half cells along y and z in a lattice's ``places``."""
    y0 = 2 * shape.nx + 1
    return y0, y0 + 2 * shape.ny + 1


@jitable
def node_at(shape: MeshSizes, a: int, b: int, c: int) -> int:
    """Node of a lattice at a place in half cells, all three even, or all three odd."""
    column, layer = shape.ny, shape.nz
    if a % 2 == 0:
        return ((a // 2) * (column + 1) + b // 2) * (layer + 1) + c // 2
    return shape.corners + ((a // 2) * column + b // 2) * layer + c // 2


@jitable
def across(shape: MeshSizes, a: int, b: int, c: int) -> int:
    """In ``bcc`` the centre of the cube whose low corner is at a place; that corner of a centre.

    The place is in half cells. At the high end of an axis there is no such cube; its centres have
    directions relative to it.
    """
    side = 1 - (a & 1)
    column, layer = shape.ny + 1 - side, shape.nz + 1 - side
    return side * shape.corners + ((a >> 1) * column + (b >> 1)) * layer + (c >> 1)


@jitable
def ones(bits: int) -> int:
    """Number of directions among the bits of a node."""
    bits &= (1 << LINKED_BIT) - 1
    bits -= (bits >> 1) & 0x55555555
    bits = (bits & 0x33333333) + ((bits >> 2) & 0x33333333)
    bits = (bits + (bits >> 4)) & 0x0F0F0F0F
    return ((bits * 0x01010101) >> 24) & 63


@jitable
def half_cells_within(
    shape: MeshSizes, places: FloatArray, low: Vec3, high: Vec3, odd: int
) -> tuple[Span, Span, Span]:
    """Half cells of a lattice, even or odd, that may lie in the box low..high, [unit], world."""
    y0, z0 = y_and_z_origins(shape)
    return (
        _span(shape.nx, (places[0], places[2]), low[0], high[0], odd),
        _span(shape.ny, (places[y0], places[y0 + 2]), low[1], high[1], odd),
        _span(shape.nz, (places[z0], places[z0 + 2]), low[2], high[2], odd),
    )


@jitable
def _span(cells: int, edges: tuple[float, float], low: float, high: float, odd: int) -> Span:
    """Those along an axis, whose first cell has these edges."""
    step = edges[1] - edges[0]
    first = max(math.ceil((low - edges[0]) / step - 0.5 * odd - _ROUNDING), 0)
    last = min(math.floor((high - edges[0]) / step + 0.5 * odd + _ROUNDING), cells)
    return 2 * first + odd, 2 * last - odd
