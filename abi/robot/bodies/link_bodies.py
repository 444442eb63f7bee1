"""Bodies that stand for a link when distances are measured: convex hulls, each in a capsule.

The shapes of a link are cut into pieces. A piece is inside a capsule, with which most distances are
decided, and inside the convex hull of a few points, which is hardly larger than the piece.
"""

from __future__ import annotations

import itertools
import math
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy

from abi.arrays import FloatArray, IntArray, read_only
from abi.robot.bodies.bounding_capsules import Capsule, principal_axes, smallest_capsule
from abi.robot.urdf.robot import Link, Shape

if TYPE_CHECKING:
    import trimesh

_SECTIONS = 32
_PARTS = 3
"""Pieces of a shape, at most."""
_MOST = 12
"""Shapes of a link that are pieces of their own, at most; of more all are one."""
_WORTH = 0.8
"""Pieces are cut where their hulls are smaller together than this part of those before."""
_CORNERS = 40
"""Corners of a hull, at most, and in any case those that it needs to have a volume."""
_FINE = 0.005
"""Part of a piece's size by which its corners may be outside of a hull of fewer corners."""
_PAD = 1e-9
"""Rounding of a hull: a part of the largest coordinate, [m]."""
_TINY, _ROUNDING = 1e-300, 1e-13


class Body(NamedTuple):
    """A piece of a link: it is in the capsule as well as in the hull, [m].

    Attributes:
        capsule: around the piece.
        points: corners of the hull in the link's frame, shape (k, 3).
        rounding: distance from the hull that belongs to it, too.
    """

    capsule: Capsule
    points: FloatArray
    rounding: float


@lru_cache(maxsize=512)
def link_bodies(link: Link) -> tuple[Body, ...]:
    """Bodies whose union contains a link's shapes and visuals; none for a frame.

    Visuals inside the capsules of the shapes change these not, and enlarge hulls a little.
    """
    if not link.shapes:
        return ()
    groups = [[shape] for shape in link.shapes]
    if len(groups) > _MOST:
        groups = [list(link.shapes)]
    pieces = [piece for group in groups for piece in _pieces_of(group)]
    if not link.visuals:
        return tuple(_body(piece) for piece in pieces)
    drawn = np.concatenate([_triangles(shape) for shape in link.visuals])
    holder = _holders([_capsule(piece) for piece in pieces], drawn)
    if (holder < 0).any():
        solid = np.concatenate([_triangles(shape) for shape in link.shapes])
        return tuple(_body(piece) for piece in _parts(np.concatenate([solid, drawn])))
    return tuple(_body(piece, drawn[holder == k]) for k, piece in enumerate(pieces))


class _Ball(NamedTuple):
    """A sphere as it is given."""

    centre: FloatArray
    radius: float


_Piece = FloatArray | _Ball
"""Points (n, 3) around which a body is made, or a ball."""


def _pieces_of(shapes: list[Shape]) -> list[_Piece]:
    """Pieces of shapes that belong together."""
    if len(shapes) == 1 and shapes[0].kind == "sphere":
        return [_Ball(shapes[0].pose[:3, 3], shapes[0].size[0])]
    return [*_parts(np.concatenate([_triangles(shape) for shape in shapes]))]


def _body(piece: _Piece, drawn: FloatArray | None = None) -> Body:
    """Body around a piece, and triangles (n, 3, 3) that its capsule holds."""
    capsule = _capsule(piece)
    if isinstance(piece, _Ball):
        rest = piece.radius
        if drawn is not None and len(drawn):
            away = np.linalg.norm(drawn.reshape(-1, 3) - piece.centre, axis=1)
            rest = max(rest, float(away.max()))
        return Body(capsule, read_only(piece.centre[None].copy()), rest * (1 + _PAD))
    points = piece if drawn is None else np.concatenate([piece, drawn.reshape(-1, 3)])
    corners = _few_corners(points)
    return Body(capsule, read_only(corners), _PAD * (1e-3 + float(np.abs(corners).max())))


def _capsule(piece: _Piece) -> Capsule:
    if isinstance(piece, _Ball):
        return Capsule(piece.centre, piece.centre, piece.radius * (1 + _PAD) + 1e-12)
    return smallest_capsule(piece)


