"""Nodes and edges of a mesh that one primitive excludes, and the tetrahedra lost with them.

Compiled by numba; each kernel runs uncompiled too. A primitive is a row of numbers, see
``abi.obstacles.primitive_kernels``; a mesh is described in ``abi.tet_mesh.adjacency_kernels``.
"""

from __future__ import annotations

import numpy as np

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, IDS, NEW_FLAGS, NEW_IDS, compiled
from abi.obstacles.primitive_kernels import (
    axes_of,
    centre_of,
    core_of,
    in_body,
    segment_within,
    signed_distance,
)
from abi.obstacles.vector_kernels import sub
from abi.tet_mesh.adjacency_kernels import (
    CSR,
    INTERIOR_DIRECTIONS,
    NO_ADJACENCY,
    Adjacency,
    across,
    cell,
    half_cells_within,
    row_place,
)
from abi.tet_mesh.lattice_exclusion_kernels import Found, exclusion_of_lattice


@compiled(example=(NO_ADJACENCY, IDS, FLOATS, 0.0, 1.0))
def exclusion(
    adjacency: Adjacency, open_directions: IntArray, solid: FloatArray, margin: float, reach: float
) -> Found:
    """The nodes nearer to a primitive than ``margin``, and the edges of other nodes that are.

    Args:
        adjacency: the mesh.
        open_directions: (n,) directions that exist.
        solid: (TREE,) row.
        margin: [unit].
        reach: the longest edge, [unit].

    Returns:
        First nodes of the runs that are excluded and how many each has (r,); in a lattice nodes
        that lose edges to others that are not excluded, and the bits of these edges (m,); of rows
        all edges that nodes lose, and 0.
    """
    if adjacency.shape.kind == CSR:
        return _exclusion_of_rows(adjacency, solid, margin, reach)
    limit = margin + reach
    low = (solid[17] - limit, solid[18] - limit, solid[19] - limit)
    high = (solid[20] + limit, solid[21] + limit, solid[22] + limit)
    windows = (
        half_cells_within(adjacency.shape, adjacency.places, low, high, 0),
        half_cells_within(adjacency.shape, adjacency.places, low, high, 1),
    )
    return exclusion_of_lattice(adjacency, open_directions, solid, margin, reach, windows)


@jitable
def _exclusion_of_rows(
    adjacency: Adjacency, solid: FloatArray, margin: float, reach: float
) -> Found:
    """Nodes of a mesh of rows that a primitive excludes; every node is tested."""
    shape, _, _, places, indptr, indices = adjacency
    axes, core, centre = axes_of(solid, 0), core_of(solid, 0), centre_of(solid, 0)
    nodes = shape.nodes
    limit = margin + reach
    starts = np.empty(nodes, np.int32)
    gone = np.empty(len(indices), np.int32)
    runs, shut = 0, 0
    for node in range(nodes):
        tail = row_place(places, nodes, node)
        p = in_body(axes, sub(tail, centre))
        away = signed_distance(core, p)
        if away < margin:
            starts[runs] = node
            runs += 1
        elif away < limit:
            for k in range(indptr[node], indptr[node + 1]):
                head = row_place(places, nodes, indices[k])
                gone[shut] = k
                q = in_body(axes, sub(head, centre))
                if signed_distance(core, q) < margin:
                    shut += 1
                    continue
                # from the same end both times, for rounding
                if node < indices[k]:
                    near = segment_within(core, margin, p, in_body(axes, sub(head, tail)))
                else:
                    near = segment_within(core, margin, q, in_body(axes, sub(tail, head)))
                shut += 1 if near else 0
    return starts[:runs], np.ones(runs, np.int32), gone[:shut], np.zeros(shut, np.int32)


@compiled(example=(IDS, IDS, NEW_FLAGS))
def mark(starts: IntArray, lengths: IntArray, excluded: BoolArray) -> int:
    """Mark the nodes of runs; how many were not marked before.

    Args:
        starts: (r,) first nodes.
        lengths: (r,) numbers of nodes.
        excluded: (n,) set True where a node is in a run.
    """
    count = 0
    for run in range(len(starts)):
        for node in range(starts[run], starts[run] + lengths[run]):
            count += 0 if excluded[node] else 1
            excluded[node] = True
    return count


@compiled(example=(NO_ADJACENCY, IDS, IDS, IDS, IDS, NEW_IDS))
def cut(
    adjacency: Adjacency,
    starts: IntArray,
    lengths: IntArray,
    cut_nodes: IntArray,
    cut_bits: IntArray,
    open_directions: IntArray,
) -> None:
    """Clear the bits of a lattice's edges from free to excluded nodes, and of those lost.

    Args:
        adjacency: the lattice.
        starts, lengths: (r,) runs of excluded nodes, each in one line along z, ascending.
        cut_nodes: (m,) nodes that lose edges.
        cut_bits: (m,) bits of these.
        open_directions: (n,) open directions, as bits.
    """
    shape, offsets, steps, _, _, _ = adjacency
    directions, cross, runs = shape.directions, shape.cross, len(starts)
    nx, ny, nz = 2 * shape.nx, 2 * shape.ny, 2 * shape.nz
    places = np.empty(4 * runs, np.int64)
    corners, on_box = 0, False
    for run in range(runs):
        at, (a, b, c) = 4 * run, cell(shape, starts[run])
        places[at], places[at + 1], places[at + 2] = a, b, c
        places[at + 3] = across(shape, a, b, c)
        end = c + 2 * (lengths[run] - 1)
        on_box = on_box or not (0 < a < nx and 0 < b < ny and c > 0 and end < nz)
        corners += 1 - (a & 1)
    for odd in range(2):
        # what is no edge has no bit to clear, but nodes on the box have more edges
        for k in range(directions if on_box else INTERIOR_DIRECTIONS):
            turned = -1 if k < cross and odd == 1 else 1
            i, j, h = turned * steps[3 * k], turned * steps[3 * k + 1], turned * steps[3 * k + 2]
            others = ~(1 << (k if k < cross else k ^ 1))
            offset, near = offsets[odd * directions + k], 0
            for run in range(corners if odd == 1 else 0, runs if odd == 1 else corners):
                at, many = 4 * run, lengths[run]
                a, b, c = places[at], places[at + 1], places[at + 2]
                if not (0 <= a + i <= nx and 0 <= b + j <= ny):
                    continue
                head = (places[at + 3] if k < cross else starts[run]) + offset
                low = head + (1 if c + h < 0 else 0)
                high = head + (many - 1 if c + 2 * (many - 1) + h > nz else many)
                # most of them are excluded too, as the run beside this one, and need no bits
                while near < runs and starts[near] + lengths[near] <= low:
                    near += 1
                left, right = high, high
                if near < runs:
                    left, right = min(starts[near], high), max(starts[near] + lengths[near], low)
                for n in range(low, left):
                    open_directions[n] &= others
                for n in range(right, high):
                    open_directions[n] &= others
    for k in range(len(cut_nodes)):
        open_directions[cut_nodes[k]] &= ~cut_bits[k]
