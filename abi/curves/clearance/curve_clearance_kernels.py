"""Distance from the Bézier pieces of a curve to the obstacles.

For the rows of numbers that describe primitives see ``primitive_kernels``. A point is three
successive numbers.
"""

from __future__ import annotations

import math

from abi.arrays import FloatArray
from abi.compilation.borrowed import borrowed, held
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, compiled
from abi.curves.clearance.mesh_clearance_kernels import (
    Pieces,
    Sample,
    joint_at,
    joints_near_meshes,
    middles_near_meshes,
)
from abi.curves.clearance.separation_kernels import divide, extent_of
from abi.obstacles.obstacle_set_kernels import distance_gradient, nearest_primitive
from abi.obstacles.primitive_kernels import WIDTH
from abi.obstacles.primitive_tree_kernels import next_near
from abi.obstacles.triangle_mesh.surface_kernels import NO_SURFACES, SurfaceSet
from abi.obstacles.triangle_mesh.surface_tables_kernels import new_room
from abi.obstacles.vector_kernels import Vec3

_MOST_HALVINGS = 40
_MOST_PIECES = 200_000

_ROUNDING = 1e-9  # by which a sample may be nearer than required

Measured = tuple[float, float, float, int, list[tuple[float, float]]]
"""Lower bound of the distance; the parameter, distance and obstacle of the nearest sample;
stretches that are too near, in no order, after one that means nothing."""


@jitable(forceinline=True)
def _bound(
    primitives: FloatArray, enough: float, points: list[float], piece: int, width: int, x: Vec3
) -> tuple[float, int, float]:
    """Minimum signed distance at a point x of a piece, its obstacle, and a bound for all the piece.

    Primitives that no point of the piece is nearer to than ``enough`` are left out: the result is
    at most ``enough``, inf and -1 when all are.
    """
    low, high = extent_of(points, piece, piece + 3 * width)
    best, whose, bound = math.inf, -1, math.inf
    s = next_near(primitives, -1, enough, low, high)
    while s >= 0:
        distance, (gx, gy, gz) = distance_gradient(primitives, s, x)
        rise = 0.0
        for i in range(piece, piece + 3 * width, 3):
            ahead = gx * (points[i] - x[0]) + gy * (points[i + 1] - x[1])
            rise = min(rise, ahead + gz * (points[i + 2] - x[2]))
        bound = min(bound, distance + rise)
        if distance < best or (distance == best and s < whose):
            best, whose = distance, s
        s = next_near(primitives, s, enough, low, high)
    return best, whose, bound


@jitable
def _cut(control: FloatArray, breaks: FloatArray, parts: int) -> tuple[list[float], list[float]]:
    """Points of the polynomials, each cut into ``parts`` equal parts; parameters between those."""
    spans = len(breaks) - 1
    width = len(control) // (3 * spans)
    size = 3 * width
    points, places = [0.0] * (spans * parts * size), [0.0] * 0
    rest = [0.0] * (2 * size)
    for k in range(spans):
        for i in range(size):
            rest[i] = control[k * size + i]
        for j in range(parts):
            piece = k * parts + j
            divide(rest, 0, rest, size, 0, width, 1.0 / (parts - j))
            for i in range(size):
                points[piece * size + i] = rest[size + i]
            places.append(breaks[k] + (breaks[k + 1] - breaks[k]) * (j / parts))
    places.append(breaks[spans])
    return points, places


@jitable
def _joints(
    primitives: FloatArray, points: list[float], places: list[float], required: float
) -> tuple[list[Sample], Sample]:
    """Sample the distance where pieces of a curve meet, and find the nearest of these points."""
    count = len(places) - 1
    nearest = Sample(places[0], math.inf, -1, math.inf)
    joints = [nearest] * (count + 1)
    for joint in range(count + 1):
        enough = max(nearest.distance, required)
        distance, primitive = nearest_primitive(primitives, enough, joint_at(points, joint, count))
        joints[joint] = Sample(places[joint], distance, primitive, math.inf)
        if primitive >= 0 and distance < nearest.distance:
            nearest = joints[joint]
    return joints, nearest


@jitable
def _sample_middles(
    primitives: FloatArray, pieces: Pieces, required: float, nearest: Sample
) -> tuple[list[Sample], list[float], Sample]:
    """Middles of pieces, lower bounds of the pieces' distances, and the nearest of all samples."""
    points, firsts, lasts = pieces
    count = len(firsts)
    width = len(points) // (3 * count)
    size = 3 * width
    middles, bounds = firsts.copy(), [math.inf] * count
    halves = [0.0] * (2 * size)
    for piece in range(count):
        divide(points, piece * size, halves, 0, size, width, 0.5)
        x = (halves[size], halves[size + 1], halves[size + 2])
        enough = max(nearest.distance, required)
        distance, primitive, bound = _bound(primitives, enough, points, piece * size, width, x)
        at = (firsts[piece].at + lasts[piece].at) / 2
        middles[piece], bounds[piece] = Sample(at, distance, primitive, math.inf), bound
        if distance < nearest.distance:
            nearest = middles[piece]
    return middles, bounds, nearest


