"""Distance from the Bézier pieces of a curve to the obstacles.

For the rows of numbers that describe primitives see ``primitive_kernels``. A point is three
successive numbers.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from numba.extending import register_jitable

from abi.arrays import FloatArray
from abi.clearance.bezier_kernels import divide, extent_of
from abi.clearance.mesh_clearance_kernels import ends_near_meshes, middles_near_meshes
from abi.compilation.borrowed import borrowed, held
from abi.compiled import FLOATS, compiled
from abi.obstacles.obstacle_set_kernels import distance_gradient, nearest_primitive
from abi.obstacles.primitive_kernels import WIDTH
from abi.obstacles.primitive_tree_kernels import next_near
from abi.obstacles.surface_set import NO_SURFACES, SurfaceSet
from abi.obstacles.triangle_mesh.surface_tables_kernels import Room, new_room
from abi.obstacles.vector_kernels import Vec3, vec3_at

_MOST_HALVINGS = 40
_MOST_PIECES = 200_000

_ROUNDING = 1e-9  # by which a sample may be nearer than required

Measured = tuple[float, float, float, int, list[tuple[float, float]]]
"""Lower bound of the distance; the parameter, distance and obstacle of the nearest sample;
stretches that are too near, in no order, after one that means nothing."""


class _Pieces(NamedTuple):
    """Bézier pieces of the curve, n in number, along it.

    Attributes:
        points: their points, flat (3 n (degree + 1),), [unit], world.
        starts: first parameters (n,).
        ends: last parameters (n,).
        at_starts: signed distances at their first points (n,), [unit].
        at_ends: signed distances at their last points (n,), [unit].
        mesh_starts: lower bounds of those to the meshes alone at their first points (n,), [unit].
        mesh_ends: the same at their last points (n,), [unit].
    """

    points: list[float]
    starts: list[float]
    ends: list[float]
    at_starts: list[float]
    at_ends: list[float]
    mesh_starts: list[float]
    mesh_ends: list[float]


class _Middles(NamedTuple):
    """Knowledge of the middles of pieces, n in number.

    Attributes:
        at: signed distances (n,), [unit].
        bounds: lower bounds of the distances along the pieces (n,), [unit].
        meshes: lower bounds of the distances to the meshes alone (n,), [unit].
    """

    at: list[float]
    bounds: list[float]
    meshes: list[float]


class _Nearest(NamedTuple):
    """The sample nearest to an obstacle: its signed distance, [unit], parameter, and whose it is.

    The obstacles are the primitives and then the meshes; it is -1 before there is any.
    """

    distance: float
    at: float
    obstacle: int


class _Around(NamedTuple):
    """Obstacles around a curve.

    Attributes:
        primitives: rows (k WIDTH,).
        surfaces: the meshes.
        room: for descents of their trees.
    """

    primitives: FloatArray
    surfaces: SurfaceSet
    room: Room


@register_jitable(forceinline=True)
def _bound(
    primitives: FloatArray, enough: float, points: list[float], piece: int, width: int, x: Vec3
) -> tuple[float, int, float]:
    """Of a piece: the least signed distance at its point x, whose it is, and a lower bound.

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


@register_jitable
def _first_pieces(control: FloatArray, breaks: FloatArray, parts: int) -> _Pieces:
    """The polynomials, each cut into ``parts`` equal parts; the distances are left open."""
    spans = len(breaks) - 1
    width = len(control) // (3 * spans)
    size = 3 * width
    count = spans * parts
    points = [0.0] * (count * size)
    starts, ends = [0.0] * count, [0.0] * count
    rest = [0.0] * (2 * size)
    for k in range(spans):
        for i in range(size):
            rest[i] = control[k * size + i]
        for j in range(parts):
            piece = k * parts + j
            divide(rest, 0, rest, size, 0, width, 1.0 / (parts - j))
            for i in range(size):
                points[piece * size + i] = rest[size + i]
            starts[piece] = breaks[k] + (breaks[k + 1] - breaks[k]) * (j / parts)
            ends[piece] = breaks[k] + (breaks[k + 1] - breaks[k]) * ((j + 1) / parts)
        ends[k * parts + parts - 1] = breaks[k + 1]
    at_starts, at_ends = [math.inf] * count, [math.inf] * count
    return _Pieces(points, starts, ends, at_starts, at_ends, at_starts.copy(), at_ends.copy())


