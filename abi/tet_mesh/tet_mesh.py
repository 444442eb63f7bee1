"""Stage 1: a tetrahedral mesh of the workspace.

The paper (section III) asks for "a uniform mesh model with the same finite-element geometric
primitives in the form of a tetrahedron".
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any
from weakref import WeakValueDictionary

import numpy as np

from abi import arguments
from abi.arrays import ByteArray, FloatArray, IntArray, ShortRepr, read_only
from abi.scene.settings import MeshSettings, Workspace
from abi.tet_mesh import adjacency
from abi.tet_mesh.adjacency_kernels import Adjacency
from abi.tet_mesh.delaunay import jittered_delaunay
from abi.tet_mesh.lattice import REGULAR
from abi.tet_mesh.node_tree import NodeTree, tree_over
from abi.tet_mesh.regular_lattice import Cells
from abi.tet_mesh.stencil import Stencil

_CORNER_PAIRS = np.array([(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)])


@dataclass(frozen=True, eq=False, repr=False)
class TetMesh(ShortRepr):
    """Tetrahedra that fill the workspace; tables are made at their first use.

    Attributes:
        lattice: its name.
        cells: cubes along each axis.
        pitch: shortest edge of the lattice, [unit]; of the undisturbed grid where it is irregular.
        points: (n, 3), [unit], world.
        stencil: the directions of a regular lattice; None of an irregular one.
        irregular: tetrahedra of an irregular lattice; those of a regular one follow from ``cells``.
    """

    lattice: str
    cells: Cells
    pitch: float
    points: FloatArray
    stencil: Stencil | None = None
    irregular: IntArray | None = None

    def __post_init__(self) -> None:
        points = arguments.points("points", self.points)
        own: Any = self.irregular
        if own is not None or self.lattice not in REGULAR:
            own = arguments.ids("irregular", own, (-1, 4), len(points))
        arguments.keep(self, points=points, irregular=own)

    @cached_property
    def tetrahedra(self) -> IntArray:
        """Node ids of the tetrahedra, shape (m, 4), positively oriented."""
        if self.irregular is not None:
            return self.irregular
        ids = np.arange(len(self.points), dtype=np.int32)
        families = [
            np.stack([corner.ravel() for corner in corners], axis=1)
            for corners in REGULAR[self.lattice].tetrahedra(ids, self.cells)
        ]
        return read_only(np.concatenate(families))

    @cached_property
    def edges(self) -> IntArray:
        """Node ids of the edges, shape (e, 2), lower id first, each edge once."""
        if self.irregular is not None:
            return read_only(edges_of(self.irregular, len(self.points)))
        ids = np.arange(len(self.points), dtype=np.int32)
        families = REGULAR[self.lattice].edges(ids, self.cells)
        return read_only(
            np.concatenate([np.stack([a.ravel(), b.ravel()], axis=1) for a, b, _ in families])
        )

    @cached_property
    def node_tree(self) -> NodeTree:
        """A tree over the nodes."""
        return tree_over(self.points)

    @cached_property
    def lengths(self) -> FloatArray:
        """Lengths (e,) of the edges, [unit]."""
        if self.stencil is None:
            tail, head = self.edges.T
            return read_only(np.linalg.norm(self.points[head] - self.points[tail], axis=1))
        return read_only(self.stencil.lengths[self.edge_numbers])

    @cached_property
    def edge_numbers(self) -> ByteArray:
        """Directions (e,) in the stencil of the edges at their first nodes, for a lattice."""
        assert self.stencil is not None
        # only the families' shapes count, whatever the nodes' values
        values = np.empty(len(self.points), dtype=np.bool_)
        families = REGULAR[self.lattice].edges(values, self.cells)
        numbers = [np.full(a.size, self.stencil.ends(step)[0], np.uint8) for a, _, step in families]
        return read_only(np.concatenate(numbers))

    @cached_property
    def box(self) -> tuple[FloatArray, FloatArray]:
        """Low and high corner (3,) of the workspace, [unit], world."""
        return read_only(self.points.min(axis=0)), read_only(self.points.max(axis=0))

    @cached_property
    def longest_edge(self) -> float:
        """Length of the longest edge, [unit]."""
        return float((self.lengths if self.stencil is None else self.stencil.lengths).max())

    @cached_property
    def edge_count(self) -> int:
        """Number of edges."""
        if self.stencil is None:
            return len(self.edges)
        return int(np.bitwise_count(self.open_directions).sum(dtype=np.int64)) // 2

    @cached_property
    def adjacency(self) -> Adjacency:
        """The mesh in the format of the kernels."""
        if self.stencil is not None:
            return adjacency.of_lattice(self.stencil, len(self.points))
        indptr, indices, _ = self._rows
        return adjacency.of_rows(self.points, indptr, indices)

    @cached_property
    def open_directions(self) -> IntArray:
        """Directions in which each node of a lattice has a neighbour, as bits (n,); else 0."""
        if self.stencil is None:
            return read_only(np.zeros(len(self.points), dtype=np.int32))
        return self.stencil.open_directions(len(self.points))

    @property
    def weights(self) -> FloatArray:
        """Lengths of the directions (d,), or of the edges of the rows (2e,), [unit]."""
        return self._rows[2] if self.stencil is None else self.stencil.lengths

    @property
    def neighbours(self) -> tuple[IntArray, IntArray]:
        """Compressed rows: where each node's neighbours begin (n + 1,), and the neighbours."""
        return self._rows[:2]

    @cached_property
    def _rows(self) -> tuple[IntArray, IntArray, FloatArray]:
        return adjacency.rows(self.edges, self.lengths, len(self.points))


