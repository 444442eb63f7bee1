"""Adjacency of a mesh in the format of the kernels, see ``adjacency_kernels``."""

from __future__ import annotations

import numpy as np
import scipy

from abi import arguments
from abi.arrays import FloatArray, IntArray, read_only
from abi.errors import ArgumentError
from abi.tet_mesh.adjacency_kernels import NO_SHAPE, Adjacency, MeshSizes
from abi.tet_mesh.lattice import REGULAR
from abi.tet_mesh.stencil import Stencil

NO_IDS: IntArray = read_only(np.zeros(0, dtype=np.int32))
NO_NUMBERS: FloatArray = read_only(np.zeros(0))


def of_lattice(stencil: Stencil, nodes: int) -> Adjacency:
    """The adjacency of a lattice, without tables."""
    nx, ny, nz = stencil.cells
    directions = len(stencil.lengths)
    shape = MeshSizes(
        kind=REGULAR[stencil.lattice].kind,
        nx=nx,
        ny=ny,
        nz=nz,
        corners=(nx + 1) * (ny + 1) * (nz + 1),
        nodes=nodes,
        directions=directions,
        cross=stencil.cross,
        most=directions,
    )
    offsets, steps = read_only(stencil.offsets.ravel()), read_only(stencil.steps.ravel())
    return Adjacency(shape, offsets, steps, stencil.axes, NO_IDS, NO_IDS)


def of_rows(points: FloatArray, indptr: IntArray, indices: IntArray) -> Adjacency:
    """The adjacency of compressed rows: nodes (n, 3), [unit], world; see :func:`rows`."""
    points = arguments.points("points", points)
    indices = arguments.ids("indices", indices, (-1,), len(points))
    indptr = arguments.bits("indptr", indptr, (len(points) + 1,), 0, len(indices))
    if indptr[0] or indptr[-1] != len(indices) or (np.diff(indptr) < 0).any():
        expected = f"beginnings of rows that ascend from 0 to {len(indices)}"
        raise ArgumentError("indptr", indptr[:6].tolist(), expected)
    most = int(np.diff(indptr).max(initial=0))
    shape = NO_SHAPE._replace(nodes=len(points), most=most)
    places = read_only(np.ascontiguousarray(points.T).ravel())
    return Adjacency(shape, NO_IDS, NO_IDS, places, read_only(indptr), read_only(indices))


def rows(edges: IntArray, lengths: FloatArray, nodes: int) -> tuple[IntArray, IntArray, FloatArray]:
    """Compressed rows of an undirected graph: indptr (n + 1,), indices (2e,), lengths (2e,).

    Args:
        edges: (e, 2) node ids, each edge once.
        lengths: (e,).
        nodes: number of nodes.
    """
    nodes = arguments.integer("nodes", nodes, 0, arguments.LARGEST_ID)
    edges = arguments.ids("edges", edges, (-1, 2), nodes)
    lengths = arguments.numbers("lengths", lengths, (len(edges),))
    tail = np.concatenate([edges[:, 1], edges[:, 0]])
    head = np.concatenate([edges[:, 0], edges[:, 1]])
    entries = scipy.sparse.coo_array(
        (np.concatenate([lengths, lengths]), (tail, head)), shape=(nodes, nodes)
    )
    entries.has_canonical_format = True  # no edge occurs twice: spares a search for duplicates
    found = entries.tocsr()
    found.sort_indices()
    indptr, indices = (part.astype(np.int32, copy=False) for part in (found.indptr, found.indices))
    return read_only(indptr), read_only(indices), read_only(found.data)
