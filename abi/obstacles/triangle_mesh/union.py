"""Union of closed shells, by the manifold3d library (Lalish, Apache-2.0)."""

from __future__ import annotations

import numpy as np

from abi.arrays import FloatArray, IntArray

_MOST_SHELLS = 2000
_ROUNDING = 1e-6


def united(
    vertices: FloatArray, faces: IntArray, label: IntArray
) -> tuple[FloatArray, IntArray] | None:
    """Vertices (n, 3) and faces (m, 3) of the union of shells that face outward.

    Args:
        vertices: (n, 3).
        faces: (m, 3) ids of the corners.
        label: (m,) the shell of each face, any numbers.

    Returns:
        The union; None if the library refuses a shell, or if the result is smaller than the input.
        The shells as they are have the same outside.
    """
    import manifold3d

    shells = []
    _, number = np.unique(label, return_inverse=True)
    count = int(number.max()) + 1
    if count > _MOST_SHELLS:
        return None
    order = np.argsort(number, kind="stable")
    for rows in np.split(order, np.cumsum(np.bincount(number, minlength=count))[:-1]):
        used, ids = np.unique(faces[rows], return_inverse=True)
        corners = np.ascontiguousarray(vertices[used])
        triangles = ids.reshape(-1, 3).astype(np.uint64)
        shell = manifold3d.Manifold(manifold3d.Mesh64(corners, triangles))
        if shell.status() != manifold3d.Error.NoError or shell.is_empty():
            return None
        shells.append(shell)
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
    return points, np.array(mesh.tri_verts, dtype=np.int32)
