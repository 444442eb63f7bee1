"""Stage 1: a tetrahedral mesh of the workspace, and what obstacles leave of it.

The paper (section III) asks for "a uniform mesh model with the same finite-element geometric
primitives in the form of a tetrahedron" and excludes the nodes inside the obstacle.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import Delaunay

from abi import lattice
from abi.arrays import BoolArray, FloatArray, IntArray, read_only
from abi.lattice import Cells
from abi.scene import MeshSettings, Workspace
from abi.shapes import Obstacles

_CORNER_PAIRS = np.array([(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)])

_JITTER = 0.3
"""Largest displacement of a node along each axis, in cells; below 0.5 nodes keep their order."""

_FLAT = 1e-9
"""Tetrahedra below this part of a cell's volume are flat: Delaunay's way to fill nothing where more
than four nodes lie on one sphere."""


@dataclass(frozen=True, eq=False)
class TetMesh:
    """Tetrahedra that fill the workspace.

    Attributes:
        lattice: ``bcc``, ``kuhn`` or ``delaunay``.
        cells: cubes along each axis.
        pitch: shortest edge of the lattice, [unit]; of the undisturbed grid for ``delaunay``.
        points: (n, 3), [unit], world.
        edges: (e, 2) node ids, lower id first, each edge once.
        lengths: (e,) lengths of the edges, [unit].
        irregular: tetrahedra of ``delaunay``; None for a lattice, where they follow from ``cells``.
    """

    lattice: str
    cells: Cells
    pitch: float
    points: FloatArray
    edges: IntArray
    lengths: FloatArray
    irregular: IntArray | None = None

    @cached_property
    def tetrahedra(self) -> IntArray:
        """Node ids of the tetrahedra, shape (m, 4), positively oriented; made when first asked."""
        if self.irregular is not None:
            return self.irregular
        ids = np.arange(len(self.points), dtype=np.int32)
        families = [
            np.stack([corner.ravel() for corner in corners], axis=1)
            for corners in lattice.tetrahedra(self.lattice, ids, self.cells)
        ]
        return read_only(np.concatenate(families))


@dataclass(frozen=True, eq=False)
class FreeMesh:
    """A mesh without the nodes that are in an obstacle or nearer to it than the margin.

    Attributes:
        mesh: the whole mesh.
        excluded: (n,) True where a node is excluded.
        nodes: number of nodes kept.
    """

    mesh: TetMesh
    excluded: BoolArray
    nodes: int

    @cached_property
    def tetrahedra_kept(self) -> int:
        """Number of tetrahedra without an excluded corner."""
        free = ~self.excluded
        if self.mesh.irregular is not None:
            return int(np.count_nonzero(free[self.mesh.irregular].all(axis=1)))
        families = lattice.tetrahedra(self.mesh.lattice, free, self.mesh.cells)
        return sum(int(np.count_nonzero(a & b & c & d)) for a, b, c, d in families)


def tetrahedralise(workspace: Workspace, settings: MeshSettings) -> TetMesh:
    """Fill the workspace with tetrahedra.

    The box is divided into cubes, as nearly as it allows.

    - ``bcc``: nodes at the corners and centres of the cubes. Around each face between two cubes
      the two centres and the face's corners make four tetrahedra; in cubic cells all of these are
      congruent, with edges h and h·√3/2. Between a face of the box and the centre behind it stands
      a pyramid, which a diagonal of the face splits into two of the same volume as the others.
    - ``kuhn``: nodes at the corners; six tetrahedra around the diagonal of each cube.
    - ``delaunay``: the corners displaced at random, repeatably by ``settings.seed``, and
      triangulated by Delaunay. Nodes on a face, edge or corner of the box stay on it.

    Args:
        workspace: the box.
        settings: lattice, pitch and seed; the number of nodes was checked with the scene.
    """
    cells = settings.cells(workspace)
    cube = np.asarray(workspace.size) / cells
    if settings.lattice == "delaunay":
        return _irregular(workspace, cells, cube, settings.seed)
    points = lattice.points(settings.lattice, workspace.min, workspace.max, cells)
    ids = np.arange(len(points), dtype=np.int32)
    ends, lengths = [], []
    for a, b, step in lattice.edges(settings.lattice, ids, cells):
        ends.append(np.stack([a.ravel(), b.ravel()], axis=1))
        lengths.append(np.full(a.size, np.linalg.norm(cube * step)))
    return TetMesh(
        lattice=settings.lattice,
        cells=cells,
        pitch=min(float(length[0]) for length in lengths if length.size),
        points=read_only(points),
        edges=read_only(np.concatenate(ends)),
        lengths=read_only(np.concatenate(lengths)),
    )


def exclude(mesh: TetMesh, obstacles: Obstacles, margin: float) -> FreeMesh:
    """Exclude the nodes whose signed distance to an obstacle is less than ``margin``, [unit].

    Removing nodes alone is not enough: an edge between two free nodes can still cross an obstacle.
    :func:`abi.graph.build` tests the edges.
    """
    excluded = np.zeros(len(mesh.points), dtype=np.bool_)
    for obstacle in obstacles:
        low, high = obstacle.bounds()
        window = within(mesh.points, low - margin, high + margin)
        excluded[window] |= obstacle.closer(mesh.points[window], margin)
    nodes = len(excluded) - int(np.count_nonzero(excluded))
    return FreeMesh(mesh, read_only(excluded), nodes)


def edges_of(tetrahedra: IntArray, nodes: int) -> IntArray:
    """Edges of tetrahedra, each once, lower id first, sorted.

    Args:
        tetrahedra: (m, 4) node ids.
        nodes: number of nodes, larger than every id.

    Returns:
        edges: (e, 2) node ids.
    """
    ends = tetrahedra[:, _CORNER_PAIRS].reshape(-1, 2)
    keys = np.unique(ends.min(axis=1).astype(np.int64) * nodes + ends.max(axis=1))
    return np.stack(np.divmod(keys, nodes), axis=1).astype(np.int32)


def volumes(points: FloatArray, tetrahedra: IntArray) -> FloatArray:
    """Signed volumes of tetrahedra, shape (m,), [unit³]: (b - a) × (c - a) · (d - a) / 6."""
    a, b, c, d = (points[tetrahedra[:, corner]] for corner in range(4))
    return np.asarray(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6)


def within(points: FloatArray, low: FloatArray, high: FloatArray) -> IntArray:
    """Ids of the points (n, 3) in the closed box ``low``..``high``, [unit], ascending."""
    ids = np.flatnonzero((points[:, 0] >= low[0]) & (points[:, 0] <= high[0]))
    for axis in (1, 2):
        values = points[ids, axis]
        ids = ids[(values >= low[axis]) & (values <= high[axis])]
    return ids.astype(np.int32)


def _irregular(workspace: Workspace, cells: Cells, cube: FloatArray, seed: int) -> TetMesh:
    """The grid with displaced nodes; a node on a face of the box is not moved out of its plane."""
    points = lattice.grid(workspace.min, workspace.max, cells)
    inside = (points > np.asarray(workspace.min)) & (points < np.asarray(workspace.max))
    displacement = np.random.default_rng(seed).uniform(-_JITTER, _JITTER, points.shape)
    points += np.where(inside, displacement * cube, 0.0)
    tetrahedra = _delaunay(points, cells)
    edges = edges_of(tetrahedra, len(points))
    lengths = np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1)
    return TetMesh(
        lattice="delaunay",
        cells=cells,
        pitch=float(cube.min()),
        points=read_only(points),
        edges=read_only(edges),
        lengths=read_only(lengths),
        irregular=read_only(tetrahedra),
    )


def _delaunay(points: FloatArray, cells: Cells) -> IntArray:
    """Delaunay tetrahedra of positive volume, (m, 4), positively oriented."""
    # relative to the box: Delaunay works with squares, which lose digits far from the origin
    tetrahedra: IntArray = Delaunay(points - points.min(axis=0)).simplices.astype(np.int32)
    volume = volumes(points, tetrahedra)
    tetrahedra[volume < 0] = tetrahedra[volume < 0][:, [0, 1, 3, 2]]
    cube = np.prod(np.ptp(points, axis=0) / cells)
    return np.asarray(tetrahedra[np.abs(volume) > _FLAT * cube])
