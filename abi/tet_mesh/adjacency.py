"""A mesh as the compiled kernels take it; see ``adjacency_kernels`` for what is in it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from abi.arrays import FloatArray, IntArray, read_only
from abi.search.heuristic_kernels import Metric
from abi.tet_mesh.adjacency_kernels import BCC, KUHN, ROWS, Shape
from abi.tet_mesh.stencil import Stencil

NO_IDS: IntArray = read_only(np.zeros(0, dtype=np.int32))
NO_NUMBERS: FloatArray = read_only(np.zeros(0))

_AXES = (1, 2, 4)


class Net(NamedTuple):
    """The parts of a mesh that stay as they are, in the order in which kernels take them."""

    shape: Shape
    offsets: IntArray
    steps: IntArray
    places: FloatArray
    indptr: IntArray
    indices: IntArray


def of_lattice(stencil: Stencil, nodes: int) -> Net:
    """The net of a lattice, without tables."""
    nx, ny, nz = stencil.cells
    directions = len(stencil.lengths)
    shape = (
        BCC if stencil.cross else KUHN,
        nx,
        ny,
        nz,
        (nx + 1) * (ny + 1) * (nz + 1),
        nodes,
        directions,
        stencil.cross,
        directions,
    )
    offsets, steps = read_only(stencil.offsets.ravel()), read_only(stencil.steps.ravel())
    return Net(shape, offsets, steps, stencil.axes, NO_IDS, NO_IDS)


def of_rows(points: FloatArray, indptr: IntArray, indices: IntArray) -> Net:
    """The net of compressed rows: nodes (n, 3), [unit], world; see :func:`rows`."""
    most = int(np.diff(indptr).max(initial=0))
    shape = (ROWS, 0, 0, 0, 0, len(points), 0, 0, most)
    places = read_only(np.ascontiguousarray(points.T).ravel())
    return Net(shape, NO_IDS, NO_IDS, places, indptr, indices)


def rows(edges: IntArray, lengths: FloatArray, nodes: int) -> tuple[IntArray, IntArray, FloatArray]:
    """Compressed rows of an undirected graph: indptr (n + 1,), indices (2e,), lengths (2e,).

    Args:
        edges: (e, 2) node ids, each edge once.
        lengths: (e,).
        nodes: number of nodes.
    """
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


def norm(cells: tuple[float, float, float]) -> Metric:
    """What a metric says of a lattice whose cells cost so much along their axes, for lengths.

    Returns:
        The costs, that of the whole diagonal, and of all diagonals; see ``heuristic_kernels``.
    """
    costs = [
        float(np.sqrt(sum(c * c for c, a in zip(cells, _AXES, strict=True) if a & axes)))
        for axes in range(8)
    ]
    return (*cells, costs[7], *_of_sets(costs))


def hop_norm() -> Metric:
    """The same where every edge costs 1."""
    return (1.0, 1.0, 1.0, 2.0, *_of_sets([0.0] + 7 * [1.0]))


def _of_sets(costs: list[float]) -> list[float]:
    """Costs of sets of axes, from those by number, in the order of ``heuristic_kernels``."""
    return [costs[axes] for axes in (1, 2, 4, 3, 5, 6, 7)]
