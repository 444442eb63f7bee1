"""Bound of the rounding error of distances from points to triangles.

Distances are measured in double precision. Above a triangle's plane the error grows as the triangle
gets thinner; the thinnest triangles are replaced by their sides, which leaves out a part of them.
"""

from __future__ import annotations

import numpy as np

from abi.arrays import FloatArray
from abi.obstacles.triangle_mesh.triangle_kernels import THIN

_ROUNDING = 2.0**-50
"""This over the height, as a part of the longest side, bounds the error as a part of that side, and
of the distance. Twenty times the largest found among 12,000 triangles."""


def error_of_distances(triangles: FloatArray) -> tuple[float, float]:
    """Bound of the error of a point's distance: e + f d at a distance d; returns e and f.

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
