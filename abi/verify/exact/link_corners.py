"""Check that a certificate's capsules contain the corners of a robot's links, and points of them.

So none stands where its joints do not take it, and none leaves a part of a link out. Triangles and
boxes whose corners are all in one piece, which is convex, are in it. Other triangles are cut until
they are, or small. On what is in several pieces then, points are spread at random, others each
time, and, but for meshes, inside. They are compared in floating point: what is off by less than a
millionth passes.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence

import numpy as np
import scipy

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.robot.urdf.link import LinkShape
from abi.robot.urdf.robot import Robot
from abi.verify.exact.chain import ExactChain
from abi.verify.exact.shape_triangles import shape_triangles
from abi.verify.exact.solids import LinkPiece, MovedHull
from abi.verify.fault import Fault

_NEAR = 1e-6
"""Distance by which a corner may be outside, over the largest coordinate of its link and 1 m."""
_TINY = 1e-300
_HEAVY = 1e4
"""Weight of a mean's parts having the sum 1, beside its place."""
_THIN = 1e-7
"""Depth of a hull's middle, over its largest coordinate, below which it counts as flat."""
_FAR = 1e9
"""Largest coordinate of a piece, over the accepted distance: rounding is far less then."""
_AT_ONCE = 100_000
"""Pairs of a point and a facet that are compared at a time, some 50 MB."""
_POINTS = 600
"""Number of random points of each shape."""
_FINEST, _CUTS = 2.0**-7, (4000, 8)
"""Sides of triangles that are not cut, over the size of their shape; cuts in all, or for each."""
_Hull = tuple[FloatArray, float, scipy.spatial.ConvexHull | None]
"""Points (n, 3), the distance from their hull that belongs to it, and its facets; None if flat."""


def check_corners(
    robot: Robot, chain: ExactChain, bodies: Mapping[str, Sequence[LinkPiece]]
) -> None:
    """Raise if a point of a link's shapes is in none of its pieces.

    Args:
        robot: the robot.
        chain: its chain.
        bodies: pieces of each link.

    Raises:
        Fault: one is outside.
    """
    units, random = float(chain.units), np.random.default_rng()
    for name, link in robot.links.items():
        if not link.shapes:
            continue
        pose = chain.places[name].astype(np.float64)
        turn, origin = pose[:3, :3], pose[:3, 3]
        parts, triangles = zip(*map(_corners, link.shapes), strict=True)
        corners = units * np.concatenate(parts) @ turn.T + origin
        allowed = _NEAR * max(units, float(np.abs(corners).max()))
        pieces = [[_facets(hull, allowed) for hull in one] for one in bodies[name]]
        held = _holding(corners, pieces)
        ends = np.cumsum([len(one) for one in parts])[:-1]
        more = []
        for shape, faces, own, inside in zip(
            link.shapes, triangles, np.split(corners, ends), np.split(held, ends), strict=True
        ):
            more.append(_parted(own[faces], inside[faces], pieces, random))
            if shape.kind != "mesh" and (shape.kind != "box" or not inside.all(axis=0).any()):
                more.append(units * _spread(shape, random) @ turn.T + origin)
        points = _holding(np.concatenate(more), pieces)
        if not (held.any(axis=1).all() and points.any(axis=1).all()):
            raise Fault(f"the capsules of {name} are not where its joints take it")


def check_lines(chain: ExactChain, robot: Robot, bodies: Mapping[str, Sequence[LinkPiece]]) -> None:
    """Raise if nothing stands for a robot of whose own links none that moves has a shape.

    Lines do, from joint to joint and to the tip.

    Args:
        chain: the robot's chain.
        robot: the robot.
        bodies: pieces of each link.

    Raises:
        Fault: no piece holds both ends of such a line, and with them all of it.
    """
    if has_own_shape(chain, robot):
        return
    moving = (joint for joint in robot.joints if joint.kind != "fixed")
    between = {link for joint in moving for link in (joint.parent, joint.child)}
    for frame, pose in zip(chain.before, chain.origins, strict=True):
        if frame >= 0:
            ends = np.array([[0.0] * 3, [*map(float, pose[:3, 3])]])
            # what is fixed to these may be allowed to touch, as a held object is
            links = (link for link in between if chain.frames.get(link) == frame)
            pieces = [one for link in links for one in bodies.get(link, ())]
            allowed = _NEAR * max(float(chain.units), float(np.abs(ends).max()))
            whole = [[_facets(hull, allowed) for hull in one] for one in pieces]
            if not _holding(ends, whole).all(axis=0).any():
                raise Fault("no lines stand for its links, which have no shapes")


