"""Union of closed shells, by the manifold3d library (Lalish, Apache-2.0)."""

from __future__ import annotations

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.obstacles.triangle_mesh.distinct_rows import distinct_rows
from abi.obstacles.triangle_mesh.winding import windings

_MOST_SHELLS = 2000
_ROUNDING = 1e-6
_TURNED = -0.5
"""Cosine below which a triangle of the union faces the other way than the one it is a part of."""
_MOST_WOUND = 4 * 10**6
"""Most pairs of a triangle and a point beside one that are looked at, in a second or two."""
_SPOTS = np.array([[1, 1, 1], [28, 1, 1], [1, 28, 1], [1, 1, 28]])
"""Places in a triangle beside which points are looked at: its middle, and near its corners."""
_BESIDE = 1e-6
"""Distance of these points from it, over the size of all."""


def united(
    vertices: FloatArray, faces: IntArray, label: IntArray
) -> tuple[FloatArray, IntArray] | None:
    """Vertices (n, 3) and faces (m, 3) of the union of shells that face outward.

    The library's union winds 1 - (1 - a)(1 - b) times where its parts wind a and b times. So where
    both wind twice, as where each runs into itself, it would be hollow, and triangles there face
    the other way: such a union is not taken.

    Args:
        vertices: (n, 3).
        faces: (m, 3) ids of the corners.
        label: (m,) the shell of each face, any numbers.

    Returns:
        The union; None if the library refuses a shell or takes other triangles for it, as where
        more than two meet in an edge, if shells run into themselves, or if the result is smaller
        than the input.
        The shells as they are have the same outside, unless they :func:`cancel`.
    """
    import manifold3d

    shells, normals = [], dict[int, FloatArray]()
    _, number = np.unique(label, return_inverse=True)
    count = int(number.max()) + 1
    if count > _MOST_SHELLS:
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
    if union.status() != manifold3d.Error.NoError or union.is_empty():
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


def cancel(vertices: FloatArray, faces: IntArray, label: IntArray) -> bool:
    """Check whether shells, as they are, wind around nothing in total where one of them does.

    So it is in a lobe of a shell that crosses itself, around which it winds -1 times, and which is
    in another shell. It is looked for beside the triangles, of many beside some.

    Args:
        vertices: (n, 3).
        faces: (m, 3) ids of the corners.
        label: (m,) the shell of each face, any numbers.
    """
    _, number = np.unique(label, return_inverse=True)
    each = _wound(vertices, faces, number.astype(np.int32))
    return bool((each.any(axis=0) & (each.sum(axis=0) == 0)).any())


def _wound(vertices: FloatArray, faces: IntArray, number: IntArray) -> IntArray:
    """How often each of k shells winds around points beside triangles, (k, p).

    The points are in the boxes of two shells. Where there would be too many, some are left out.
    """
    corners, count = vertices[faces], int(number.max()) + 1
    normals = _normals(vertices, faces)[:, None] * (_BESIDE * np.ptp(corners, axis=(0, 1)).max())
    spots = (_SPOTS / _SPOTS.sum(axis=1, keepdims=True)) @ corners
    points = np.stack([spots + normals, spots - normals]).reshape(-1, 3)
    points = points[:: _odd(count * len(points))]
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, number, corners.min(axis=1))
    np.maximum.at(high, number, corners.max(axis=1))
    boxes = zip(low, high, strict=True)
    within = np.array([((a <= points) & (points <= b)).all(axis=1) for a, b in boxes])
    kept = np.flatnonzero(within.sum(axis=0) > 1)
    pairs = int(within[:, kept].sum(axis=1) @ np.bincount(number))
    kept = kept[:: _odd(pairs)]
    points, within = points[kept], within[:, kept]
    each: IntArray = np.zeros(within.shape, dtype=np.int32)
    for shell, there in enumerate(within):
        if there.any():
            each[shell, there] = windings(vertices, faces[number == shell], points[there])
    return each


def _odd(pairs: int) -> int:
    """Step by which to take points, so that they are of each spot and side, and not too many."""
    return (pairs // _MOST_WOUND + 1) | 1


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
