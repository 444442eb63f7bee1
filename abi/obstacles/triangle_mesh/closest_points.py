"""Closest points of triangles, by the VTK library (Kitware, BSD-3-Clause).

VTK measures in double precision. The rounding error grows as triangles get thinner, and the
thinnest it passes over. So thin triangles count as their three sides, and a bound of the error
comes with the distances.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from abi.arrays import FloatArray, IntArray

if TYPE_CHECKING:
    from vtkmodules.vtkCommonDataModel import vtkCellArray

_THIN = 3e-8
"""A triangle whose height is below this part of its longest side counts as its sides."""

_ROUNDING = 2.0**-50
"""This over the height, as a part of the longest side, bounds the error as a part of that side:
twenty times the largest among 12,000 triangles."""

_IN_A_CELL = 25
"""Triangles in a cell of VTK's grid; a third quicker than its own choice for 80,000 triangles."""


class ClosestPoints:
    """Closest points of a surface.

    Attributes:
        error: bound of the error of a distance.
    """

    error: float

    def __init__(self, vertices: FloatArray, faces: IntArray) -> None:
        """Sort the triangles into the cells of VTK's grid.

        Args:
            vertices: (n, 3).
            faces: (m, 3) ids of the corners; every triangle has an area.
        """
        # not at the top: only scenes with a mesh need it, and it takes a while
        from vtkmodules.util.numpy_support import numpy_to_vtk
        from vtkmodules.vtkCommonCore import vtkPoints
        from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkStaticCellLocator

        # VTK's tolerances are absolute, so bring the surface to a size near 1; a power of two
        # rounds nothing
        self._scale = float(2.0 ** -np.round(np.log2(np.ptp(vertices, axis=0).max())))
        scaled = vertices * self._scale
        height, longest = _proportions(scaled[faces])
        thin = height < _THIN
        error = np.where(thin, height / 2, _ROUNDING / np.maximum(height, _THIN)) * longest
        self.error = float(error.max() + _ROUNDING * np.abs(scaled).max()) / self._scale
        points = vtkPoints()
        points.SetDataTypeToDouble()
        points.SetData(numpy_to_vtk(scaled, deep=True))
        cells = vtkPolyData()
        cells.SetPoints(points)
        sides = faces[thin][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
        cells.SetLines(_cells(sides))
        cells.SetPolys(_cells(faces[~thin]))
        # VTK counts lines first
        self._triangle = np.concatenate([np.repeat(np.flatnonzero(thin), 3), np.flatnonzero(~thin)])
        self._locator: Any = vtkStaticCellLocator()  # its hints know neither arrays nor references
        self._locator.SetDataSet(cells)
        self._locator.SetNumberOfCellsPerNode(_IN_A_CELL)
        self._locator.BuildLocator()

    def offsets(self, points: FloatArray) -> tuple[FloatArray, IntArray]:
        """Offsets (n, 3) of points (n, 3) from the closest points, and the triangles (n,) of these.

        One call into VTK a point, which is as quick as many at once and lets other threads run.
        """
        from vtkmodules.vtkCommonCore import reference
        from vtkmodules.vtkCommonDataModel import vtkGenericCell

        cell, part, squared = vtkGenericCell(), reference(0), reference(0.0)
        number: Any = reference(0)
        closest = np.empty((len(points), 3))
        cells = np.empty(len(points), dtype=np.int32)
        scaled = points * self._scale
        for i in range(len(points)):
            self._locator.FindClosestPoint(scaled[i], closest[i], cell, number, part, squared)
            cells[i] = number
        return np.asarray((scaled - closest) / self._scale), self._triangle[cells]


def _proportions(corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Heights (m,) of triangles (m, 3, 3) as a part of their longest sides, and those (m,)."""
    sides = np.roll(corners, -1, axis=1) - corners
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2
    return np.asarray(2 * area / longest**2), np.asarray(longest)


def _cells(corners: IntArray) -> vtkCellArray:
    """Lines (m, 2) or triangles (m, 3) as VTK's cells."""
    from vtkmodules.util.numpy_support import numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonDataModel import vtkCellArray

    cells = vtkCellArray()
    offsets = corners.shape[1] * np.arange(len(corners) + 1, dtype=np.int64)
    ids = np.ascontiguousarray(corners, dtype=np.int64).ravel()
    cells.SetData(
        numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(ids, deep=True)
    )
    return cells