@register_jitable
def _sample_ends(around: _Around, pieces: _Pieces, required: float) -> _Nearest:
    """Fill in the distances at the ends of pieces that are one curve; the nearest of them."""
    primitives, surfaces, room = around
    points, starts, ends, at_starts, at_ends = pieces[:5]
    count = len(starts)
    size = len(points) // count
    at, nearest, whose = starts[0], math.inf, -1
    for piece in range(count + 1):
        last = piece == count
        p = vec3_at(points, count * size - 3 if last else piece * size)
        distance, primitive = nearest_primitive(primitives, max(nearest, required), p)
        if piece > 0:
            at_ends[piece - 1] = distance
        if not last:
            at_starts[piece] = distance
        if primitive >= 0 and distance < nearest:
            at = ends[count - 1] if last else starts[piece]
            nearest, whose = distance, primitive
    if len(surfaces.whose) > 0:
        distance, piece, mesh = ends_near_meshes(
            surfaces, points, pieces[3:7], nearest, required, room
        )
        if distance < nearest:
            at = ends[count - 1] if piece == count else starts[piece]
            nearest, whose = distance, len(primitives) // WIDTH + mesh
    return _Nearest(nearest, at, whose)


@register_jitable
def _sample_middles(
    around: _Around, pieces: _Pieces, demand: tuple[float, float, float], before: _Nearest
) -> tuple[_Middles, _Nearest]:
    """Distances at the middles of pieces and lower bounds of theirs; the nearest of all samples."""
    primitives, surfaces, room = around
    points, starts, ends = pieces.points, pieces.starts, pieces.ends
    required = demand[0]
    count = len(starts)
    width = len(points) // (3 * count)
    size = 3 * width
    middles, bounds = [math.inf] * count, [math.inf] * count
    halves = [0.0] * (2 * size)
    nearest, at, whose = before
    for piece in range(count):
        divide(points, piece * size, halves, 0, size, width, 0.5)
        x = (halves[size], halves[size + 1], halves[size + 2])
        enough = max(nearest, required)
        distance, primitive, bound = _bound(primitives, enough, points, piece * size, width, x)
        middles[piece], bounds[piece] = distance, bound
        if distance < nearest:
            nearest, at, whose = distance, (starts[piece] + ends[piece]) / 2, primitive
    meshes = middles.copy()
    if len(surfaces.whose) > 0:
        known = middles, bounds, meshes
        distance, piece, mesh = middles_near_meshes(
            surfaces, points, pieces[3:7], known, nearest, demand, room
        )
        if distance < nearest:
            at = (starts[piece] + ends[piece]) / 2
            nearest, whose = distance, len(primitives) // WIDTH + mesh
    return _Middles(middles, bounds, meshes), _Nearest(nearest, at, whose)


@register_jitable
def _undecided(
    pieces: _Pieces,
    middles: _Middles,
    nearest: float,
    demand: tuple[float, float, float],
    exactly: bool,
) -> list[int]:
    """Pieces that may hold a nearer place, or of which it is open where they are too near.

    Args:
        pieces: the pieces.
        middles: theirs.
        nearest: distance of the nearest sample, [unit].
        demand: required, tolerance and finest, see :func:`measure_curve`.
        exactly: whether those with the nearest sample are halved until they are short, too: where
            the bounds are good, there is no other sample near it.
    """
    starts, ends, at_starts, at_ends = pieces[1:5]
    required, tolerance, finest = demand
    line = required - _ROUNDING
    undecided = [0] * 0
    for piece in range(len(starts)):
        first, middle, last = at_starts[piece], middles.at[piece], at_ends[piece]
        least = min(first, middle, last)
        violating = least < line
        partly = violating and max(first, middle, last) >= line
        if (
            middles.bounds[piece] < nearest - tolerance
            or (not violating and middles.bounds[piece] < required - tolerance)
            or ((partly or (exactly and least <= nearest)) and ends[piece] - starts[piece] > finest)
        ):
            undecided.append(piece)
    return undecided


