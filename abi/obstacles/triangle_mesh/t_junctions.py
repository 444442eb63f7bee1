"""Edges of a triangle mesh on which corners of other triangles lie, as CAD programs write them."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from abi.arrays import FloatArray, IntArray

_ROUNDS = 6
"""A triangle is split along one of its edges at a time; pieces may have to be split again."""
_MOST = 5_000_000
"""Most pairs of an edge and a corner near it that are looked at."""
_AT_ONCE = 100
"""Edges whose pairs are counted before it is asked whether they are too many."""


def split_at_corners(
    vertices: FloatArray, faces: IntArray, size: float
) -> tuple[IntArray, IntArray]:
    """Split triangles whose free edges run past corners, so that these edges have two sides.

    An edge is free where its sides do not cancel: that of one solid may have two sides of another.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) ids of the corners.
        size: distance from an edge within which a corner lies on it.

    Returns:
        Faces (m, 3) of which no free edge has a free corner of another within, and faces (k, 3) as
        they were, whose pieces lie a little beside them.
    """
    before = [faces[:0]]
    for _ in range(_ROUNDS):
        split, pieces, beside = _split_once(vertices, faces, size)
        if not len(split):
            break
        before.append(faces[split[beside]])
        faces = np.concatenate([np.delete(faces, split, axis=0), pieces])
    return faces, np.concatenate(before)


def _split_once(
    vertices: FloatArray, faces: IntArray, size: float
) -> tuple[NDArray[np.int64], IntArray, NDArray[np.int64]]:
    """Faces (k,) to split along one edge each, their pieces, and those that pieces lie beside."""
    sides = np.stack([faces, faces[:, [1, 2, 0]]], axis=-1).reshape(-1, 2)
    keys = sides.min(axis=1).astype(np.int64) * len(vertices) + sides.max(axis=1)
    _, edge = np.unique(keys, return_inverse=True)
    balance = np.bincount(edge, np.where(sides[:, 0] < sides[:, 1], 1, -1))
    free = np.flatnonzero(balance[edge] != 0)
    none = np.empty(0, dtype=np.int64)
    ends = np.unique(sides[free])
    if not len(free):
        return none, faces[:0], none
    a, b = vertices[sides[free, 0]], vertices[sides[free, 1]]
    lengths = np.linalg.norm(b - a, axis=1)
    tree = scipy.spatial.cKDTree(vertices[ends])
    around = (a + b) / 2, lengths / 2 + size
    several, total = list[IntArray](), 0
    for one in np.split(np.arange(len(free)), range(_AT_ONCE, len(free), _AT_ONCE)):
        several.append(tree.query_ball_point(*(each[one] for each in around), return_length=True))
        total += int(several[-1].sum())
        if total > _MOST:
            return none, faces[:0], none
    counts = np.concatenate(several)
    near = ends[np.concatenate(tree.query_ball_point(*around)).astype(np.intp)]
    at = np.repeat(np.arange(len(free)), counts)
    along = (b - a)[at] / lengths[at, None]
    offsets = vertices[near] - a[at]
    place = np.einsum("ij,ij->i", offsets, along)
    distance = np.linalg.norm(offsets - place[:, None] * along, axis=1)
    third = faces.ravel()[free - free % 3 + (free + 2) % 3]
    is_on = (distance <= size) & (place > size) & (lengths[at] - place > size)
    is_on &= near != third[at]
    near, at, place, distance = near[is_on], at[is_on], place[is_on], distance[is_on]
    # one edge of a face: the first that has corners on it
    face = free // 3
    first = np.full(len(faces), len(free))
    np.minimum.at(first, face[at], at)
    is_first = first[face[at]] == at
    order = np.lexsort((place[is_first], at[is_first]))
    near, at, distance = (one[is_first][order] for one in (near, at, distance))
    split, begins = np.unique(at, return_index=True)
    counts = np.diff(begins, append=len(at))
    tails = np.insert(near, begins, sides[free[split], 0])
    heads = np.insert(near, begins + counts, sides[free[split], 1])
    pieces = np.stack([tails, heads, np.repeat(third[split], counts + 1)], axis=1)
    is_beside = np.maximum.reduceat(distance, begins) > 0 if len(at) else np.zeros(0, np.bool_)
    return face[split], pieces.astype(np.int32), np.flatnonzero(is_beside)
