"""Bodies that stand for a link when distances are measured: convex hulls, each in a capsule.

The collision shapes of a link are cut into pieces; visuals are for looks. A piece is inside a
capsule, with which most distances are decided, and inside the convex hull of a few points, which is
hardly larger than the piece.
"""

from __future__ import annotations

import hashlib
import itertools
import math
from functools import lru_cache
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
import scipy

from abi.arrays import FloatArray, read_only
from abi.robot.bodies import body_store, bounding_capsules
from abi.robot.bodies.bounding_capsules import principal_axes, smallest_capsule
from abi.robot.urdf.link import Link, LinkShape

if TYPE_CHECKING:
    import trimesh

_SECTIONS = 32
_MOST = 12
"""Shapes of a link that are pieces of their own, at most; of more all are one."""
_WORTH = 0.9
"""A piece is cut where the hulls of both halves are smaller together than this part of its."""
_SHARES = (0.2, 0.4, 0.6, 0.8)
"""Places of cuts that are tried, over the length of a piece."""
_PAD = 1e-9
"""Rounding of a hull: a part of the largest coordinate, [m]."""
_HEAVY = 1e3
"""Weight of that parts of a point add up to one, beside the place that they are to give."""


Fit = Literal["quick", "finer", "close"]
"""How closely bodies hold a shape."""
_MOST_PARTS: dict[Fit, int] = {"quick": 6, "finer": 12, "close": 24}
"""Pieces of a shape, at most."""
_MUCH: dict[Fit, float] = {"quick": 0.05, "finer": 0.02, "close": 1e-3}
"""A piece is cut where that saves this part of the whole volume, too, ..."""
_LEAST: dict[Fit, float] = {"quick": 0.03, "finer": 0.01, "close": 5e-4}
"""... and a cut must save this part of it."""
_MOST_CORNERS: dict[Fit, int] = {"quick": 64, "finer": 320}
"""Corners of a hull, at most, and in any case those that it needs to have a volume; a close one has
all corners of its piece, and nothing around it."""
_FINE: dict[Fit, float] = {"quick": 0.004, "finer": 0.0005}
"""Distance of a piece's corners from a hull of fewer corners that is let pass, over its least
extent."""


class Body(NamedTuple):
    """A piece of a link: it is in the capsule as well as in the hull, [m].

    It is in the link's frame; where a chain carries it, in that of the joint that moves it, or in
    the world.

    Attributes:
        ends: ends of the capsule's segment, shape (2, 3).
        radius: of the capsule.
        points: corners of the hull, shape (k, 3).
        rounding: distance from the hull that belongs to it, too.
        link: name of the link, as long as no chain carries it empty.
        frame: number of the joint that moves it, -1 where it stands still.
    """

    ends: FloatArray
    radius: float
    points: FloatArray
    rounding: float
    link: str = ""
    frame: int = -1


@lru_cache(maxsize=512)
def link_bodies(link: Link, fit: Fit = "quick") -> tuple[Body, ...]:
    """Bodies whose union contains a link's collision shapes; none for a frame.

    All but spheres take long to make, and are kept from one start to the next.

    Args:
        link: the link.
        fit: how closely: by few pieces with few corners, by more, or by many with all corners.
    """
    if all(shape.kind == "sphere" for shape in link.shapes):
        return _fitted(link, fit)
    key = body_store.key_of(link.shapes, (__file__, bounding_capsules.__file__))
    key += "" if fit == "quick" else f"-{fit}"
    kept = body_store.find(key)
    if kept is not None:
        return tuple(map(_unpacked, kept))
    bodies = _fitted(link, fit)
    body_store.keep(key, [_packed(one) for one in bodies])
    return bodies


def _packed(body: Body) -> FloatArray:
    """A body as numbers (8 + 3 k,)."""
    sizes = [body.radius, body.rounding]
    return np.concatenate([body.ends.ravel(), sizes, body.points.ravel()])


def _unpacked(numbers: FloatArray) -> Body:
    """The body that numbers (8 + 3 k,) say."""
    ends, points = numbers[:6].reshape(2, 3), numbers[8:].reshape(-1, 3)
    return Body(ends, float(numbers[6]), points, float(numbers[7]))


def _fitted(link: Link, fit: Fit) -> tuple[Body, ...]:
    groups = [[shape] for shape in link.shapes]
    if len(groups) > _MOST:
        groups = [list(link.shapes)]
    return tuple(body for group in groups for body in _bodies_of(group, fit))


