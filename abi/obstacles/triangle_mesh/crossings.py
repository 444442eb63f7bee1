"""Layers of shells: what one winds around is not taken away by what winds in another layer.

A shell that crosses itself may wind a negative number of times around a part of what it encloses;
added to what another shell winds around it, that part would be hollow. So those that may cross
themselves are in layers in which no box of another overlaps theirs.
"""

from __future__ import annotations

import itertools

import numpy as np
import scipy

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.obstacles.triangle_mesh.distinct_rows import distinct_rows, first_of_distinct_rows
from abi.obstacles.triangle_mesh.rays import near_boxes

_TOUCHES = 1e-13
"""Distance of a corner from a triangle, over the size of all, at which it is on it."""
_SHAKEN = 1e-9
"""Where triangles touch, corners are moved by so much, over the size of all, so that they do not.
What is larger in each direction winds the same number of times then."""
_TRIES = 3
_MOST_PAIRS = 5_000_000
"""Pairs of an edge and a triangle that are near each other and are compared, in some five seconds;
of shells with more, any may cross itself."""
_PAIRS_EACH = 20
"""So many for each triangle are compared in any case: more than evenly divided surfaces have."""
_MOST_NEAR = 2_000_000
"""Pairs of shells near each other that are looked for; of shells with more, any may be near one."""
_MOST_CROSSING = 10_000_000
"""Pairs of shells that may cross themselves, near each other, of which layers are made, in some
seconds; of more, these are in none."""
_CROWD = 200
"""Triangles at one corner, as of a fan, from which on these are taken not to lie on each other."""
_AXES = np.array(
    [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.8, 0.53, 0.27], [-0.53, 0.8, 0.27], [0.27, -0.27, 0.93]]
)
"""Directions along which it is asked whether an edge and a triangle overlap."""


def layers_of(vertices: FloatArray, faces: IntArray, label: IntArray) -> IntArray:
    """Layer (s,) of each shell; -1 of those that are in none.

    Those that do not cross themselves are in layer 0. There is no limit to how often they overlap:
    none of them winds a negative number of times around anything.

    Args:
        vertices: (n, 3).
        faces: (m, 3) ids of the corners, facing outward.
        label: (m,) shell of each face, each number from 0 on.
    """
    corners, shells = vertices[faces], int(label.max()) + 1
    low, high = np.full((shells, 3), np.inf), np.full((shells, 3), -np.inf)
    np.minimum.at(low, label, corners.min(axis=1))
    np.maximum.at(high, label, corners.max(axis=1))
    near, count = np.zeros(shells, dtype=np.bool_), 0
    for one, other in near_boxes((low, high), (low, high)):
        near[one[one != other]] = True
        count += len(one)
        if count > _MOST_NEAR:
            near[:] = True
            break
    # where a triangle is there twice, it may wind twice around what is behind
    once = first_of_distinct_rows(np.column_stack([np.sort(faces, axis=1), label]).astype(np.int64))
    may_cross = np.zeros(shells, dtype=np.bool_)
    may_cross[np.delete(label, once)] = True
    asked = ~may_cross & near
    may_cross[_crossing(vertices, faces[asked[label]], label[asked[label]])] = True
    layer = -may_cross.astype(np.int32)
    crossing = np.flatnonzero(may_cross)
    boxes, pairs, count = (low[crossing], high[crossing]), [np.zeros((2, 0), dtype=np.int32)], 0
    for one, other in near_boxes(boxes, boxes):
        is_before = other < one
        pairs.append(np.stack([one[is_before], other[is_before]]).astype(np.int32))
        count += pairs[-1].shape[1]
        if count > _MOST_CROSSING:
            return layer
    ends = np.concatenate(pairs, axis=1)
    before = scipy.sparse.coo_array((np.ones(count, np.int8), ends), (len(crossing),) * 2).tocsr()
    for row, shell in enumerate(crossing):
        others = crossing[before.indices[before.indptr[row] : before.indptr[row + 1]]]
        taken = set(layer[others].tolist())
        layer[shell] = next(number for number in itertools.count(1) if number not in taken)
    return layer


def _crossing(vertices: FloatArray, faces: IntArray, label: IntArray) -> IntArray:
    """Numbers of shells, given that (m,) of each face, that may cross or touch themselves."""
    random = np.random.default_rng(0)
    # each shell with corners of its own
    keys = faces + label[:, None].astype(np.int64) * len(vertices)
    ids, own = np.unique(keys, return_inverse=True)
    vertices, faces = vertices[ids % len(vertices)], own.reshape(-1, 3).astype(np.int32)
    for _ in range(_TRIES):
        if not len(faces):
            break
        met = _meeting(vertices, faces, label)
        if met is None:
            break
        stays = np.isin(label, label[met])
        faces, label = faces[stays], label[stays]
        moves = random.uniform(-_SHAKEN, _SHAKEN, vertices.shape)
        vertices = vertices + moves * np.ptp(vertices, axis=0).max()
    return np.unique(label)


