"""Joining of a triangle mesh's corners, and the order of what is left."""

from __future__ import annotations

import numpy as np
import scipy

from abi.arrays import FloatArray, IntArray
from abi.obstacles.triangle_mesh.distinct_rows import distinct_rows, first_of_distinct_rows, in_rows

_LONGEST = 2.0
"""Extent of vertices that are joined at once, over the distance of those next to each other."""


def weld(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    """Join equal vertices, and drop degenerate faces."""
    return _joined(vertices, faces, distinct_rows(vertices + 0.0))  # -0.0 is 0.0


def _joined(
    vertices: FloatArray, faces: IntArray, distinct: tuple[IntArray, IntArray]
) -> tuple[FloatArray, IntArray]:
    """Join vertices: see :func:`distinct_rows` for those that stay and the number of each."""
    first, ids = distinct
    welded = ids[faces]
    a, b, c = welded.T
    welded = welded[(a != b) & (b != c) & (c != a)]
    return compact(vertices[first], welded.astype(np.int32))


def weld_nearby(
    vertices: FloatArray, faces: IntArray, size: float
) -> tuple[FloatArray, IntArray, IntArray]:
    """Join vertices that are near, but not those of faces that would vanish untraceably.

    Returns:
        Vertices (n, 3), those of the surface before behind its own; its faces (m, 3); and faces
        (k, 3) as they were before a corner of theirs moved.
    """
    first, ids = near_rows(vertices, size)
    moved = (vertices[first][ids] != vertices).any(axis=1)[faces].any(axis=1)
    corners = ids[faces].astype(np.int64)
    sides = np.sort(np.stack([corners, corners[:, [1, 2, 0]]], axis=-1), axis=-1)
    keys = sides[..., 0] * (len(vertices) + 1) + sides[..., 1]
    is_side = sides[..., 0] != sides[..., 1]
    stays = is_side.all(axis=1)
    # of a needle that vanishes its longest side has to be a side of another face
    seen = ~is_side | np.isin(keys, keys[stays])
    seen &= np.isin(corners, corners[stays])
    lost = ~stays & ~seen.all(axis=1)
    welded, kept = _joined(vertices, faces[~lost], (first, ids))
    both = np.concatenate([kept, faces[lost] + np.int32(len(welded))])
    welded, both = weld(np.concatenate([welded, vertices]), both)
    before = faces[moved & ~lost] + np.int32(len(welded))
    return np.concatenate([welded, vertices]), both, before


def near_rows(vertices: FloatArray, size: float) -> tuple[IntArray, IntArray]:
    """Those of vertices in the same cube of side ``size`` count as one, and so do near ones.

    What lies on both sides of a border of cubes is joined, too, unless a whole chain would be.

    Returns:
        The vertices that stay, and for each vertex the number of the one that it becomes.
    """
    first, ids = distinct_rows(np.round(vertices / size) + 0.0)
    places = vertices[first]
    pairs = scipy.spatial.cKDTree(places).query_pairs(size, output_type="ndarray")
    edges = np.ones(len(pairs), np.int8), (pairs[:, 0], pairs[:, 1])
    graph = scipy.sparse.coo_matrix(edges, (len(first), len(first)))
    count, group = scipy.sparse.csgraph.connected_components(graph, directed=False)
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, group, places)
    np.maximum.at(high, group, places)
    is_chain = ((high - low).max(axis=1) > _LONGEST * size)[group]
    group = np.where(is_chain, count + np.arange(len(first)), group)
    _, stays, number = np.unique(group, return_index=True, return_inverse=True)
    return first[stays].astype(np.int32), number[ids].astype(np.int32)


def without_duplicates(faces: IntArray) -> tuple[IntArray, IntArray]:
    """Each triangle once, in the order of the file, and its reverse if that occurs too."""
    corners = np.sort(faces, axis=1)
    first = first_of_distinct_rows(corners.astype(np.int64))
    if len(first) == len(faces):
        return faces, faces[:0]
    twice = in_rows(corners[first], np.delete(corners, first, axis=0))
    return faces[first], faces[first][twice, ::-1]


def compact(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    """Remove the vertices that no face uses."""
    is_used = np.zeros(len(vertices), dtype=np.bool_)
    is_used[faces] = True
    ids = np.cumsum(is_used, dtype=np.int32) - np.int32(1)
    return np.ascontiguousarray(vertices[is_used]), ids[faces]


def in_order(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    """Sort the vertices as welding does, so that a surface read again is the same."""
    order = np.lexsort(vertices.T[::-1])
    number = np.empty(len(order), dtype=np.int32)
    number[order] = np.arange(len(order), dtype=np.int32)
    return vertices[order], number[faces]


def faces_in_order(faces: IntArray) -> IntArray:
    """Sort the faces by their corners, whatever order a union has given them."""
    turned = _turned(faces)
    return turned[np.lexsort(turned.T[::-1])]


def _turned(faces: IntArray) -> IntArray:
    """The faces with their lowest corner first, seen from the same side."""
    first = faces.argmin(axis=1)[:, None]
    return np.take_along_axis(faces, (first + np.arange(3)) % 3, axis=1)
