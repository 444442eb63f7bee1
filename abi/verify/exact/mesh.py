"""A triangle mesh in exact rational numbers, for :mod:`abi.verify.verify`.

Most of its many inequalities are far from equality. Those are decided in floating point with a
bound of the error, and only the others in rationals, so every answer is exact.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.verify.exact.solids import Vec3, dot, in_body, sub, times_length, vector

_ROUNDING = 2.0**-50
"""Relative rounding of a sum of products, over the sum of their magnitudes."""
_SMALLEST = 2.0**-1073
"""Absolute error of products too small for their digits, for each factor and in total."""

Side = tuple[Fraction, Fraction, Vec3, Fraction]
"""First and last parameter of a piece, a direction, and its least product with the piece."""


@dataclass(frozen=True, eq=False)
class ExactMesh:
    """A triangle mesh, placed in the world.

    Attributes:
        vertices: (n, 3), body frame, in the file's unit.
        faces: (m, 3) ids of the corners.
        closed: whether it has an inside, the points that any of its layers winds around.
        factor: [unit] per unit of the file.
        position: [unit], world.
        wxyz: rotation as a quaternion of any length but zero.
        layers: numbers of the faces of each layer, one after another; () where it is one.
    """

    vertices: FloatArray
    faces: IntArray
    closed: bool
    factor: float
    position: Vec3
    wxyz: tuple[float, float, float, float]
    layers: tuple[int, ...] = ()

    def uncovered(
        self, sides: Sequence[Side], first: Fraction, last: Fraction, margin: Fraction
    ) -> Fraction | None:
        """Parameter from which some triangle is not separated; None if all are.

        Args:
            sides: pieces, in the order of their first parameters.
            first: where the curve begins.
            last: where it ends.
            margin: distance to keep, [unit].
        """
        ends = sorted({first, *(end for _, end, _, _ in sides)})
        rank = {end: k for k, end in enumerate(ends)}
        reached = np.full(len(self.faces), rank[first])
        for start, end, normal, least in sides:
            joins = bisect_left(ends, start)
            rows = np.flatnonzero((reached >= joins) & (reached < rank[end]))
            rows = rows[self._separated(rows, normal, least, margin)]
            reached[rows] = rank[end]
        at = ends[int(reached.min())]
        return at if at < last else None

    def _separated(
        self, rows: NDArray[np.intp], normal: Vec3, least: Fraction, margin: Fraction
    ) -> BoolArray:
        """Mask of the triangles farther than ``margin`` from all x with normal·x >= ``least``."""
        factor = Fraction(self.factor)
        direction = in_body(normal, self.wxyz)
        limit = (least - dot(normal, self.position) - times_length(margin, normal)) / factor
        rounded = np.array([float(part) for part in direction])
        corners = np.unique(self.faces[rows])
        points = self.vertices[corners]
        products = points @ rounded
        error = _ROUNDING * (np.abs(points) @ np.abs(rounded) + abs(float(limit)))
        error += _SMALLEST * (1 + np.abs(points).sum(axis=1))
        below = products + error < float(limit)
        for k in np.flatnonzero(~below & (products - error < float(limit))):
            below[k] = dot(vector(points[k].tolist()), direction) < limit
        of_corner = np.zeros(len(self.vertices), dtype=bool)
        of_corner[corners] = below
        return np.asarray(of_corner[self.faces[rows]].all(axis=1))

    def inside(self, point: Vec3) -> bool:
        """Test whether a layer of a closed mesh winds around a point that is not on its surface.

        It counts the triangles that a ray along the body's x crosses, with a sign for the
        direction. A ray that meets an edge is treated as if its y and z were infinitesimally
        greater. An open mesh has no inside.
        """
        if not self.closed:
            return False
        x, y, z = in_body(sub(point, self.position), self.wxyz)
        factor = Fraction(self.factor)
        x, y, z = x / factor, y / factor, z / factor
        corners = self.vertices[self.faces]
        low, high = corners.min(axis=1), corners.max(axis=1)
        pad = _ROUNDING * max(abs(float(y)), abs(float(z)))
        near = (low[:, 1] <= float(y) + pad) & (high[:, 1] >= float(y) - pad)
        near &= (low[:, 2] <= float(z) + pad) & (high[:, 2] >= float(z) - pad)
        ends = np.cumsum(self.layers or (len(corners),))
        layer = np.searchsorted(ends, np.flatnonzero(near), side="right").tolist()
        winding = [0] * len(ends)
        for number, triangle in zip(layer, corners[near].tolist(), strict=True):
            a, b, c = (sub(vector(corner), (x, y, z)) for corner in triangle)
            if sum(_right_of_origin(*edge) for edge in ((a, b), (b, c), (c, a))) % 2:
                area = _cross(a, b) + _cross(b, c) + _cross(c, a)
                ahead = a[0] * _cross(b, c) + b[0] * _cross(c, a) + c[0] * _cross(a, b)
                if (ahead > 0) == (area > 0):
                    winding[number] += 1 if area > 0 else -1
        return any(winding)


def _cross(a: Vec3, b: Vec3) -> Fraction:
    """Cross product of the y and z parts."""
    return a[1] * b[2] - a[2] * b[1]


def _right_of_origin(a: Vec3, b: Vec3) -> bool:
    """Test whether, in the plane of y and z, the ray from the origin along y passes the edge."""
    if (a[2] > 0) == (b[2] > 0):
        return False
    return _cross(a, b) > 0 if b[2] > a[2] else _cross(a, b) < 0
