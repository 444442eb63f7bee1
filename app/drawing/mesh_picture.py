"""Triangles with which a mesh is drawn: all of them, or fewer if there are very many."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from abi.arrays import FloatArray, IntArray, read_only
from abi.obstacles.triangle_mesh.surface import Surface

MOST_DRAWN = 150_000
"""Most triangles that a page draws smoothly while it is dragged."""

_CELLS = 512  # along the longest side, at first


@lru_cache(maxsize=16)
def drawn_triangles(surface: Surface) -> tuple[FloatArray, IntArray]:
    """Simplified vertices (n, 3) and triangles (m, 3) of a surface, in its coordinates.

    Of more than ``MOST_DRAWN`` triangles, the corners in each cell of a grid become their mean, and
    what has no area then is left out (Rossignac and Borrel, Multi-resolution 3D approximations,
    1993). The picture is off by a cell's diagonal at most.
    """
    vertices, faces = surface.vertices, surface.faces
    cells = _CELLS
    while len(faces) > MOST_DRAWN:
        vertices, faces = _clustered(surface, cells)
        cells = cells * 3 // 4
    return read_only(vertices.astype(np.float32)), read_only(faces.astype(np.uint32))


def _clustered(surface: Surface, cells: int) -> tuple[FloatArray, IntArray]:
    low = surface.vertices.min(axis=0)
    places = ((surface.vertices - low) * (cells / surface.extent)).astype(np.int64)
    keys = (places[:, 0] * (cells + 1) + places[:, 1]) * (cells + 1) + places[:, 2]
    _, label, counts = np.unique(keys, return_inverse=True, return_counts=True)
    means = np.stack(
        [np.bincount(label, surface.vertices[:, k]) / counts for k in range(3)], axis=1
    )
    faces = label[surface.faces]
    a, b, c = faces.T
    return means, faces[(a != b) & (b != c) & (c != a)].astype(np.int32)
