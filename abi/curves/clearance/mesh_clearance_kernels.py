"""Distances of a curve's samples to triangle meshes, and the bounds that follow for its pieces.

A mesh need not be convex, so a bound rests on balls alone. Around a sample at the distance d > 0
nothing is nearer than d. Let a and b be the ends of a piece, at distances of at least d and e, and
let l be their distance.

If l < d + e, the balls around a and b cover the chord, and the distance of a point x of it is at
least that of x to the edge of both balls' union. From any x between a and b the nearest point of
the edge is where the spheres meet: a circle around the chord's line, at h = (l² + d² - e²) / 2l
from a, with the radius r = √(d² - h²). (On the sphere around a, outside the ball around b, the
points farthest along the chord are nearest to x, and these are on the circle; the same from b.) So
x at t from a has a distance of at least √((t - h)² + r²): never below r, and never below the lesser
of d and e where h is not in [0, l]. Otherwise, and for signed distances below 0, it is at least
max(d - t, e - (l - t)) >= (d + e - l) / 2, because the distance is 1-Lipschitz.

The piece is in the convex hull of its control points, and the distance to the chord is convex: no
point of the piece is farther from the chord than a control point. That much is subtracted. The
error of such a bound falls with the square of the piece's length.

A point is three successive numbers. Plain Python that numba compiles with its caller.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from abi.compilation.jitable import jitable
from abi.curves.clearance.separation_kernels import divide
from abi.obstacles.triangle_mesh.surface_kernels import (
    SurfaceSet,
    most_to_mesh,
    nearest_mesh,
    widened,
)
from abi.obstacles.triangle_mesh.surface_tables_kernels import DescentWorkspace
from abi.obstacles.triangle_mesh.triangle_kernels import on_side
from abi.obstacles.vector_kernels import Vec3, axpy, distance, norm, sub, vec3_at


class Sample(NamedTuple):
    """A point of the curve and its distances.

    Attributes:
        at: parameter.
        distance: signed distance to the nearest obstacle, [unit]; inf before any is known.
        obstacle: its row, those of meshes after those of primitives; -1 before any is known.
        to_meshes: lower bound of the distance to the meshes alone, [unit].
    """

    at: float
    distance: float
    obstacle: int
    to_meshes: float


class Pieces(NamedTuple):
    """Bézier pieces of the curve, n in number, along it.

    Attributes:
        points: their points, flat (3 n (degree + 1),), [unit], world.
        firsts: samples at their first points (n,).
        lasts: samples at their last points (n,).
    """

    points: list[float]
    firsts: list[Sample]
    lasts: list[Sample]


@jitable
def joint_at(points: list[float], joint: int, pieces: int) -> Vec3:
    """First point of a piece of a curve; of the number after the last, where the curve ends."""
    size = len(points) // pieces
    return vec3_at(points, len(points) - 3 if joint == pieces else joint * size)


@jitable
def _chord(points: list[float], start: int, size: int) -> tuple[float, float]:
    """Length of the chord of a piece, and how far a control point of it is from it at most."""
    a = vec3_at(points, start)
    along = sub(vec3_at(points, start + size - 3), a)
    off = 0.0
    for i in range(start + 3, start + size - 3, 3):
        p = vec3_at(points, i)
        off = max(off, distance(p, axpy(on_side(p, a, along), along, a)))
    return norm(along), off


@jitable
def _least_between(d: float, e: float, chord: tuple[float, float]) -> float:
    """Lower bound of the signed distance of a piece, from such bounds at its ends.

    Args:
        d, e: at the first and at the last point, [unit].
        chord: see :func:`_chord`.
    """
    length, off = chord
    if d <= 0.0 or e <= 0.0 or length >= d + e:
        return (d + e - length) / 2 - off
    if abs(d - e) * (d + e) >= length * length:
        return min(d, e) - off
    h = (length + (d - e) * (d + e) / length) / 2
    return math.sqrt(max((d - h) * (d + h), 0.0)) - off


@jitable
def _sought(enough: float, chord: tuple[float, float]) -> float:
    """Distance at both ends of a piece with which none of its points is nearer than ``enough``."""
    length, off = chord
    return math.sqrt(max(enough, 0.0) ** 2 + length * length / 4) + off


@jitable
def joints_near_meshes(
    surfaces: SurfaceSet,
    first_row: int,
    points: list[float],
    joints: list[Sample],
    nearest: Sample,
    required: float,
    room: DescentWorkspace,
) -> Sample:
    """Lower the distances between pieces that are one curve, and at its ends, to the meshes'.

    Args:
        surfaces: the meshes.
        first_row: that of the first of them.
        points: of the n pieces, flat (3 n (degree + 1),), [unit], world.
        joints: the samples there (n + 1,); written.
        nearest: the nearest sample so far.
        required: what is farther than that and the nearest sample may be left out, [unit].
        room: for descents.

    Returns:
        The nearest sample of all.
    """
    count = len(joints) - 1
    size = len(points) // count
    most = nearest.distance
    for joint in range(count + 1):
        most = most_to_mesh(surfaces, most, joint_at(points, joint, count))
    enough = widened(max(most, required))
    before = 0.0
    for joint in range(count + 1):
        after = _sought(enough, _chord(points, joint * size, size)) if joint < count else 0.0
        x = joint_at(points, joint, count)
        away, mesh, _, bound = nearest_mesh(surfaces, enough, max(before, after), x, room)
        before = after
        at, distance, obstacle, _ = joints[joint]
        if away < distance:
            distance, obstacle = away, first_row + mesh
        joints[joint] = Sample(at, distance, obstacle, bound)
        if away < nearest.distance:
            nearest = joints[joint]
    return nearest


@jitable
def middles_near_meshes(
    surfaces: SurfaceSet,
    first_row: int,
    pieces: Pieces,
    middles: list[Sample],
    bounds: list[float],
    nearest: Sample,
    demand: tuple[float, float, float],
    room: DescentWorkspace,
) -> Sample:
    """Lower the distances at the middles of pieces, and their bounds, to those to the meshes.

    A middle is left out where the ends of the piece, neither of which is too near or the nearest so
    far, bound it well enough.

    Args:
        surfaces, first_row, nearest, room: see :func:`joints_near_meshes`.
        pieces: n in number.
        middles: the samples there (n,); written.
        bounds: of the distances along the pieces from below (n,), [unit]; written.
        demand: see ``measure_curve``.

    Returns:
        The nearest sample of all.
    """
    points, firsts, lasts = pieces
    required, tolerance, _ = demand
    size = len(points) // len(middles)
    halves = [0.0] * (2 * size)
    before = nearest.distance
    for piece in range(len(middles)):
        first, last = firsts[piece], lasts[piece]
        at, distance, obstacle, _ = middles[piece]
        enough = widened(max(nearest.distance, required))
        bound = _least_between(first.to_meshes, last.to_meshes, _chord(points, piece * size, size))
        middle, near = bound, min(first.distance, last.distance)
        if near < required or near <= before or bound < enough - tolerance:
            divide(points, piece * size, halves, 0, size, size // 3, 0.5)
            left, right = _chord(halves, 0, size), _chord(halves, size, size)
            sought = max(_sought(enough, left), _sought(enough, right))
            x = vec3_at(halves, size)
            away, mesh, _, middle = nearest_mesh(surfaces, enough, sought, x, room)
            if away < distance:
                distance, obstacle = away, first_row + mesh
            halved = min(
                _least_between(first.to_meshes, middle, left),
                _least_between(middle, last.to_meshes, right),
            )
            bound = max(bound, halved)
        bounds[piece] = min(bounds[piece], bound)
        middles[piece] = Sample(at, distance, obstacle, middle)
        if distance < nearest.distance:
            nearest = middles[piece]
    return nearest