IRREGULAR: Mapping[str, Callable[[Workspace, Cells, int], tuple[FloatArray, IntArray]]] = (
    MappingProxyType({"delaunay": jittered_delaunay})
)
"""Functions by lattice name: nodes (n, 3) and tetrahedra (m, 4) of a box, its cells and a seed."""


def tetrahedralise(workspace: Workspace, settings: MeshSettings) -> TetMesh:
    """Fill the workspace with tetrahedra.

    The box is divided into cells that are as nearly cubes as it allows: those of a regular lattice
    (:data:`abi.tet_mesh.lattice.REGULAR`), or the ones whose corners an irregular one displaces
    (:data:`IRREGULAR`).

    Args:
        workspace: the box.
        settings: lattice, pitch and seed; the number of nodes was checked with the scene.
    """
    cells = settings.cells(workspace)
    if settings.lattice in IRREGULAR:
        points, tetrahedra = IRREGULAR[settings.lattice](workspace, cells, settings.seed)
        return TetMesh(
            lattice=settings.lattice,
            cells=cells,
            pitch=float((np.asarray(workspace.size) / cells).min()),
            points=read_only(points),
            irregular=read_only(tetrahedra),
        )
    low, high = np.array(workspace.min), np.array(workspace.max)
    stencil = Stencil.of(settings.lattice, low, high, cells)
    return TetMesh(
        lattice=settings.lattice,
        cells=cells,
        pitch=float(stencil.lengths.min()),
        points=read_only(REGULAR[settings.lattice].points(low, high, cells)),
        stencil=stencil,
    )


def edges_of(tetrahedra: IntArray, nodes: int) -> IntArray:
    """Edges of tetrahedra, each once, lower id first, sorted.

    Args:
        tetrahedra: (m, 4) node ids.
        nodes: number of nodes, larger than every id.

    Returns:
        edges: (e, 2) node ids.
    """
    tetrahedra = arguments.ids("tetrahedra", tetrahedra, (-1, 4), nodes)
    ends = tetrahedra[:, _CORNER_PAIRS].reshape(-1, 2)
    keys = np.unique(ends.min(axis=1).astype(np.int64) * nodes + ends.max(axis=1))
    return np.stack(np.divmod(keys, nodes), axis=1).astype(np.int32)


_IN_USE: WeakValueDictionary[tuple[Workspace, MeshSettings], TetMesh] = WeakValueDictionary()


def shared_mesh(workspace: Workspace, settings: MeshSettings) -> TetMesh:
    """Return the mesh of a box that is in use, or a new one, as :func:`tetrahedralise` makes it.

    Tables of a large one take megabytes, and never change.
    """
    key = workspace, settings
    mesh = _IN_USE.get(key)
    return mesh or _IN_USE.setdefault(key, tetrahedralise(workspace, settings))
