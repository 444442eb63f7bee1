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

from numba.extending import register_jitable

from abi.clearance.bezier_kernels import divide
from abi.obstacles.surface_set import SurfaceSet
from abi.obstacles.surface_set_kernels import most_to_mesh, nearest_mesh, widened
from abi.obstacles.triangle_mesh.surface_tables_kernels import Room
from abi.obstacles.triangle_mesh.triangle_kernels import on_side
from abi.obstacles.vector_kernels import Vec3, axpy, distance, norm, sub, vec3_at

Sample = tuple[float, int, int]
"""Signed distance, [unit], number of the sample, and the mesh; inf, 0 and -1 without one."""

Ends = tuple[list[float], list[float], list[float], list[float]]
"""Distances at the first points of n pieces, and at their last, and lower bounds of those to the
meshes alone, (n,) each, [unit]."""


@register_jitable
def _end(points: list[float], end: int, pieces: int) -> Vec3:
    """First point of a piece of a curve; of the number after the last, where the curve ends."""
    size = len(points) // pieces
    return vec3_at(points, 3 * (len(points) // 3 - 1) if end == pieces else end * size)


@register_jitable
def _chord(points: list[float], start: int, size: int) -> tuple[float, float]:
    """Length of the chord of a piece, and how far a control point of it is from it at most."""
    a = vec3_at(points, start)
    along = sub(vec3_at(points, start + size - 3), a)
    off = 0.0
    for i in range(start + 3, start + size - 3, 3):
        p = vec3_at(points, i)
        off = max(off, distance(p, axpy(on_side(p, a, along), along, a)))
    return norm(along), off


@register_jitable
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


@register_jitable
def _sought(enough: float, chord: tuple[float, float]) -> float:
    """Distance at both ends of a piece with which none of its points is nearer than ``enough``."""
    length, off = chord
    return math.sqrt(max(enough, 0.0) ** 2 + length * length / 4) + off


@register_jitable
def ends_near_meshes(
    surfaces: SurfaceSet,
    points: list[float],
    ends: Ends,
    nearest: float,
    required: float,
    room: Room,
) -> Sample:
    """Lower the distances at the ends of pieces that are one curve to those to the meshes.

    Args:
        surfaces: the meshes.
        points: of the n pieces, flat (3 n (degree + 1),), [unit], world.
        ends: theirs; written.
        nearest: the least distance so far, [unit].
        required: what is farther than that and the nearest sample may be left out, [unit].
        room: for descents.

    Returns:
        The nearest of the ends.
    """
    at_first, at_last, first, last = ends
    count = len(at_first)
    size = len(points) // count
    for end in range(count + 1):
        nearest = most_to_mesh(surfaces, nearest, _end(points, end, count))
    enough = widened(max(nearest, required))
    least, at, whose = math.inf, 0, -1
    before = 0.0
    for end in range(count + 1):
        after = _sought(enough, _chord(points, end * size, size)) if end < count else 0.0
        away, mesh, _, bound = nearest_mesh(
            surfaces, enough, max(before, after), _end(points, end, count), room
        )
        before = after
        if end > 0:
            at_last[end - 1], last[end - 1] = min(at_last[end - 1], away), bound
        if end < count:
            at_first[end], first[end] = min(at_first[end], away), bound
        if away < least:
            least, at, whose = away, end, mesh
    return least, at, whose


@register_jitable
def middles_near_meshes(
    surfaces: SurfaceSet,
    points: list[float],
    ends: Ends,
    of_middles: tuple[list[float], list[float], list[float]],
    nearest: float,
    demand: tuple[float, float, float],
    room: Room,
) -> Sample:
    """Lower the distances at the middles of pieces, and their bounds, to those to the meshes.

    A middle is left out where the ends of the piece, neither of which is too near or the nearest so
    far, bound it well enough.

    Args:
        surfaces, points, ends, nearest, room: see :func:`ends_near_meshes`.
        of_middles: distances at the middles (n,), bounds of those along the pieces from below
            (n,), and of those to the meshes alone at the middles (n,), [unit]; written.
        demand: see ``measure_curve``.

    Returns:
        The nearest of the middles.
    """
    at_first, at_last, first, last = ends
    at_middles, bounds, middle_bounds = of_middles
    required, tolerance, _ = demand
    size = len(points) // len(at_middles)
    halves = [0.0] * (2 * size)
    least, at, whose = math.inf, 0, -1
    for piece in range(len(at_middles)):
        enough = widened(max(min(nearest, least), required))
        bound = _least_between(first[piece], last[piece], _chord(points, piece * size, size))
        middle, near = bound, min(at_first[piece], at_last[piece])
        if near < required or near <= nearest or bound < enough - tolerance:
            divide(points, piece * size, halves, 0, size, size // 3, 0.5)
            left, right = _chord(halves, 0, size), _chord(halves, size, size)
            sought = max(_sought(enough, left), _sought(enough, right))
            x = vec3_at(halves, size)
            away, mesh, _, middle = nearest_mesh(surfaces, enough, sought, x, room)
            at_middles[piece] = min(at_middles[piece], away)
            halved = min(
                _least_between(first[piece], middle, left),
                _least_between(middle, last[piece], right),
            )
            bound = max(bound, halved)
            if away < least:
                least, at, whose = away, piece, mesh
        bounds[piece] = min(bounds[piece], bound)
        middle_bounds[piece] = middle
    return least, at, whose
