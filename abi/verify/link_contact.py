"""Contact of links by their own shapes, in floating point, with no code that plans.

All is triangles: a ball is one whose corners are its centre, with a radius, and a cylinder's rim
has 192 corners on it, or around it where it must not be smaller. Two links touch where triangles
are as near as their radii, or where one has a point inside a shell of the other that is closed: the
solid angle under which it sees the whole of that is a full one. Cavities are filled, since nothing
gets into them.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.robot.urdf.link import Link
from abi.verify.exact.mesh import ExactMesh
from abi.verify.exact.shape_triangles import circle, prism, rectangle, shape_triangles
from abi.verify.exact.solids import ExactSolid, in_body, vector

_NEAR = 1e-6
"""Distance that counts as none, over the size of both links."""
_CHUNK = 4096
_WHOLE = 1e-4
"""Accepted difference of a winding number from a whole one."""
_EDGES = ([0, 1, 2], [1, 2, 0])
_TINY = 1e-300

TrianglePairs = tuple[FloatArray, FloatArray, FloatArray]
"""Triangles of one link and of another, (k, 3, 3) each, and the distance within which each pair
counts as touching, (k,)."""


class LinkTriangles(NamedTuple):
    """Triangles of a link's shapes.

    Attributes:
        corners: (n, 3, 3).
        radii: distance from each that belongs to the link, (n,).
        shells: number of the connected surface that each is part of, (n,).
        firsts: number of a triangle of each shell.
    """

    corners: FloatArray
    radii: FloatArray
    shells: IntArray
    firsts: IntArray

    def placed(self, turn: FloatArray, origin: FloatArray) -> LinkTriangles:
        """The triangles turned by ``turn`` (3, 3) and moved by ``origin`` (3,)."""
        return self._replace(corners=self.corners @ turn.T + origin)


@lru_cache(maxsize=256)
def link_triangles(link: Link, scale: float, around: bool = False) -> LinkTriangles:
    """Triangles of a link in its own frame, in units of which ``scale`` are one metre.

    Those of cylinders are in them, or around them.
    """
    parts, radii, shells = list[FloatArray](), list[FloatArray](), list[IntArray]()
    count = 0
    for shape in link.shapes:
        triangles = shape_triangles(shape, around)
        shells.append(count + _shells(triangles))
        count = int(shells[-1].max()) + 1
        radius = shape.size[0] if shape.kind == "sphere" else 0.0
        radii.append(np.full(len(triangles), scale * radius))
        parts.append(scale * (triangles @ shape.pose[:3, :3].T + shape.pose[:3, 3]))
    numbers = np.concatenate(shells)
    firsts = np.unique(numbers, return_index=True)[1].astype(np.int32)
    return LinkTriangles(np.concatenate(parts), np.concatenate(radii), numbers, firsts)


def solid_triangles(solid: ExactSolid | ExactMesh, around: bool = False) -> LinkTriangles:
    """Triangles of an obstacle, world, [unit]; those of a cylinder are in it, or around it."""
    axes = [in_body(vector(axis), solid.wxyz) for axis in np.eye(3).tolist()]
    turn, radius = np.array(axes, dtype=np.float64), 0.0
    if isinstance(solid, ExactMesh):
        triangles = solid.factor * solid.vertices[solid.faces]
    else:
        *half, disc, radius = map(float, (*solid.half, solid.disc, solid.ball))
        if radius:  # around a point or a segment
            triangles = np.array([[[0, 0, -half[2]], [0, 0, half[2]], [0, 0, half[2]]]])
        elif disc:
            triangles = prism(circle(disc, around), half[2])
        else:
            triangles = prism(rectangle(half[0], half[1]), half[2])
    layers = (solid.layers if isinstance(solid, ExactMesh) else ()) or (len(triangles),)
    shells = _shells(triangles, np.repeat(np.arange(len(layers)), layers))
    firsts = np.unique(shells, return_index=True)[1].astype(np.int32)
    if isinstance(solid, ExactMesh) and not solid.closed:  # no triangle by itself has an inside
        shells = np.arange(len(triangles), dtype=np.int32)
    placed = triangles @ turn.T + np.array(solid.position, dtype=np.float64)
    return LinkTriangles(placed, np.full(len(placed), radius), shells, firsts)


def _shells(triangles: FloatArray, layer: NDArray[np.int64] | None = None) -> IntArray:
    """Number of the connected surface that each of triangles (n, 3, 3) is part of, (n,).

    What one winds around must not be taken away by another: those of other layers (n,) are apart.
    """
    layer = np.zeros(len(triangles), dtype=np.int64) if layer is None else layer
    corners = np.column_stack([triangles.reshape(-1, 3), np.repeat(layer, 3)])
    _, ids = np.unique(corners, axis=0, return_inverse=True)
    sides = ids.reshape(-1, 3)
    pairs = np.concatenate([sides[:, [0, 1]], sides[:, [1, 2]]]).T
    graph = scipy.sparse.coo_array((np.ones(pairs.shape[1]), pairs), (ids.max() + 1,) * 2)
    _, parts = scipy.sparse.csgraph.connected_components(graph, directed=False)
    return np.asarray(np.unique(parts[sides[:, 0]], return_inverse=True)[1])


def touch(first: LinkTriangles, second: LinkTriangles, near: float = _NEAR) -> bool:
    """Check whether two links touch, or are as near as a share of their size.

    Where that is less than 0, they have to be as deep in each other.
    """
    if holds(first, second) or holds(second, first):
        return True
    if any(meet(*few).any() for few in near_triangles(first, second, 0.0, near)):
        return True
    return near < 0 and _share_inside(first, second, -near)


def _share_inside(first: LinkTriangles, second: LinkTriangles, depth: float) -> bool:
    """Check whether points beside triangles that only touch, as flush faces do, are in both.

    The points are ``depth`` of the size from the middles of these, on both sides.
    """
    every = np.concatenate([first.corners.reshape(-1, 3), second.corners.reshape(-1, 3)])
    away = depth * float(np.ptp(every, axis=0).max())
    near = [np.zeros((2, 0), dtype=np.intp)]
    for i, j in _candidates(first, second, away):
        met = meet(first.corners[i], second.corners[j], first.radii[i] + second.radii[j] + away)
        near.append(np.stack([i[met], j[met]]))
    for rows, one, other in zip(np.hstack(near), (first, second), (second, first), strict=True):
        corners = one.corners[np.unique(rows)]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        lengths = np.linalg.norm(normal, axis=1, keepdims=True)
        step = away * normal / np.maximum(lengths, _TINY)
        points = np.concatenate([corners.mean(axis=1) + step, corners.mean(axis=1) - step])
        points = points[_inside(other, points)]
        if _inside(one, points).any():
            return True
    return False


def boxes_overlap(first: LinkTriangles, second: LinkTriangles) -> bool:
    """Check whether the boxes around two links overlap."""
    (low, high), (others_low, others_high) = map(_box, (first, second))
    return bool((low <= others_high).all() and (others_low <= high).all())


def _box(one: LinkTriangles) -> tuple[FloatArray, FloatArray]:
    """Low and high corner, (3,) each, of the box around a link."""
    low = (one.corners.min(axis=1) - one.radii[:, None]).min(axis=0)
    return low, (one.corners.max(axis=1) + one.radii[:, None]).max(axis=0)


def near_triangles(
    first: LinkTriangles, second: LinkTriangles, within: float, near: float = _NEAR
) -> Iterator[TrianglePairs]:
    """Triangles of two links that may be that near, and a share of the links' size nearer.

    They come some thousand at a time.
    """
    every = np.concatenate([first.corners.reshape(-1, 3), second.corners.reshape(-1, 3)])
    near = within + near * float(np.ptp(every, axis=0).max())
    for i, j in _candidates(first, second, near):
        reach = first.radii[i] + second.radii[j] + near
        yield first.corners[i], second.corners[j], reach


def holds(solid: LinkTriangles, other: LinkTriangles) -> bool:
    """Check whether a corner of a shell of ``other`` is inside a closed shell of ``solid``."""
    return bool(_inside(solid, other.corners[other.firsts, 0]).any())


def _inside(solid: LinkTriangles, points: FloatArray) -> BoolArray:
    """Mask of points (k, 3) that are inside a closed shell."""
    low, high = _box(solid)
    inside: BoolArray = np.asarray(((points >= low) & (points <= high)).all(axis=1))
    for row in np.flatnonzero(inside):
        a, b, c = (solid.corners - points[row]).swapaxes(0, 1)
        la, lb, lc = (np.linalg.norm(one, axis=1) for one in (a, b, c))
        volume = (a * np.cross(b, c)).sum(axis=1)
        spread = la * lb * lc + (a * b).sum(axis=1) * lc
        spread += (b * c).sum(axis=1) * la + (c * a).sum(axis=1) * lb
        turns = np.bincount(solid.shells, np.arctan2(volume, spread)) / (2 * np.pi)
        whole = np.round(turns)
        inside[row] = ((whole != 0) & (abs(turns - whole) < _WHOLE)).any()
    return inside


def _candidates(
    first: LinkTriangles, second: LinkTriangles, near: float
) -> Iterator[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Numbers of triangles of both whose bounds overlap, some thousand at a time."""
    boxes = []
    for one in (first, second):
        reach = (one.radii + near / 2)[:, None]
        boxes.append((one.corners.min(axis=1) - reach, one.corners.max(axis=1) + reach))
    (low, high), (others_low, others_high) = boxes
    beside = ((low <= others_high.max(axis=0)) & (high >= others_low.min(axis=0))).all(axis=1)
    inside = (others_low <= high.max(axis=0)) & (others_high >= low.min(axis=0))
    mine, theirs = np.flatnonzero(beside), np.flatnonzero(inside.all(axis=1))
    if not len(theirs):
        return
    step = max(_CHUNK * 64 // len(theirs), 1)
    for at in range(0, len(mine), step):
        rows = mine[at : at + step]
        both = np.ones((len(rows), len(theirs)), dtype=np.bool_)
        for axis in range(3):
            both &= low[rows, None, axis] <= others_high[None, theirs, axis]
            both &= high[rows, None, axis] >= others_low[None, theirs, axis]
        i, j = np.nonzero(both)
        for start in range(0, len(i), _CHUNK):
            few = slice(start, start + _CHUNK)
            yield rows[i[few]], theirs[j[few]]


def meet(a: FloatArray, b: FloatArray, reach: FloatArray) -> BoolArray:
    """Check which of triangles a (k, 3, 3) are within ``reach`` (k,) of b (k, 3, 3)."""
    left = np.flatnonzero(~(_beside(a, b, reach) | _beside(b, a, reach)))
    met = np.zeros(len(a), dtype=np.bool_)
    met[left] = _close(a[left], b[left], reach[left])
    return met


def _beside(a: FloatArray, b: FloatArray, reach: FloatArray) -> BoolArray:
    """Check which of triangles a are farther than ``reach`` on one side of the plane of b."""
    normal = np.cross(b[:, 1] - b[:, 0], b[:, 2] - b[:, 0])
    heights = np.einsum("kci,ki->kc", a - b[:, :1], normal)
    far = reach * np.sqrt(np.einsum("ki,ki->k", normal, normal))
    return np.asarray((heights.min(axis=1) > far) | (heights.max(axis=1) < -far))


def _close(a: FloatArray, b: FloatArray, reach: FloatArray) -> BoolArray:
    """Check which of triangles a (k, 3, 3) are within ``reach`` (k,) of b (k, 3, 3)."""
    found = np.zeros(len(a), dtype=np.bool_)
    for one, other in ((a, b), (b, a)):
        found |= _pierces(one, other, reach)
    for i, j in itertools.product(range(3), range(3)):
        ends = (one[:, column[k]] for one, k in ((a, i), (b, j)) for column in _EDGES)
        found |= _edge_distances(*ends) <= reach
    return found


def _pierces(a: FloatArray, b: FloatArray, reach: FloatArray) -> BoolArray:
    """Check whether an edge of a triangle goes through another, or a corner is close above it."""
    first, u, v = b[:, 0], b[:, 1] - b[:, 0], b[:, 2] - b[:, 0]
    normal = np.cross(u, v)
    square = (normal * normal).sum(axis=1)
    flat = square <= _TINY
    unit = normal / np.sqrt(np.where(flat, 1.0, square))[:, None]
    heights = ((a - first[:, None]) * unit[:, None]).sum(axis=2)
    above = _within(a - heights[..., None] * unit[:, None], b, normal, square)
    found = ((abs(heights) <= reach[:, None]) & above).any(axis=1)
    start, end = heights[:, _EDGES[0]], heights[:, _EDGES[1]]
    crosses = start * end < 0
    share = start / np.where(crosses, start - end, 1.0)
    points = a[:, _EDGES[0]] + share[..., None] * (a[:, _EDGES[1]] - a[:, _EDGES[0]])
    found |= (crosses & _within(points, b, normal, square)).any(axis=1)
    return np.asarray(found & ~flat)


def _within(points: FloatArray, b: FloatArray, normal: FloatArray, square: FloatArray) -> BoolArray:
    """Check which of points (k, m, 3) in the planes of triangles (k, 3, 3) are in these."""
    within = np.ones(points.shape[:2], dtype=np.bool_)
    for start, end in zip(*_EDGES, strict=True):
        edge, away = (b[:, end] - b[:, start])[:, None], points - b[:, None, start]
        side = (np.cross(np.broadcast_to(edge, away.shape), away) * normal[:, None]).sum(axis=2)
        within &= side >= 0
    return within & (square > _TINY)[:, None]


def _edge_distances(p: FloatArray, q: FloatArray, r: FloatArray, s: FloatArray) -> FloatArray:
    """Distances (k,) of the segments from p to q from those from r to s, (k, 3) each."""
    u, v, w = q - p, s - r, p - r
    uu, vv = (np.maximum((one * one).sum(axis=1), _TINY) for one in (u, v))
    uv, uw, vw = ((one * other).sum(axis=1) for one, other in ((u, v), (u, w), (v, w)))
    cross = uu * vv - uv * uv
    along = np.clip(np.where(cross > 0, (uv * vw - vv * uw) / np.maximum(cross, _TINY), 0), 0, 1)
    other = np.clip((uv * along + vw) / vv, 0, 1)
    along = np.clip((uv * other - uw) / uu, 0, 1)
    return np.asarray(np.linalg.norm(w + along[:, None] * u - other[:, None] * v, axis=1))