def has_own_shape(chain: ExactChain, robot: Robot) -> bool:
    """Check whether a link that moves has a shape, other than the object that the robot holds."""
    moving = (name for name, frame in chain.frames.items() if frame >= 0 and name != robot.attached)
    return any(robot.links[name].shapes for name in moving)


def _holding(points: FloatArray, pieces: Sequence[Sequence[_Hull]]) -> BoolArray:
    """Check which of points (n, 3) are in all hulls of each of p pieces, (n, p)."""
    held = np.ones((len(points), len(pieces)), dtype=np.bool_)
    for inside, one in zip(held.T, pieces, strict=True):
        for hull in one:
            corners, room, _ = hull
            low, high = corners.min(axis=0) - room, corners.max(axis=0) + room
            inside &= ((points >= low) & (points <= high)).all(axis=1)
            inside[inside] = _in_hull(points[inside], hull)
    return held


def _in_hull(corners: FloatArray, hull: _Hull) -> BoolArray:
    """Check which of points (n, 3) are in a hull."""
    points, room, whole = hull
    if len(points) <= 2:
        return np.asarray(_distances(corners, points[0], points[-1] - points[0]) <= room)
    if whole is None:  # how far is each from a mean of the points?
        return np.array([_from_means(corner, points) <= room for corner in corners], dtype=np.bool_)
    planes = corners @ whole.equations[:, :3].T + whole.equations[:, 3]
    away = planes.max(axis=1, initial=-1.0)
    inside = away <= 0
    # beyond its edges what is near all planes may be far from it; nearest are facets that it sees
    near = np.flatnonzero(~inside & (away <= room))
    seen_by, facets = np.nonzero(planes[near] > 0)
    for first in range(0, len(facets), _AT_ONCE):
        some = slice(first, first + _AT_ONCE)
        beside, triangles = near[seen_by[some]], points[whole.simplices[facets[some]]]
        inside[beside[_from_triangles(corners[beside], triangles) <= room]] = True
    return np.asarray(inside)


def _facets(hull: MovedHull, allowed: float) -> _Hull:
    """A hull in floating point, a distance wider; empty if so far away that rounding decides."""
    points, room = np.array(hull.points, dtype=np.float64), float(hull.radius) + allowed
    far, whole = float(np.abs(points).max()), None
    if far > _FAR * allowed:
        return points[[0, 0]], -1.0, None
    if len(points) > 2:
        with contextlib.suppress(scipy.spatial.QhullError):
            whole = scipy.spatial.ConvexHull(points)
            middle = points[whole.vertices].mean(axis=0)
            depth = -float((whole.equations[:, :3] @ middle + whole.equations[:, 3]).max())
            if depth <= _THIN * far:
                whole = None
    return points, room, whole


def _from_means(corner: FloatArray, points: FloatArray) -> float:
    """Distance of a corner (3,) from the hull of points (n, 3)."""
    size = max(float(np.abs(points).max()), _TINY)
    sums = np.vstack([points.T / size, np.full(len(points), _HEAVY)])
    weights = scipy.optimize.nnls(sums, np.append(corner / size, _HEAVY))[0]
    return float(np.linalg.norm(weights @ points / max(weights.sum(), _TINY) - corner))


def _from_triangles(points: FloatArray, corners: FloatArray) -> FloatArray:
    """Distances (n,) of points (n, 3) from a triangle each (n, 3, 3)."""
    ways = np.roll(corners, -1, axis=1) - corners
    normals = np.cross(ways[:, 0], ways[:, 1])
    sideways = np.cross(normals[:, None], ways)
    above = (np.einsum("nki,nki->nk", points[:, None] - corners, sideways) >= 0).all(axis=1)
    lengths = np.linalg.norm(normals, axis=1)
    heights = np.abs(np.einsum("ni,ni->n", points - corners[:, 0], normals))
    heights /= np.maximum(lengths, _TINY)
    around = _distances(points[:, None], corners, ways).min(axis=1)
    return np.asarray(np.where(above & normals.any(axis=1), heights, around))


def _distances(points: FloatArray, first: FloatArray, ways: FloatArray) -> FloatArray:
    """Distances (...) of points (..., 3) from segments, each from its first point on its way."""
    squares = np.einsum("...i,...i->...", ways, ways)
    along = np.einsum("...i,...i->...", points - first, ways)
    shares = np.clip(along / np.where(squares > 0, squares, 1.0), 0, 1)
    return np.asarray(np.linalg.norm(points - first - shares[..., None] * ways, axis=-1))