class OpenWay(NamedTuple):
    """Way of what slides into a link: no triangle of the link is in it, nor beyond one of its ends.

    Attributes:
        sides: planes around it (k, 4), each a unit normal across the direction, and its height
            above the origin, [m].
        direction: of the slide, (3,).
        low, high: where the way begins and ends along it, [m].
    """

    sides: FloatArray
    direction: FloatArray
    low: float
    high: float

    def wider(self, distance: float) -> OpenWay:
        """A way that is wider on all sides, [m]."""
        sides = self.sides + np.array([0.0, 0.0, 0.0, distance])
        return OpenWay(read_only(sides), self.direction, self.low - distance, self.high + distance)

    def parts(self, triangles: FloatArray) -> tuple[list[FloatArray], FloatArray]:
        """Triangles (n, 3, 3) beside each of its planes, and those between all of them."""
        beside = []
        for *normal, height in self.sides.tolist():
            triangles, others = _cut(triangles, triangles @ np.array(normal) - height)
            beside.append(others)
        return beside, triangles

    def is_open(self, triangles: FloatArray) -> bool:
        """Check whether no triangle (n, 3, 3) is in it, nor beyond one of its ends.

        So it leads out, and is outside of all that the triangles enclose.
        """
        along = self.parts(triangles)[1] @ self.direction
        return bool((along < self.low).all() or (along > self.high).all())


def bodies_beside(link: Link, way: OpenWay) -> tuple[Body, ...]:
    """Bodies that contain a link's collision shapes, of which none reaches across a way."""
    key = body_store.key_of(link.shapes, (__file__, bounding_capsules.__file__))
    numbers = np.concatenate([way.sides.ravel(), way.direction, [way.low, way.high]])
    key = f"{key}-{hashlib.sha256(numbers.tobytes()).hexdigest()}"
    kept = body_store.find(key)
    if kept is not None:
        return tuple(map(_unpacked, kept))
    beside, between = way.parts(triangles_of(link))
    before = (between @ way.direction < way.low).all(axis=1)
    groups = [*beside, between[before], between[~before]]
    axes = way.sides[[0, 2], :3]
    parts = [part for one in groups if len(one) for part in _parts(one, "quick", axes)]
    bodies = tuple(_body(part, "close") for part in parts)
    body_store.keep(key, [_packed(one) for one in bodies])
    return bodies


def triangles_of(link: Link) -> FloatArray:
    """Corners (n, 3, 3) in the link's frame of triangles around its collision shapes."""
    return np.concatenate([_triangles(shape) for shape in link.shapes])


def _bodies_of(shapes: list[LinkShape], fit: Fit) -> list[Body]:
    """Bodies around shapes that belong together; a sphere stays the ball that it is."""
    if len(shapes) == 1 and shapes[0].kind == "sphere":
        centre, radius = read_only(shapes[0].pose[None, :3, 3]), shapes[0].size[0] * (1 + _PAD)
        return [Body(centre[[0, 0]], radius + 1e-12, centre, radius)]
    triangles = np.concatenate([_triangles(shape) for shape in shapes])
    return [_body(part, fit) for part in _parts(triangles, fit)]


def _body(points: FloatArray, fit: Fit) -> Body:
    """The body around points (n, 3)."""
    corners, rounding = _corners_of(points, fit)
    pad = _PAD * (1e-3 + float(np.abs(corners).max()))
    return Body(*smallest_capsule(points), read_only(corners), rounding + pad)


def _corners_of(points: FloatArray, fit: Fit) -> tuple[FloatArray, float]:
    """Corners (k, 3) of points' hull, and the farthest that one of the points is from their hull.

    Those corners are taken, one by one, that are farthest outside of the hull of those before; all
    where they are in a plane, or where the fit is to be exact.
    """
    try:
        corners = points[scipy.spatial.ConvexHull(points).vertices]
        if fit == "close":
            return corners, 0.0
        fine = _FINE[fit] * float(np.ptp(corners @ principal_axes(corners).T, axis=0).min())
        chosen = {int(np.argmax(corners @ way)) for way in _WAYS}
        while True:
            sides = scipy.spatial.ConvexHull(corners[sorted(chosen)]).equations
            outside = (corners @ sides[:, :3].T + sides[:, 3]).max(axis=1)
            farthest = int(outside.argmax())
            if outside[farthest] <= fine or len(chosen) >= _MOST_CORNERS[fit] or farthest in chosen:
                break
            chosen.add(farthest)
    except scipy.spatial.QhullError:
        return np.unique(points, axis=0), 0.0
    own = corners[sorted(chosen)]
    return own, max((_distance(own, one) for one in corners[outside > 0]), default=0.0)