def _few_corners(points: FloatArray) -> FloatArray:
    """Corners (k, 3) of a hull around points; all of them where these are in a plane.

    Of the points' own hull those corners are taken, one by one, that are farthest outside of the
    hull of those before; then it grows about its middle until it holds all.
    """
    try:
        corners = points[scipy.spatial.ConvexHull(points).vertices]
        size = float(np.ptp(corners, axis=0).max())
        chosen = {int(k) for way in _WAYS for k in (np.argmax(corners @ way),)}
        while True:
            hull = scipy.spatial.ConvexHull(corners[sorted(chosen)])
            outside = (corners @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1)
            farthest = int(outside.argmax())
            if outside[farthest] <= _FINE * size or len(chosen) >= _CORNERS or farthest in chosen:
                break
            chosen.add(farthest)
        middle = corners[sorted(chosen)].mean(axis=0)
        depth = -(hull.equations[:, :3] @ middle + hull.equations[:, 3])
        growth = ((corners - middle) @ hull.equations[:, :3].T / depth).max()
        if not 1 - 1e-6 <= growth < 2:  # too flat for that
            return np.asarray(corners)
        own = corners[sorted(chosen)]
        return np.asarray(middle + max(float(growth), 1.0) * (own - middle))
    except scipy.spatial.QhullError:
        return np.unique(points, axis=0)


_WAYS = np.array([way for way in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(way)])
"""Directions in which a hull's first corners are sought."""


def _holders(capsules: list[Capsule], triangles: FloatArray) -> IntArray:
    """Number of the first capsule that holds each of triangles (n, 3, 3), -1 for none, (n,)."""
    points = triangles.reshape(-1, 3)
    holder = np.full(len(triangles), -1)
    for number, (low, high, radius) in reversed([*enumerate(capsules)]):
        way = high - low
        share = np.clip((points - low) @ way / max(float(way @ way), _TINY), 0, 1)
        away = np.linalg.norm(points - low - share[:, None] * way, axis=1)
        holder[(away <= radius - _ROUNDING).reshape(-1, 3).all(axis=1)] = number
    return holder


def _parts(triangles: FloatArray) -> list[FloatArray]:
    """Points (n, 3) of each part of triangles, as few parts as are worth it."""
    best = [triangles.reshape(-1, 3)]
    least = _volume(best[0])
    for count in range(2, _PARTS + 1):
        parts = _row(triangles, count)
        volume = sum(map(_volume, parts))
        if volume < _WORTH * least:
            best, least = parts, volume
    return best


def _volume(points: FloatArray) -> float:
    """Volume of the hull of points, 0 where they are in a plane, [m³]."""
    try:
        return float(scipy.spatial.ConvexHull(points).volume)
    except scipy.spatial.QhullError:
        return 0.0


def _triangles(shape: Shape) -> FloatArray:
    """Corners (n, 3, 3) in the link's frame of triangles around a shape."""
    if shape.kind == "mesh":
        corners = shape.vertices[shape.faces]
    else:
        corners = np.asarray(_around_solid(shape).triangles)
    return np.asarray(corners @ shape.pose[:3, :3].T + shape.pose[:3, 3])


def _around_solid(shape: Shape) -> trimesh.Trimesh:
    """Triangles that contain a box, sphere or cylinder."""
    import trimesh  # here, since it takes long to import

    solid: trimesh.Trimesh
    radius, length, _ = shape.size
    if shape.kind == "box":
        solid = trimesh.creation.box(extents=shape.size)
    elif shape.kind == "sphere":
        solid = trimesh.creation.icosphere(subdivisions=2)
        flattest = np.einsum("ij,ij->i", solid.triangles_center, solid.face_normals).min()
        solid.apply_scale(radius / float(flattest))  # type: ignore[no-untyped-call]
    else:
        around = radius / math.cos(math.pi / _SECTIONS)
        solid = trimesh.creation.cylinder(radius=around, height=length, sections=_SECTIONS)
    return solid


def _row(triangles: FloatArray, count: int) -> list[FloatArray]:
    """Points (n, 3) of the parts of triangles between planes across their longest axis."""
    points = triangles.reshape(-1, 3)
    axis = principal_axes(points)[0]
    along = points @ axis
    cuts = np.linspace(along.min(), along.max(), count + 1)
    pad = 1e-9 * (1 + float(np.abs(points).max()))
    parts = (_between(triangles, axis, a - pad, b + pad) for a, b in itertools.pairwise(cuts))
    return [part for part in parts if len(part)]


def _between(triangles: FloatArray, axis: FloatArray, low: float, high: float) -> FloatArray:
    """Corners (n, 3) of what of the triangles lies between two planes across ``axis``."""
    import trimesh  # here, since it takes long to import

    for sign, height in ((1.0, low), (-1.0, high)):
        if not len(triangles):
            break
        vertices, faces = triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3)
        vertices, faces, _ = trimesh.intersections.slice_faces_plane(  # type: ignore[no-untyped-call]
            vertices, faces, sign * axis, height * axis
        )
        triangles = np.asarray(vertices)[faces]
    return triangles.reshape(-1, 3)
