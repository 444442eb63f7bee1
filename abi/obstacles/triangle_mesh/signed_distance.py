"""Signed distances to a surface, and the tables that the kernels need for them.

Inside is where the surface winds around a point (Jacobson, Kavan and Sorkine-Hornung, Robust
inside-outside segmentation using generalized winding numbers, 2013). For a closed surface that
number is an integer, so an approximation decides.
"""

from __future__ import annotations

import numpy as np

from abi.arrays import FloatArray, read_only
from abi.obstacles.pose import Quaternion, Vec3, rotation
from abi.obstacles.triangle_mesh.bvh import (
    Dipoles,
    TriangleTree,
    build_tree,
    dipoles,
    moved,
    tree_of,
)
from abi.obstacles.triangle_mesh.per_surface import per_surface
from abi.obstacles.triangle_mesh.surface import Surface
from abi.obstacles.triangle_mesh.surface_tables_kernels import (
    DistanceGrid,
    Placement,
    SurfaceTables,
    grid_values,
)
from abi.obstacles.triangle_mesh.triangle_kernels import THIN

_ROUNDING = 2.0**-50
"""This over the height, as a part of the longest side, bounds the error as a part of that side, and
of the distance. Twenty times the largest found among 12,000 triangles."""


_NODES, _FEW_NODES = 60_000, 1_000
"""Nodes of the grid around a surface, about; and while that is filled as Python, in half a second.
"""

_BORDER = 0.1
"""Width of the grid around the surface on each side, over the surface's longest side."""

_COARSE = 1 / 16
"""Error of the grid's distances, in steps."""


def surface_tables(surface: Surface, fine: bool | None = None) -> SurfaceTables:
    """A surface in the format of the kernels, in its body frame; kept as long as it is.

    The frame has its origin in the middle of the surface's bounding box, where coordinates have the
    most digits, and a unit, a power of two of the file's, in which the surface is about 1 large.

    Args:
        surface: the surface.
        fine: whether its grid is fine or coarse; None for the finest one that is quickly had.
    """
    fine = is_fine_quick() if fine is None else fine
    return _with_fine_grid(surface) if fine else _with_coarse_grid(surface)


@per_surface
def _with_fine_grid(surface: Surface) -> SurfaceTables:
    return _with_nodes(surface, _NODES)


@per_surface
def _with_coarse_grid(surface: Surface) -> SurfaceTables:
    return _with_nodes(surface, _FEW_NODES)


def _with_nodes(surface: Surface, nodes: int) -> SurfaceTables:
    tree, far_field = _in_body_frame(surface)
    closed, extent = surface.closed, surface.extent * _body_frame(surface)[1]
    error = error_of_distances(tree.corners.reshape(-1, 3, 3))
    grid = _grid(tree, far_field, closed, nodes, error[0] + 4 * extent * error[1])
    return SurfaceTables(tree, far_field, grid, closed, extent, error)


@per_surface
def _in_body_frame(surface: Surface) -> tuple[TriangleTree, Dipoles]:
    frame = _body_frame(surface)
    tree = moved(tree_of(surface), *frame)
    if len(surface.layers) <= 1:
        return tree, dipoles(tree)
    layers = np.split(surface.vertices[surface.faces], np.cumsum(surface.layers)[:-1])
    return tree, dipoles(*(moved(build_tree(one), *frame) for one in layers))


@per_surface
def _body_frame(surface: Surface) -> tuple[FloatArray, float]:
    """The body frame's origin in the file (3,), and its units per unit of the file."""
    low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    return read_only((low + high) / 2), float(2.0 ** -np.round(np.log2(surface.extent)))


def is_fine_quick() -> bool:
    """Check whether fine grids are filled by compiled code, in less than a second."""
    return grid_values.compiled


def placement(surface: Surface, position: Vec3, wxyz: Quaternion, factor: float) -> Placement:
    """Placement of a surface's body frame in the world.

    Args:
        surface: the surface.
        position: the file's origin, [unit], world.
        wxyz: rotation of the file's axes.
        factor: scene's [unit] per unit of the file.
    """
    turned, (centre, scale) = rotation(wxyz), _body_frame(surface)
    x, y, z = (np.array(position) + turned @ (centre * factor)).tolist()
    a, b, c = (tuple(axis) for axis in turned.T.tolist())
    return Placement((x, y, z), (a, b, c), factor / scale)


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


def error_of_distances(triangles: FloatArray) -> tuple[float, float]:
    """Bound of the error of a point's distance: e + f d at a distance d; returns e and f.

    Distances are measured in double precision. Above a triangle's plane the error grows as the
    triangle gets thinner; the thinnest are replaced by their sides, which leaves out a part of
    them.

    Args:
        triangles: corners (m, 3, 3), around the origin; every triangle has an area.
    """
    size = float(np.abs(triangles).max())
    height, longest = _proportions(triangles / size)
    thin = height < THIN
    rounding = _ROUNDING / np.maximum(height, THIN)
    error = np.where(thin, height / 2, rounding) * longest
    slope = rounding[~thin].max(initial=_ROUNDING)
    return size * float(error.max() + _ROUNDING), float(slope)


def _proportions(corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Heights (m,) of triangles (m, 3, 3) as a part of their longest sides, and those (m,)."""
    sides = np.roll(corners, -1, axis=1) - corners
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2
    return np.asarray(2 * area / longest**2), np.asarray(longest)
