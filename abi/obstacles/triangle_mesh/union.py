"""Union of closed shells, by the manifold3d library (Lalish, Apache-2.0)."""

from __future__ import annotations

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.obstacles.triangle_mesh.distinct_rows import distinct_rows
from abi.obstacles.triangle_mesh.rays import near_boxes

_MOST_SHELLS = 2000
_MOST_PAIRS = 20_000_000
"""Most pairs of triangles, those of one shell included, that are looked at for that."""
_MOST_CROSSING = 500_000
"""Most pairs of triangles of different shells that are near each other; each may make others."""
_ROUNDING = 1e-6
_TURNED = -0.5
"""Cosine below which a triangle of the union faces the other way than the one it is a part of."""


def united(
    vertices: FloatArray, faces: IntArray, label: IntArray, most: int
) -> tuple[FloatArray, IntArray] | None:
    """Vertices (n, 3) and faces (m, 3) of the union of shells that face outward.

    The library's union winds 1 - (1 - a)(1 - b) times where its parts wind a and b times. So where
    both wind twice, as where each runs into itself, it would be hollow, and triangles there face
    the other way: such a union is not taken.

    Args:
        vertices: (n, 3).
        faces: (m, 3) ids of the corners.
        label: (m,) the shell of each face, any numbers.
        most: triangles that the union may have.

    Returns:
        The union; None if the library refuses a shell or takes other triangles for it, as where
        more than two meet in an edge, if shells run into themselves, if the result is smaller than
        the input, or if it has too many triangles, or would have.
        The shells as they are have the same outside.
    """
    import manifold3d

    shells, normals = [], dict[int, FloatArray]()
    _, number = np.unique(label, return_inverse=True)
    count = int(number.max()) + 1
    if count > _MOST_SHELLS or _are_many(vertices[faces], number.astype(np.int32)):
        return None
    order = np.argsort(number, kind="stable")
    for rows in np.split(order, np.cumsum(np.bincount(number, minlength=count))[:-1]):
        used, ids = np.unique(faces[rows], return_inverse=True)
        corners = np.ascontiguousarray(vertices[used])
        triangles: IntArray = ids.reshape(-1, 3).astype(np.int32)
        shell = manifold3d.Manifold(manifold3d.Mesh64(corners, triangles.astype(np.uint64)))
        if shell.status() != manifold3d.Error.NoError or shell.is_empty():
            return None
        taken = shell.to_mesh64()
        if not _are_same(
            np.array(taken.vert_properties[:, :3])[taken.tri_verts], corners[triangles]
        ):
            return None
        shells.append(shell)
        normals[int(taken.run_original_id[0])] = _normals(corners, triangles)
    union = manifold3d.Manifold.batch_boolean(shells, manifold3d.OpType.Add)
    if union.status() != manifold3d.Error.NoError or not 0 < union.num_tri() <= most:
        return None
    mesh = union.to_mesh64()
    points = np.array(mesh.vert_properties[:, :3], dtype=np.float64)
    given = vertices[np.unique(faces)]
    size = np.ptp(given, axis=0).max()
    shift = max(
        np.abs(points.min(axis=0) - given.min(axis=0)).max(),
        np.abs(points.max(axis=0) - given.max(axis=0)).max(),
    )
    largest = max(shell.volume() for shell in shells)
    if shift > _ROUNDING * size or union.volume() < largest * (1 - _ROUNDING):
        return None
    merged: IntArray = np.array(mesh.tri_verts).astype(np.int32)
    facing = _normals(points, merged)
    origins = np.repeat(mesh.run_original_id, np.diff(mesh.run_index) // 3)
    for origin, before in normals.items():
        rows = np.flatnonzero(origins == origin)
        same = np.einsum("ij,ij->i", facing[rows], before[np.asarray(mesh.face_id)[rows]])
        if (same < _TURNED).any():
            return None
    return points, merged


def _are_many(corners: FloatArray, number: IntArray) -> bool:
    """Whether too many triangles (m, 3, 3) of different shells (m,) may cross."""
    low, high = corners.min(axis=1), corners.max(axis=1)
    shells = int(number.max()) + 1
    lowest, highest = np.full((shells, 3), np.inf), np.full((shells, 3), -np.inf)
    np.minimum.at(lowest, number, low)
    np.maximum.at(highest, number, high)
    near = np.zeros(len(corners), dtype=np.bool_)
    for one, shell in near_boxes((low, high), (lowest, highest)):
        near[one[number[one] != shell]] = True
    boxes, of, count, all_pairs = (low[near], high[near]), number[near], 0, 0
    for one, other in near_boxes(boxes, boxes) if near.any() else ():
        all_pairs += len(one)
        count += int((of[one] < of[other]).sum())
        if count > _MOST_CROSSING or all_pairs > _MOST_PAIRS:
            return True
    return False


def _are_same(one: FloatArray, other: FloatArray) -> bool:
    """Whether triangles with corners (m, 3, 3) are the same, in any order and from any side."""
    if one.shape != other.shape:
        return False
    _, ids = distinct_rows(np.concatenate([one, other]).reshape(-1, 3) + 0.0)
    first, second = np.sort(ids.reshape(2, -1, 3), axis=2)
    return bool((first[np.lexsort(first.T)] == second[np.lexsort(second.T)]).all())


def _normals(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Unit normals (m, 3) of faces; 0 of those without area."""
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(normals / np.where(lengths > 0, lengths, 1.0))
