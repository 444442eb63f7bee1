"""Number of times that a closed surface winds around points."""

from __future__ import annotations

import numpy as np

from abi.arrays import FloatArray, IntArray

_CHUNK = 1_000_000
"""Triangles times points that are in memory at once."""


def windings(vertices: FloatArray, faces: IntArray, points: FloatArray) -> IntArray:
    """How often closed triangles wind around points (k,), which are not on them.

    The solid angles under which they are seen are added up (Van Oosterom and Strackee, The solid
    angle of a plane triangle, 1983).

    Args:
        vertices: (n, 3).
        faces: (m, 3) ids of the corners, of a surface without a boundary.
        points: (k, 3).
    """
    total = np.zeros(len(points))
    step = max(_CHUNK // max(len(points), 1), 1)
    for first in range(0, len(faces), step):
        a, b, c = (vertices[corner][:, None] - points for corner in faces[first : first + step].T)
        far_a, far_b, far_c = (np.linalg.norm(one, axis=2) for one in (a, b, c))
        volume = np.einsum("ijk,ijk->ij", a, np.cross(b, c))
        ab, bc, ca = (np.einsum("ijk,ijk->ij", *pair) for pair in ((a, b), (b, c), (c, a)))
        below = far_a * far_b * far_c + ab * far_c + bc * far_a + ca * far_b
        total += 2 * np.arctan2(volume, below).sum(axis=0)
    return np.rint(total / (4 * np.pi)).astype(np.int64)