@jitable
def _undecided(
    pieces: Pieces,
    middles: list[Sample],
    bounds: list[float],
    nearest: float,
    demand: tuple[float, float, float],
    exactly: bool,
) -> list[int]:
    """Pieces that may hold a nearer place, or of which it is open where they are too near.

    Args:
        pieces: the pieces.
        middles, bounds: theirs.
        nearest: distance of the nearest sample, [unit].
        demand: required, tolerance and finest, see :func:`measure_curve`.
        exactly: whether those with the nearest sample are halved until they are short, too: where
            the bounds are good, there is no other sample near it.
    """
    required, tolerance, finest = demand
    line = required - _ROUNDING
    undecided = [0] * 0
    for piece in range(len(middles)):
        first, middle, last = pieces.firsts[piece], middles[piece], pieces.lasts[piece]
        least = min(first.distance, middle.distance, last.distance)
        violating = least < line
        partly = violating and max(first.distance, middle.distance, last.distance) >= line
        if (
            bounds[piece] < nearest - tolerance
            or (not violating and bounds[piece] < required - tolerance)
            or ((partly or (exactly and least <= nearest)) and last.at - first.at > finest)
        ):
            undecided.append(piece)
    return undecided


@jitable
def _halves(pieces: Pieces, middles: list[Sample], chosen: list[int]) -> Pieces:
    """Both halves of the chosen pieces."""
    points, firsts, lasts = pieces
    size = len(points) // len(firsts)
    halves = [0.0] * (2 * len(chosen) * size)
    starts, ends = firsts[:0], lasts[:0]
    for j in range(len(chosen)):
        piece, left = chosen[j], 2 * j * size
        divide(points, piece * size, halves, left, left + size, size // 3, 0.5)
        starts.extend([firsts[piece], middles[piece]])
        ends.extend([middles[piece], lasts[piece]])
    return Pieces(halves, starts, ends)


@jitable
def _settle(
    pieces: Pieces,
    middles: list[Sample],
    bounds: list[float],
    chosen: list[int],
    required: float,
    stretches: list[tuple[float, float]],
) -> float:
    """Least bound of the pieces not chosen; those that are too near go to ``stretches``."""
    bottom = math.inf
    j = 0
    for piece in range(len(middles)):
        if j < len(chosen) and chosen[j] == piece:
            j += 1
            continue
        bottom = min(bottom, bounds[piece])
        first, middle, last = pieces.firsts[piece], middles[piece], pieces.lasts[piece]
        if min(first.distance, middle.distance, last.distance) < required - _ROUNDING:
            stretches.append((first.at, last.at))
    return bottom


@compiled(example=(FLOATS, FLOATS, 1, FLOATS, (1.0, 0.1, 0.1)))
def measure_curve(
    control: FloatArray,
    breaks: FloatArray,
    parts: int,
    primitives: FloatArray,
    demand: tuple[float, float, float],
) -> Measured:
    """Distance of a curve of Bézier pieces to primitives; see ``curve_clearance``.

    Args:
        control: Bézier points of the s polynomials, flat (3 s (degree + 1),), [unit], world.
        breaks: parameters between them (s + 1,).
        parts: equal parts that each polynomial is first cut into.
        primitives: rows (k WIDTH,), at least one.
        demand: distance to keep, [unit]: nearer stretches are returned; largest excess of the
            nearest sample over the bound, [unit]; and the length of stretches, in the parameter,
            that are not halved for their ends alone.
    """
    points, places = _cut(control, breaks, parts)
    joints, nearest = _joints(primitives, points, places, demand[0])
    pieces = Pieces(points, joints[:-1], joints[1:])
    bottom, stretches = nearest.distance, [(0.0, 0.0)]
    for halvings in range(_MOST_HALVINGS + 1):
        middles, bounds, nearest = _sample_middles(primitives, pieces, demand[0], nearest)
        chosen = _undecided(pieces, middles, bounds, nearest.distance, demand, False)
        if halvings == _MOST_HALVINGS or 2 * len(chosen) > _MOST_PIECES:
            chosen.clear()
        bottom = min(bottom, _settle(pieces, middles, bounds, chosen, demand[0], stretches))
        if len(chosen) == 0:
            break
        pieces = _halves(pieces, middles, chosen)
    return min(bottom, nearest.distance), nearest.at, nearest.distance, nearest.obstacle, stretches


@compiled(example=(FLOATS, FLOATS, 1, FLOATS, NO_SURFACES, (1.0, 0.1, 0.1)))
def measure_curve_near_meshes(
    control: FloatArray,
    breaks: FloatArray,
    parts: int,
    primitives: FloatArray,
    surfaces: SurfaceSet,
    demand: tuple[float, float, float],
) -> Measured:
    """Distance of a curve of Bézier pieces to primitives and meshes; see ``curve_clearance``.

    Args:
        control, breaks, parts: as for :func:`measure_curve`.
        primitives: rows (k WIDTH,).
        surfaces: the meshes, at least one.
        demand: as for :func:`measure_curve`.
    """
    own = new_room()
    room = borrowed(own)
    required = demand[0]
    points, places = _cut(control, breaks, parts)
    joints, nearest = _joints(primitives, points, places, required)
    first_row = len(primitives) // WIDTH
    nearest = joints_near_meshes(surfaces, first_row, points, joints, nearest, required, room)
    pieces = Pieces(points, joints[:-1], joints[1:])
    bottom, stretches = nearest.distance, [(0.0, 0.0)]
    for halvings in range(_MOST_HALVINGS + 1):
        middles, bounds, nearest = _sample_middles(primitives, pieces, required, nearest)
        nearest = middles_near_meshes(
            surfaces, first_row, pieces, middles, bounds, nearest, demand, room
        )
        exactly = nearest.obstacle >= first_row
        chosen = _undecided(pieces, middles, bounds, nearest.distance, demand, exactly)
        if halvings == _MOST_HALVINGS or 2 * len(chosen) > _MOST_PIECES:
            chosen.clear()
        bottom = min(bottom, _settle(pieces, middles, bounds, chosen, required, stretches))
        if len(chosen) == 0:
            break
        pieces = _halves(pieces, middles, chosen)
    held(own)
    return min(bottom, nearest.distance), nearest.at, nearest.distance, nearest.obstacle, stretches