def _distance(corners: FloatArray, point: FloatArray) -> float:
    """Upper bound of the distance of a point (3,) from the hull of corners (k, 3)."""
    size = float(np.abs(corners - point).max())
    sums = np.vstack([(corners - point).T / size, np.full(len(corners), _HEAVY)])
    parts, _ = scipy.optimize.nnls(sums, np.array([0.0, 0.0, 0.0, _HEAVY]))
    return float(np.linalg.norm(parts @ corners / parts.sum() - point))


_WAYS = np.array([way for way in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(way)])
"""Directions in which a hull's first corners are sought."""


def _parts(triangles: FloatArray, fit: Fit, axes: FloatArray | None = None) -> list[FloatArray]:
    """Points (n, 3) of each part of triangles, as few parts as are worth it.

    All cuts are across two ``axes`` (2, 3), the two longest if none are given. Where two planes
    meet inside the solid, their line leaves it through a triangle, so that the parts' hulls hold
    what is inside, too.
    """
    whole = _volume(triangles.reshape(-1, 3))
    if _filled(triangles) > (1 - _MUCH[fit]) * whole:
        return [triangles.reshape(-1, 3)]
    parts = [(triangles, whole)]
    axes = principal_axes(triangles.reshape(-1, 3))[:2] if axes is None else axes
    halves = [_halves(parts[0], axes)]
    while len(parts) < _MOST_PARTS[fit]:
        gains = [
            volume - sum(of_half for _, of_half in both)
            for (_, volume), both in zip(parts, halves, strict=True)
        ]
        best = int(np.argmax(gains))
        enough = min((1 - _WORTH) * parts[best][1], _MUCH[fit] * whole)
        if gains[best] <= max(enough, _LEAST[fit] * whole):
            break
        both = halves[best]
        parts[best : best + 1] = both
        halves[best : best + 1] = [_halves(half, axes) for half in both]
    return [part.reshape(-1, 3) for part, _ in parts]


def _halves(part: tuple[FloatArray, float], axes: FloatArray) -> list[tuple[FloatArray, float]]:
    """Both halves of a part at the plane that makes their hulls smallest; itself without one.

    A part is triangles (n, 3, 3), and the volume of their hull, [m³].
    """
    best, triangles = [part], part[0]
    for axis in axes:
        heights = triangles @ axis
        low, high = float(heights.min()), float(heights.max())
        for share in _SHARES:
            both = [
                (half, _volume(half.reshape(-1, 3)))
                for half in _cut(triangles, heights - (low + share * (high - low)))
                if len(half)
            ]
            if sum(volume for _, volume in both) < sum(volume for _, volume in best):
                best = both
    return best


def _cut(triangles: FloatArray, heights: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Triangles (n, 3, 3) below and above a plane, given their corners' heights above it (n, 3)."""
    below, above = (heights <= 0).all(axis=1), (heights >= 0).all(axis=1)
    crossed = ~(below | above)
    rows = np.arange(np.count_nonzero(crossed))
    corners, high = triangles[crossed], heights[crossed]
    one_above = (high > 0).sum(axis=1) == 1
    # the corner that is alone on its side, and the two others
    alone = np.where(one_above, (high > 0).argmax(axis=1), (high <= 0).argmax(axis=1))
    (a, b, c), (d, e, f) = (
        [one[rows, (alone + k) % 3] for k in range(3)] for one in (corners, high)
    )
    p, q = a + (d / (d - e))[:, None] * (b - a), a + (d / (d - f))[:, None] * (c - a)
    tip = np.stack([a, p, q], axis=1)
    rest = np.concatenate([np.stack([p, b, c], axis=1), np.stack([p, c, q], axis=1)])
    twice = np.concatenate([one_above, one_above])
    return (
        np.concatenate([triangles[below], tip[~one_above], rest[twice]]),
        np.concatenate([triangles[above & ~below], tip[one_above], rest[~twice]]),
    )


def _filled(triangles: FloatArray) -> float:
    """Volume that triangles (n, 3, 3) wind around, [m³]: of a closed surface that inside."""
    middle = triangles.mean(axis=(0, 1))
    a, b, c = (triangles[:, k] - middle for k in range(3))
    return abs(float(np.einsum("ij,ij->", a, np.cross(b, c)))) / 6


def _volume(points: FloatArray) -> float:
    """Volume of the hull of points, 0 where they are in a plane, [m³]."""
    try:
        return float(scipy.spatial.ConvexHull(points).volume)
    except scipy.spatial.QhullError:
        return 0.0


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
        # scaled afterwards, as small triangles would be left out
        solid = trimesh.creation.cylinder(radius=1.0, height=1.0, sections=_SECTIONS)
        solid.vertices *= (around, around, length)
    return solid
