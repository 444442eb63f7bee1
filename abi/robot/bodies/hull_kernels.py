"""Distance between convex hulls of points: the algorithm of Gilbert, Johnson and Keerthi (1988).

A body is the convex hull of points in the frame of a joint, and what is within its rounding of it.
Of the set of all differences between points of two convex bodies the point nearest to the origin is
sought by simplices of up to four of its points; where it is, its direction separates the bodies.

Plain Python that numba compiles with its caller.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, TypeVar

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, IDS, NEW_FLOATS, compiled
from abi.obstacles.vector_kernels import Vec3, axpy, cross, dot, sub, vec3_at
from abi.robot.bodies.capsule_table import BODIES, Bodies
from abi.robot.kinematics.chain_kernels import POSE

APART, OVERLAP, OPEN = 1, 2, 3
"""Outcomes: a direction separates by more than asked, two points are nearer than that, or
neither."""

_STEPS = 40
_CONVERGED = 1e-10
"""Part of a distance by which its bounds from below and above may differ in the end."""
_NONE: Vec3 = (0.0, 0.0, 0.0)

_Pair = TypeVar("_Pair")


class _Simplex(NamedTuple):
    """Up to four points, of which the first ``used`` are of use."""

    used: int
    a: Vec3
    b: Vec3
    c: Vec3
    d: Vec3


@jitable
def lowest_point(bodies: Bodies, poses: FloatArray, c: int, way: Vec3) -> Vec3:
    """Point of the hull of body c that is lowest along a direction, [unit], world.

    Args:
        bodies: the bodies.
        poses: of the joints, flat (12 (m + 1),), [m].
        c: number of the body.
        way: the direction.
    """
    frame, x, y, z = bodies.frames[c], way[0], way[1], way[2]
    at = POSE * frame
    if frame >= 0:
        x = poses[at] * way[0] + poses[at + 3] * way[1] + poses[at + 6] * way[2]
        y = poses[at + 1] * way[0] + poses[at + 4] * way[1] + poses[at + 7] * way[2]
        z = poses[at + 2] * way[0] + poses[at + 5] * way[1] + poses[at + 8] * way[2]
    best, lowest, points = 0, math.inf, bodies.points
    for k in range(3 * bodies.first[c], 3 * bodies.first[c + 1], 3):
        height = x * points[k] + y * points[k + 1] + z * points[k + 2]
        if height < lowest:
            best, lowest = k, height
    return placed_corner(bodies, poses, c, best)


@jitable
def placed_corner(bodies: Bodies, poses: FloatArray, c: int, corner: int) -> Vec3:
    """A corner of the hull of body c, [unit], world; three times its number is ``corner``."""
    at, p, scale = POSE * bodies.frames[c], vec3_at(bodies.points, corner), bodies.scale
    if at < 0:
        return scale * p[0], scale * p[1], scale * p[2]
    return (
        scale * (poses[at] * p[0] + poses[at + 1] * p[1] + poses[at + 2] * p[2] + poses[at + 9]),
        scale
        * (poses[at + 3] * p[0] + poses[at + 4] * p[1] + poses[at + 5] * p[2] + poses[at + 10]),
        scale
        * (poses[at + 6] * p[0] + poses[at + 7] * p[1] + poses[at + 8] * p[2] + poses[at + 11]),
    )


@jitable
def _on_segment(a: Vec3, b: Vec3) -> tuple[Vec3, _Simplex]:
    """Point of a segment nearest to the origin, and the ends that it needs."""
    d = sub(b, a)
    square = dot(d, d)
    t = -dot(a, d) / square if square > 0 else 0.0
    if t <= 0:
        return a, _Simplex(1, a, _NONE, _NONE, _NONE)
    if t >= 1:
        return b, _Simplex(1, b, _NONE, _NONE, _NONE)
    return axpy(t, d, a), _Simplex(2, a, b, _NONE, _NONE)


@jitable
def _on_triangle(a: Vec3, b: Vec3, c: Vec3) -> tuple[Vec3, _Simplex]:
    """Point of a triangle nearest to the origin, and the corners that it needs."""
    normal = cross(sub(b, a), sub(c, a))
    square = dot(normal, normal)
    inside = square > 0
    if inside:
        u, v, w = dot(normal, cross(a, b)), dot(normal, cross(b, c)), dot(normal, cross(c, a))
        inside = u >= 0 and v >= 0 and w >= 0
    if inside:
        t = dot(normal, a) / square
        point = (t * normal[0], t * normal[1], t * normal[2])
        return point, _Simplex(3, a, b, c, _NONE)
    point, best = _on_segment(a, b)
    other, simplex = _on_segment(b, c)
    if dot(other, other) < dot(point, point):
        point, best = other, simplex
    other, simplex = _on_segment(c, a)
    if dot(other, other) < dot(point, point):
        point, best = other, simplex
    return point, best


@jitable
def _is_outside(a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> bool:
    """Check whether the origin is not on the side of d of the plane through a, b and c."""
    normal = cross(sub(b, a), sub(c, a))
    outside: bool = dot(normal, sub(d, a)) * -dot(normal, a) <= 0
    return outside


@jitable
def _nearest(simplex: _Simplex) -> tuple[Vec3, _Simplex]:
    """Point of a simplex nearest to the origin, and the corners that it needs."""
    count, a, b, c, d = simplex
    if count == 1:
        return a, simplex
    if count == 2:
        return _on_segment(a, b)
    if count == 3:
        return _on_triangle(a, b, c)
    point, best, found = _NONE, simplex, False
    if _is_outside(a, b, c, d):
        point, best = _on_triangle(a, b, c)
        found = True
    if _is_outside(a, c, d, b):
        other, face = _on_triangle(a, c, d)
        if not found or dot(other, other) < dot(point, point):
            point, best = other, face
        found = True
    if _is_outside(a, d, b, c):
        other, face = _on_triangle(a, d, b)
        if not found or dot(other, other) < dot(point, point):
            point, best = other, face
        found = True
    if _is_outside(b, d, c, a):
        other, face = _on_triangle(b, d, c)
        if not found or dot(other, other) < dot(point, point):
            point, best = other, face
    return point, best


@jitable
def separation(
    difference: Callable[[_Pair, Vec3], Vec3],
    pair: _Pair,
    way: Vec3,
    near: float,
    far: float,
    exact: bool,
) -> tuple[int, float, Vec3]:
    """Check if two convex bodies are separated by more than ``far``.

    Args:
        difference: the lowest point of the first along a direction less the highest of the second.
        pair: both bodies.
        way: a direction to begin with, of length 1: one that separates them ends the search.
        near: distance below which the search ends, [unit].
        far: distance asked for, at least ``near``, [unit].
        exact: whether a distance between the two is wanted, not only that it is between them.

    Returns:
        ``APART`` with a distance that the direction proves; ``OVERLAP`` with one below ``near``, 0
        where they overlap; else ``OPEN`` with the distance, or one above it unless that is to be
        exact; and the direction from the second.
    """
    point = difference(pair, way)
    gap = dot(way, point)
    if gap > far:
        return APART, gap, way
    simplex = _Simplex(1, point, _NONE, _NONE, _NONE)
    largest, size = 0.0, 0.0
    for _ in range(_STEPS):
        size = math.sqrt(dot(point, point))
        largest = max(largest, size)
        if size < near or size <= _CONVERGED * largest:
            return OVERLAP, size, way
        way = (point[0] / size, point[1] / size, point[2] / size)
        added = difference(pair, way)
        gap = dot(way, added)
        if gap > far:
            return APART, gap, way
        if size - gap <= _CONVERGED * size or (not exact and near <= gap and size <= far):
            return OPEN, size, way
        largest = max(largest, math.sqrt(dot(added, added)))
        count, a, b, c, _ = simplex
        if count == 1:
            simplex = _Simplex(2, a, added, _NONE, _NONE)
        elif count == 2:
            simplex = _Simplex(3, a, b, added, _NONE)
        else:
            simplex = _Simplex(4, a, b, c, added)
        point, simplex = _nearest(simplex)
        if simplex.used == 4:
            return OVERLAP, 0.0, way
    return OPEN, size, way


@jitable
def _between_hulls(pair: tuple[Bodies, FloatArray, int, int], way: Vec3) -> Vec3:
    """Lowest point of the second hull less the highest of the first."""
    bodies, poses, i, j = pair
    down = (-way[0], -way[1], -way[2])
    return sub(lowest_point(bodies, poses, j, way), lowest_point(bodies, poses, i, down))


@jitable
def between_hulls(
    bodies: Bodies,
    poses: FloatArray,
    pair: int,
    way: Vec3,
    near: float,
    far: float,
    exact: bool,
) -> tuple[int, float, Vec3]:
    """Separate the hulls, without their roundings, of a pair that is to keep apart."""
    i, j = int(bodies.pairs[2 * pair]), int(bodies.pairs[2 * pair + 1])
    return separation(_between_hulls, (bodies, poses, i, j), way, near, far, exact)


@compiled(example=(BODIES, FLOATS, IDS, 0.0, 1, NEW_FLOATS))
def hull_distances(
    bodies: Bodies,
    poses: FloatArray,
    asked: IntArray,
    enough: float,
    together: int,
    distances: FloatArray,
) -> None:
    """Distances between bodies of pairs that are to keep apart, 0 where they overlap.

    Args:
        bodies: the bodies.
        poses: of the joints at each of n poses, flat (12 (m + 1) n,).
        asked: number of a pose and of a pair, flat (2 k,), those of a pose together.
        enough: distances above it may be any from there on, [unit].
        together: number of successive poses of which only the least distance counts, 0 if all do.
        distances: (k,), [unit]; written.
    """
    size = POSE * (bodies.moving + 1)
    ways = np.zeros(3 * (len(bodies.pairs) // 2))
    ways[2::3] = 1.0
    least, group = enough, -1
    for k in range(len(distances)):
        if together > 0 and asked[2 * k] // together != group:
            least, group = enough, asked[2 * k] // together
        at, pair = asked[2 * k] * size, asked[2 * k + 1]
        last = vec3_at(ways, 3 * pair)  # what separated the pair may do so at the next pose, too
        own = (
            bodies.roundings[bodies.pairs[2 * pair]] + bodies.roundings[bodies.pairs[2 * pair + 1]]
        )
        _, away, way = between_hulls(
            bodies, poses[at : at + size], pair, last, 0.0, own + least, True
        )
        ways[3 * pair], ways[3 * pair + 1], ways[3 * pair + 2] = way
        distances[k] = max(away - own, 0.0)
        if together > 0:
            least = min(least, distances[k])