def _corners(shape: LinkShape) -> tuple[FloatArray, IntArray]:
    """Points (n, 3) of a shape that are farthest out, in its link's frame, [m], and its triangles.

    These are numbers of such points, (m, 3); a ball has none.
    """
    if shape.kind == "sphere":
        ends = shape.size[0] * np.concatenate([np.eye(3), -np.eye(3)])
        return _in_link(ends, shape), np.zeros((0, 3), dtype=np.int32)
    if shape.kind == "mesh":
        used, faces = np.unique(shape.faces, return_inverse=True)  # files have others
        points = shape.vertices[used]
    else:
        rows = shape_triangles(shape).reshape(-1, 3)
        points, faces = np.unique(rows, axis=0, return_inverse=True)
    return _in_link(points, shape), faces.reshape(-1, 3).astype(np.int32)


def _parted(
    triangles: FloatArray,
    inside: BoolArray,
    pieces: Sequence[Sequence[_Hull]],
    random: np.random.Generator,
) -> FloatArray:
    """Random points (n, 3) of what of triangles no piece holds by itself.

    Triangles are cut across their longest side, long ones first. Points of a cut that are in no
    piece are all there is.

    Args:
        triangles: corners, (k, 3, 3).
        inside: which corner is in which of p pieces, (k, 3, p).
        pieces: the pieces.
        random: where points are.
    """
    size = np.ptp(triangles.reshape(-1, 3), axis=0).max() if len(triangles) else 0.0
    finest, left = _FINEST * float(size), max(_CUTS[0], _CUTS[1] * len(triangles))
    while True:
        parted = ~np.any(np.all(inside, axis=1), axis=1)
        triangles, inside = triangles[parted], inside[parted]
        sides = np.linalg.norm(triangles - np.roll(triangles, -1, axis=1), axis=2)
        long = sides.max(axis=1) > max(finest, sides.max(initial=0.0) / 2)
        left -= int(long.sum())
        if not long.any() or left < 0:
            break
        order = (sides[long].argmax(axis=1)[:, None] + np.arange(3)) % 3
        rows = np.flatnonzero(long)[:, None]
        (a, b, c), known = triangles[rows, order].swapaxes(0, 1), inside[rows, order]
        middles = a + random.uniform(0.3, 0.7, (len(a), 1)) * (b - a)
        held = _holding(middles, pieces)
        if not held.any(axis=1).all():
            return np.asarray(middles)
        halves = np.stack([a, middles, c], axis=1), np.stack([middles, b, c], axis=1)
        first, second = known.copy(), known.copy()
        first[:, 1] = second[:, 0] = held
        triangles = np.concatenate([triangles[~long], *halves])
        inside = np.concatenate([inside[~long], first, second])
    areas = np.linalg.norm(np.cross(*np.diff(triangles, axis=1).swapaxes(0, 1)), axis=1)
    if not areas.sum() > 0:
        return np.zeros((0, 3))
    more = random.choice(len(areas), _POINTS, p=areas / areas.sum())
    chosen = np.concatenate([np.arange(len(areas)), more])
    weights = random.dirichlet(np.ones(3), len(chosen))
    return np.asarray(np.einsum("nc,nci->ni", weights, triangles[chosen]))


def _spread(shape: LinkShape, random: np.random.Generator) -> FloatArray:
    """Random points (n, 3) of a solid in its link's frame, [m], half of them on its surface."""
    a, b, c = shape.size
    points = random.uniform(-1.0, 1.0, (_POINTS, 3))
    across, along = np.hypot(points[:, 0], points[:, 1]), np.abs(points[:, 2])
    # of how large a solid of that kind, whose half sizes are 1, each point is on the surface
    if shape.kind == "box":
        extent, half = np.abs(points).max(axis=1), np.array([a, b, c]) / 2
    elif shape.kind == "sphere":
        extent, half = np.hypot(across, along), np.array([a, a, a])
    else:
        extent, half = np.maximum(across, along), np.array([a, a, b / 2])
    depth = np.where(np.arange(_POINTS) % 2, 1.0, np.cbrt(random.uniform(size=_POINTS)))
    return _in_link(points * (depth / extent)[:, None] * half, shape)


def _in_link(points: FloatArray, shape: LinkShape) -> FloatArray:
    """Points (n, 3) of a shape's frame in that of its link."""
    return np.asarray(points @ shape.pose[:3, :3].T + shape.pose[:3, 3])
