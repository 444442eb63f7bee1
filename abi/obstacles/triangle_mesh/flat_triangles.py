"""Triangles without area: mere lines, most of which lie along sides of other triangles."""

from __future__ import annotations

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.obstacles.triangle_mesh.distinct_rows import distinct_rows
from abi.obstacles.triangle_mesh.shells import areas_of

_ROUNDS = 16


def uncovered_lines(vertices: FloatArray, faces: IntArray) -> int:
    """Count the triangles without area that lie along no side of a triangle with one.

    Such a triangle is as long as its longest side. It is covered where that is a side of another,
    or where both its shorter ones are; what covers it may be one without area that is covered.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) ids of the corners.
    """
    flat = np.flatnonzero(~(areas_of(vertices, faces) > 0))
    if not len(flat):
        return 0
    ids = distinct_rows(vertices + 0.0)[1].astype(np.int64)[faces]
    sides = np.sort(np.stack([ids, ids[:, [1, 2, 0]]], axis=-1), axis=-1)
    keys = sides[..., 0] * (len(vertices) + 1) + sides[..., 1]
    ends = vertices[faces[flat]]
    lengths = np.linalg.norm(ends - ends[:, [1, 2, 0]], axis=2)
    order = np.argsort(lengths, axis=1)
    of_flat = np.take_along_axis(keys[flat], order, axis=1)
    is_point = np.take_along_axis(lengths, order, axis=1) == 0
    is_proper = np.ones(len(faces), dtype=np.bool_)
    is_proper[flat] = False
    covered = np.unique(keys[is_proper])
    used = np.zeros(len(vertices) + 1, dtype=np.bool_)
    used[ids[is_proper]] = True
    at = ids[flat, 0]
    for _ in range(_ROUNDS):
        along = np.isin(of_flat, covered) | is_point
        whole = along[:, 2] & (~is_point[:, 2] | used[at])
        whole |= along[:, :2].all(axis=1) & ~is_point[:, 2]
        grown = np.union1d(covered, of_flat[whole])
        if len(grown) == len(covered):
            break
        covered = grown
    return int((~whole).sum())