def _meeting(vertices: FloatArray, faces: IntArray, label: IntArray) -> IntArray | None:
    """Numbers of faces (m, 3) that edges of their own shells (m,) run through or touch.

    None where too many are near each other to be compared.
    """
    corners = vertices[faces]
    sides = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    first, _ = distinct_rows(sides.astype(np.float64))
    edges, of_edge = sides[first], label[first // 3]
    ends, crowded = vertices[edges], np.bincount(faces.reshape(-1)) > _CROWD
    along = vertices @ _AXES.T
    edge_box, face_box = (
        (along[ids].min(axis=1), along[ids].max(axis=1)) for ids in (edges, faces)
    )
    touches = _TOUCHES * np.ptp(corners, axis=(0, 1)).max()
    met, pairs = [first[:0]], 0
    for one, other in near_boxes(edge_box, face_box):
        pairs += len(one)
        if pairs > max(_MOST_PAIRS, _PAIRS_EACH * len(faces)):
            return None
        same = of_edge[one] == label[other]
        one, other = one[same], other[same]
        shared = (edges[one][:, :, None] == faces[other][:, None]).any(axis=2)
        few = ~(shared & crowded[edges[one]]).any(axis=1)
        is_folded = _folded(ends[one[few]], corners[other[few]], shared[few], touches)
        apart = ~shared.any(axis=1)
        is_pierced = _pierced(ends[one[apart]], corners[other[apart]], touches)
        met += [other[few][is_folded], other[apart][is_pierced]]
    return np.concatenate(met)


def _pierced(ends: FloatArray, corners: FloatArray, touches: float) -> BoolArray:
    """Mask (k,) of edges (k, 2, 3) that run through triangles (k, 3, 3), or touch them."""
    a, b, c = corners.transpose(1, 0, 2)
    normal = _unit(np.cross(b - a, c - a))
    heights = np.einsum("ikj,ij->ik", ends - a[:, None], normal)
    flat = np.abs(heights) <= touches
    runs = (heights.prod(axis=1) < 0) | flat.any(axis=1)
    ends, normal, heights, flat, a, b, c = (
        one[runs] for one in (ends, normal, heights, flat, a, b, c)
    )
    # the part of the edge that is in the plane: a point, or all of it
    both = flat.all(axis=1)
    share = heights[:, 0] / np.where(both, 1.0, heights[:, 0] - heights[:, 1])
    start = ends[:, 0] + share[:, None] * (ends[:, 1] - ends[:, 0])
    start[both], stop = ends[both, 0], np.where(both[:, None], ends[:, 1], start)
    # clipped by the triangle's three sides, with the width of a touch
    low, high = np.zeros(len(start)), np.ones(len(start))
    for tail, head in ((a, b), (b, c), (c, a)):
        inward = _unit(np.cross(normal, head - tail))
        first, last = (np.einsum("ij,ij->i", end - tail, inward) + touches for end in (start, stop))
        _clip(first, last, low, high)
    runs[runs] = low <= high
    return np.asarray(runs)


def _clip(first: FloatArray, last: FloatArray, low: FloatArray, high: FloatArray) -> None:
    """Narrow the part of each way, from 0 to 1, to where a linear height is not below 0."""
    fall = first - last
    place = first / np.where(fall == 0, 1.0, fall)
    low[...] = np.where(fall < 0, np.maximum(low, place), low)
    high[...] = np.where(fall > 0, np.minimum(high, place), high)
    high[(fall == 0) & (first < 0)] = -1.0


def _folded(ends: FloatArray, corners: FloatArray, shared: BoolArray, touches: float) -> BoolArray:
    """Mask (k,) of edges that begin in a corner of a triangle and run along it, inside it."""
    starts = shared.sum(axis=1) == 1
    ends, corners, shared = ends[starts], corners[starts], shared[starts]
    first = np.where(shared[:, :1, None], ends[:, :1], ends[:, 1:])[:, 0]
    last = np.where(shared[:, :1, None], ends[:, 1:], ends[:, :1])[:, 0]
    place = np.linalg.norm(corners - first[:, None], axis=2).argmin(axis=1)
    b, c = (np.take_along_axis(corners, ((place + k) % 3)[:, None, None], 1)[:, 0] for k in (1, 2))
    normal = np.cross(b - first, c - first)
    normal = _unit(normal)
    way = last - first
    is_along = np.abs(np.einsum("ij,ij->i", way, normal)) <= touches
    beside_b = np.einsum("ij,ij->i", np.cross(b - first, way), normal)
    beside_c = np.einsum("ij,ij->i", np.cross(way, c - first), normal)
    width = touches * np.linalg.norm(way, axis=1)
    folded: BoolArray = starts.copy()
    folded[starts] = is_along & (beside_b > width) & (beside_c > width)
    return folded


def _unit(vectors: FloatArray) -> FloatArray:
    """Vectors (k, 3) of length 1; 0 where they are."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(lengths > 0, lengths, 1.0))
