"""Signed distances to a surface, and the tables that the kernels need for them.

Inside is where the surface winds around a point (Jacobson, Kavan and Sorkine-Hornung, Robust
inside-outside segmentation using generalized winding numbers, 2013). For a closed surface that
number is an integer, so an approximation decides.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from abi.arrays import FloatArray, read_only
from abi.obstacles.pose import Quaternion, Vec3, rotation
from abi.obstacles.triangle_mesh.bvh import Dipoles, TriangleTree, dipoles, moved, tree_of
from abi.obstacles.triangle_mesh.per_surface import per_surface
from abi.obstacles.triangle_mesh.rounding import error_of_distances
from abi.obstacles.triangle_mesh.surface import Surface
from abi.obstacles.triangle_mesh.surface_tables_kernels import (
    DistanceGrid,
    Placement,
    SurfaceTables,
    grid_values,
)

_NODES, _FEW_NODES = 60_000, 1_000
"""Nodes of the grid around a surface, about; and while that is filled as Python, in half a second.
"""

_BORDER = 0.1
"""Width of the grid around the surface on each side, over the surface's longest side."""

_COARSE = 1 / 16
"""Error of the grid's distances, in steps."""


class BodyFrame:
    """Tables of a surface, and the frame in which they are.

    The frame has its origin in the middle of the surface's bounding box, where coordinates have the
    most digits, and a unit, a power of two of the file's, in which the surface is about 1 large.

    Attributes:
        centre: its origin in the file (3,).
        scale: body frame's units per unit of the file.
    """

    def __init__(self, surface: Surface) -> None:
        low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
        self.centre: FloatArray = read_only((low + high) / 2)
        self.scale = float(2.0 ** -np.round(np.log2(surface.extent)))
        self._closed, self._extent = surface.closed, surface.extent * self.scale
        self._tree = moved(tree_of(surface), self.centre, self.scale)
        self._far_field = dipoles(self._tree)

    @property
    def tables(self) -> SurfaceTables:
        """The surface in the format of the kernels, with the finest grid that is quickly had."""
        return self.with_grid(is_fine_quick())

    def prepare(self) -> None:
        """Fill the grid; otherwise the first question waits for it."""
        self.with_grid(is_fine_quick())

    def with_grid(self, fine: bool) -> SurfaceTables:
        """The surface in the format of the kernels, with a fine grid or a coarse one."""
        return self._with_fine_grid if fine else self._with_coarse_grid

    @cached_property
    def _with_fine_grid(self) -> SurfaceTables:
        return self._with_nodes(_NODES)

    @cached_property
    def _with_coarse_grid(self) -> SurfaceTables:
        return self._with_nodes(_FEW_NODES)

    def _with_nodes(self, nodes: int) -> SurfaceTables:
        tree, far_field, closed, extent = self._tree, self._far_field, self._closed, self._extent
        error = error_of_distances(tree.corners.reshape(-1, 3, 3))
        grid = _grid(tree, far_field, closed, nodes, error[0] + 4 * extent * error[1])
        return SurfaceTables(tree, far_field, grid, closed, extent, error)


def is_fine_quick() -> bool:
    """Check whether fine grids are filled by compiled code, in less than a second."""
    return grid_values.compiled


def placement(frame: BodyFrame, position: Vec3, wxyz: Quaternion, factor: float) -> Placement:
    """Placement of a body frame in the world.

    Args:
        frame: the frame.
        position: the file's origin, [unit], world.
        wxyz: rotation of the file's axes.
        factor: scene's [unit] per unit of the file.
    """
    turned = rotation(wxyz)
    x, y, z = (np.array(position) + turned @ (frame.centre * factor)).tolist()
    a, b, c = (tuple(axis) for axis in turned.T.tolist())
    return Placement((x, y, z), (a, b, c), factor / frame.scale)


def _grid(
    tree: TriangleTree, far_field: Dipoles, closed: bool, nodes: int, error: float
) -> DistanceGrid:
    """Sample the distance around the surface at some nodes, given a bound of the error."""
    box = tree.boxes[:6].reshape(2, 3)
    border = _BORDER * float(np.ptp(box, axis=0).max())
    size = np.ptp(box, axis=0) + 2 * border
    step = float(np.prod(size) / nodes) ** (1 / 3)
    nx, ny, nz = (np.ceil(size / step).astype(int) + 1).tolist()
    first = box.mean(axis=0) - (np.array([nx, ny, nz]) - 1) * step / 2
    x, y, z = first.tolist()
    slack = _COARSE * step
    values = grid_values(tree, far_field, closed, (nx, ny, nz), (x, y, z), step, slack)
    corners = tuple(box[0].tolist()), tuple(box[1].tolist())
    bound = slack + error + 1e-12 * float(size.max())
    return DistanceGrid(read_only(values), (nx, ny, nz), (x, y, z), step, corners, bound)


body_frame = per_surface(BodyFrame)
"""The body frame of a surface."""
