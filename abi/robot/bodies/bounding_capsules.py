"""Capsules that contain a link, which stand for its shapes when distances are measured."""

from __future__ import annotations

import itertools
import math
from functools import lru_cache
from operator import attrgetter
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy

from abi.arrays import FloatArray, read_only
from abi.robot.urdf.robot import Link, LinkShape

if TYPE_CHECKING:
    import trimesh

_SECTIONS = 32
_PARTS = 3
"""Capsules of a link, at most."""
_WORTH = 0.8
"""One more capsule is taken where all together are smaller than this part of those before."""
_STEPS = 60
_TINY, _ROUNDING = 1e-300, 1e-13


class BoundingCapsule(NamedTuple):
    """All points within ``radius`` of a segment, [m].

    Attributes:
        low, high: ends of the segment in the link's frame, shape (3,).
        radius: of the capsule.
    """

    low: FloatArray
    high: FloatArray
    radius: float

    @property
    def volume(self) -> float:
        """Volume, [m³]."""
        length = float(np.linalg.norm(self.high - self.low))
        return math.pi * self.radius**2 * (length + 4 / 3 * self.radius)


@lru_cache(maxsize=512)
def bounding_capsules(link: Link) -> tuple[BoundingCapsule, ...]:
    """Up to three capsules whose union contains a link's shapes and visuals; none for a frame.

    Visuals inside the capsules of the shapes change nothing.
    """
    if not link.shapes:
        return ()
    solid = np.concatenate([_triangles(shape) for shape in link.shapes])
    capsules = _capsules(solid)
    if not link.visuals:
        return capsules
    drawn = np.concatenate([_triangles(shape) for shape in link.visuals])
    return capsules if _hold(capsules, drawn) else _capsules(np.concatenate([solid, drawn]))


def _hold(capsules: tuple[BoundingCapsule, ...], triangles: FloatArray) -> bool:
    """Check whether each of triangles (n, 3, 3) is inside one of the capsules, which are convex."""
    points = triangles.reshape(-1, 3)
    held = np.zeros(len(triangles), dtype=bool)
    for low, high, radius in capsules:
        way = high - low
        share = np.clip((points - low) @ way / max(float(way @ way), _TINY), 0, 1)
        away = np.linalg.norm(points - low - share[:, None] * way, axis=1)
        held |= (away <= radius - _ROUNDING).reshape(-1, 3).all(axis=1)
    return bool(held.all())


def _capsules(triangles: FloatArray) -> tuple[BoundingCapsule, ...]:
    best = _row(triangles, 1)
    for count in range(2, _PARTS + 1):
        more = _row(triangles, count)
        if sum(part.volume for part in more) < _WORTH * sum(part.volume for part in best):
            best = more
    return best


def _triangles(shape: LinkShape) -> FloatArray:
    """Corners (n, 3, 3) in the link's frame of triangles around a shape."""
    if shape.kind == "mesh":
        corners = shape.vertices[shape.faces]
    else:
        corners = np.asarray(_around_solid(shape).triangles)
    return np.asarray(corners @ shape.pose[:3, :3].T + shape.pose[:3, 3])


def _around_solid(shape: LinkShape) -> trimesh.Trimesh:
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


def _row(triangles: FloatArray, count: int) -> tuple[BoundingCapsule, ...]:
    """Capsules around the parts of triangles between planes across their longest axis."""
    points = triangles.reshape(-1, 3)
    axis = _principal_axes(points)[0]
    along = points @ axis
    cuts = np.linspace(along.min(), along.max(), count + 1)
    if count == 1:
        return (_smallest_capsule(points),)
    pad = 1e-9 * (1 + float(np.abs(points).max()))
    parts = (_between(triangles, axis, a - pad, b + pad) for a, b in itertools.pairwise(cuts))
    return tuple(_smallest_capsule(part) for part in parts if len(part))


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


def _smallest_capsule(points: FloatArray) -> BoundingCapsule:
    """The smallest of the capsules around points along their principal axes."""
    hull = _corners(points)
    capsules = (_capsule_along_axis(hull, axis) for axis in _principal_axes(hull))
    return min(capsules, key=attrgetter("volume"))


def _capsule_along_axis(points: FloatArray, axis: FloatArray) -> BoundingCapsule:
    """Capsule along ``axis`` around points (n, 3)."""
    across = points - np.outer(points @ axis, axis)
    centre = across.mean(axis=0)
    # the least circle around them, by steps towards the farthest (Bădoiu and Clarkson, 2003)
    for step in range(1, _STEPS):
        farthest = int(np.einsum("ij,ij->i", across - centre, across - centre).argmax())
        centre = centre + (across[farthest] - centre) / (step + 1)
    radial = np.linalg.norm(across - centre, axis=1)
    radius = float(radial.max())
    cap = np.sqrt(radius**2 - radial**2)
    low, high = float((points @ axis + cap).min()), float((points @ axis - cap).max())
    if low > high:
        low = high = (low + high) / 2
    ends = read_only(centre + low * axis), read_only(centre + high * axis)
    return BoundingCapsule(*ends, radius * (1 + 1e-9) + 1e-12)


def _principal_axes(points: FloatArray) -> FloatArray:
    """Unit vectors (3, 3), the direction of the largest spread first."""
    return np.asarray(np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2])


def _corners(points: FloatArray) -> FloatArray:
    """Corners of the convex hull; all points where it is flat."""
    try:
        return np.asarray(points[scipy.spatial.ConvexHull(points).vertices])
    except scipy.spatial.QhullError:
        return points