@register_jitable
def _halves(pieces: _Pieces, middles: _Middles, chosen: list[int]) -> _Pieces:
    """Both halves of the chosen pieces."""
    points, starts, ends, at_starts, at_ends, mesh_starts, mesh_ends = pieces
    width = len(points) // (3 * len(starts))
    size = 3 * width
    number = 2 * len(chosen)
    halves = [0.0] * (number * size)
    froms, tos = [0.0] * number, [0.0] * number
    at_froms, at_tos = [0.0] * number, [0.0] * number
    mesh_froms, mesh_tos = [0.0] * number, [0.0] * number
    for j in range(len(chosen)):
        piece, left = chosen[j], 2 * j
        middle = (starts[piece] + ends[piece]) / 2
        divide(points, piece * size, halves, left * size, left * size + size, width, 0.5)
        froms[left], tos[left], tos[left + 1] = starts[piece], middle, ends[piece]
        froms[left + 1] = middle
        at_froms[left], at_tos[left] = at_starts[piece], middles.at[piece]
        at_froms[left + 1], at_tos[left + 1] = middles.at[piece], at_ends[piece]
        mesh_froms[left], mesh_tos[left] = mesh_starts[piece], middles.meshes[piece]
        mesh_froms[left + 1], mesh_tos[left + 1] = middles.meshes[piece], mesh_ends[piece]
    return _Pieces(halves, froms, tos, at_froms, at_tos, mesh_froms, mesh_tos)


@compiled(example=(FLOATS, FLOATS, 1, FLOATS, NO_SURFACES, (1.0, 0.1, 0.1)))
def measure_curve(
    control: FloatArray,
    breaks: FloatArray,
    parts: int,
    primitives: FloatArray,
    surfaces: SurfaceSet,
    demand: tuple[float, float, float],
) -> Measured:
    """Distance of a curve of Bézier pieces to obstacles; see ``curve_clearance``.

    Args:
        control: Bézier points of the s polynomials, flat (3 s (degree + 1),), [unit], world.
        breaks: parameters between them (s + 1,).
        parts: equal parts that each polynomial is first cut into.
        primitives: rows (k WIDTH,).
        surfaces: the meshes; of both at least one.
        demand: distance to keep, [unit]: nearer stretches are returned; largest excess of the
            nearest sample over the bound, [unit]; and the length of stretches, in the parameter,
            that are not halved for their ends alone.
    """
    required = demand[0]
    own = new_room()
    around = _Around(primitives, surfaces, borrowed(own))
    pieces = _first_pieces(control, breaks, parts)
    nearest = _sample_ends(around, pieces, required)
    bottom = nearest.distance
    stretches = [(0.0, 0.0)]
    for halvings in range(_MOST_HALVINGS + 1):
        middles, nearest = _sample_middles(around, pieces, demand, nearest)
        exactly = nearest.obstacle >= len(primitives) // WIDTH
        chosen = _undecided(pieces, middles, nearest.distance, demand, exactly)
        if halvings == _MOST_HALVINGS or 2 * len(chosen) > _MOST_PIECES:
            chosen.clear()
        j = 0
        for piece in range(len(middles.at)):
            if j < len(chosen) and chosen[j] == piece:
                j += 1
                continue
            bottom = min(bottom, middles.bounds[piece])
            ends = min(pieces.at_starts[piece], pieces.at_ends[piece])
            if min(ends, middles.at[piece]) < required - _ROUNDING:
                stretches.append((pieces.starts[piece], pieces.ends[piece]))
        if len(chosen) == 0:
            break
        pieces = _halves(pieces, middles, chosen)
    held(own)
    distance, at, obstacle = nearest
    return min(bottom, distance), at, distance, obstacle, stretches
