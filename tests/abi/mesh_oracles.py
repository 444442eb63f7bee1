"""Distances to triangle meshes by means that share nothing with the package's own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.spatial.distance import cdist

from abi.arrays import BoolArray, FloatArray
from abi.obstacles.triangle_mesh.surface import Surface
from tests.abi.meshes import Mesh


class Distances:
    """Distances of points to triangles, by VTK's grid of cells."""

    def __init__(self, mesh: Mesh) -> None:
        from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
        from vtkmodules.vtkCommonCore import vtkPoints
        from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData, vtkStaticCellLocator

        vertices, faces = mesh
        corners, cells = vtkPoints(), vtkCellArray()
        corners.SetDataTypeToDouble()
        corners.SetData(numpy_to_vtk(np.ascontiguousarray(vertices), deep=True))
        offsets = 3 * np.arange(len(faces) + 1, dtype=np.int64)
        cells.SetData(
            numpy_to_vtkIdTypeArray(offsets, deep=True),
            numpy_to_vtkIdTypeArray(faces.astype(np.int64).ravel(), deep=True),
        )
        surface = vtkPolyData()
        surface.SetPoints(corners)
        surface.SetPolys(cells)
        self._locator: Any = vtkStaticCellLocator()
        self._locator.SetDataSet(surface)
        self._locator.BuildLocator()

    def __call__(self, points: FloatArray) -> FloatArray:
        """Distances (n,) of points (n, 3)."""
        from vtkmodules.vtkCommonCore import reference
        from vtkmodules.vtkCommonDataModel import vtkGenericCell

        cell, number, part, square = vtkGenericCell(), reference(0), reference(0), reference(0.0)
        closest = np.empty_like(points)
        for point, there in zip(points, closest, strict=True):
            self._locator.FindClosestPoint(point, there, cell, number, part, square)
        return np.asarray(np.linalg.norm(points - closest, axis=1))


def is_solid(surface: Surface, points: FloatArray) -> BoolArray:
    """Whether any layer of a surface winds around each point (n, 3)."""
    ends = np.cumsum(surface.layers or (len(surface.faces),))
    layers = np.split(surface.vertices[surface.faces], ends[:-1])
    wound = [np.abs(winding_numbers(layer, points)) > 0.5 for layer in layers]
    return np.asarray(surface.closed & np.any(wound, axis=0))


def distances(mesh: Mesh, points: FloatArray) -> FloatArray:
    """Distances (n,) of points (n, 3) to the triangles of a mesh."""
    return Distances(mesh)(points)


def nearest(
    triangles: FloatArray, points: FloatArray, distances: Callable[[FloatArray, FloatArray], Any]
) -> FloatArray:
    """Least distances (n,) of points (n, 3) to triangles (m, 3, 3).

    ``distances`` gives those (k,) of points (k, 3) to a triangle (k, 3, 3) each. It is asked only
    about triangles that can be the nearest.
    """
    middle = triangles.mean(axis=1)
    radius = np.linalg.norm(triangles - middle[:, None], axis=2).max(axis=1)
    least = np.full(len(points), np.inf)
    for some in np.array_split(np.arange(len(points)), 1 + len(points) * len(middle) // 1_000_000):
        away = cdist(points[some], middle)
        # the ball around a triangle must reach as near as all of another's; rounding is far smaller
        surely = (away + radius).min(axis=1, keepdims=True) * (1 + 1e-9)
        row, triangle = np.nonzero(away - radius <= surely)
        point = some[row]
        np.minimum.at(least, point, distances(points[point], triangles[triangle]))
    return least


def winding_numbers(triangles: FloatArray, points: FloatArray) -> FloatArray:
    """Winding numbers from the angles of spherical triangles: the excess over pi, by L'Huilier."""
    numbers = np.empty(len(points))
    for i, x in enumerate(points):
        way = triangles - x
        a, b, c = (way / np.linalg.norm(way, axis=2, keepdims=True)).transpose(1, 0, 2)
        sides = [
            2 * np.arcsin(np.clip(_chord(p, q) / 2, 0, 1)) for p, q in ((b, c), (c, a), (a, b))
        ]
        half = sum(sides) / 2
        tangents = np.tan(half / 2)
        for side in sides:
            tangents = tangents * np.tan(np.maximum(half - side, 0) / 2)
        sign = np.sign(np.einsum("ij,ij->i", way[:, 0], np.cross(way[:, 1], way[:, 2])))
        numbers[i] = (sign * 4 * np.arctan(np.sqrt(np.abs(tangents)))).sum() / (4 * np.pi)
    return numbers


def signed_distances(mesh: Mesh, closed: bool, points: FloatArray) -> FloatArray:
    """Signed distances (n,) of points (n, 3)."""
    away = distances(mesh, points)
    if not closed:
        return away
    vertices, faces = mesh
    inside = np.abs(winding_numbers(vertices[faces], points)) > 0.5
    return np.where(inside, -away, away)


def _chord(p: FloatArray, q: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(p - q, axis=1))
