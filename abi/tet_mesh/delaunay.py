"""An irregular lattice: the corners of cubes, displaced at random and triangulated by Delaunay."""

from __future__ import annotations

import numpy as np
import scipy

from abi import arguments
from abi.arrays import FloatArray, IntArray
from abi.scene.settings import Workspace
from abi.tet_mesh.regular_lattice import Cells, grid

_JITTER = 0.3
"""Largest random displacement of a node along each axis, in cells; below 0.5 their order stays."""

_SLIVER = 1e-9
"""Part of a cell's volume below which a tetrahedron is left out: where more than four nodes lie on
one sphere, Delaunay's triangulation has tetrahedra without volume."""


def jittered_delaunay(workspace: Workspace, cells: Cells, seed: int) -> tuple[FloatArray, IntArray]:
    """The grid with displaced nodes; those on a face of the box stay in its plane.

    Args:
        workspace: the box.
        cells: cubes along each axis.
        seed: of the displacements; the same seed gives the same nodes.

    Returns:
        Nodes (n, 3), [unit], world, and tetrahedra (m, 4), positively oriented.
    """
    cube = np.asarray(workspace.size) / cells
    points = grid(workspace.min, workspace.max, cells)
    inside = (points > np.asarray(workspace.min)) & (points < np.asarray(workspace.max))
    displacement = np.random.default_rng(seed).uniform(-_JITTER, _JITTER, points.shape)
    points += np.where(inside, displacement * cube, 0.0)
    return points, _delaunay(points, cells)


def _delaunay(points: FloatArray, cells: Cells) -> IntArray:
    """Delaunay tetrahedra of positive volume, (m, 4), positively oriented."""
    # relative to the box: Delaunay works with squares, which lose digits far from the origin
    tetrahedra: IntArray = scipy.spatial.Delaunay(points - points.min(axis=0)).simplices.astype(
        np.int32
    )
    volume = volumes(points, tetrahedra)
    tetrahedra[volume < 0] = tetrahedra[volume < 0][:, [0, 1, 3, 2]]
    cube = np.prod(np.ptp(points, axis=0) / cells)
    return np.asarray(tetrahedra[np.abs(volume) > _SLIVER * cube])


def volumes(points: FloatArray, tetrahedra: IntArray) -> FloatArray:
    """Signed volumes of tetrahedra, shape (m,), [unit³]: (b - a) × (c - a) · (d - a) / 6."""
    points = arguments.points("points", points)
    tetrahedra = arguments.ids("tetrahedra", tetrahedra, (-1, 4), len(points))
    a, b, c, d = (points[tetrahedra[:, corner]] for corner in range(4))
    return np.asarray(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6)
