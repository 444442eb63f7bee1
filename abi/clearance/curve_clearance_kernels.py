"""How near a curve of Bézier pieces comes to convex solids.

Compiled by numba; ``curve`` runs uncompiled too, by its ``py_func`` on plain lists. For the rows of
numbers that describe solids see ``primitive_kernels``. A point is three successive numbers.
"""

from __future__ import annotations

import math

from numba.extending import register_jitable

from abi.arrays import FloatArray
from abi.compiled import FLOATS, compiled
from abi.obstacles.primitive_kernels import (
    WIDTH,
    axes_of,
    bounds_apart,
    centre_of,
    core_of,
    in_body,
    in_world,
    signed_distance,
    signed_distance_gradient,
)
from abi.obstacles.vector_kernels import Vec3, sub, vec3_at

MOST_HALVINGS = 40
MOST_PIECES = 200_000

Seen = tuple[float, float, float, int, list[tuple[float, float]]]
"""What the distance does not go below; the parameter, distance and solid of the nearest sample;
stretches that are too near, in no order, after one that means nothing."""


@register_jitable
def _divided(
    points: list[float], piece: int, into: list[float], left: int, right: int, width: int, r: float
) -> None:
    """De Casteljau: both parts, divided at r, of the piece at ``points[piece:]``."""
    for i in range(3 * width):
        into[right + i] = points[piece + i]
    for order in range(width):
        for k in range(3):
            into[left + 3 * order + k] = into[right + k]
        for i in range(right, right + 3 * (width - 1 - order)):
            into[i] = (1 - r) * into[i] + r * into[i + 3]


@register_jitable
def _sampled(solids: FloatArray, enough: float, p: Vec3) -> tuple[float, int]:
    """Least signed distance of a point and whose it is; ``enough`` and -1 if it is not below."""
    best, whose = enough, -1
    for s in range(len(solids) // WIDTH):
        if not bounds_apart(solids, s, best, p, p):
            q = in_body(axes_of(solids, s), sub(p, centre_of(solids, s)))
            found = signed_distance(core_of(solids, s), q)
            if found < best:
                best, whose = found, s
    return best, whose


@register_jitable
def _bounded(
    solids: FloatArray, enough: float, points: list[float], piece: int, width: int, x: Vec3
) -> tuple[float, int, float]:
    """Of a piece: the least signed distance at its point x, whose it is, and a lower bound.

    Solids that no point of the piece is nearer to than ``enough`` are left out: the result is at
    most ``enough``, inf and -1 when all are.
    """
    lx, ly, lz = points[piece], points[piece + 1], points[piece + 2]
    hx, hy, hz = lx, ly, lz
    for i in range(piece + 3, piece + 3 * width, 3):
        lx, hx = min(lx, points[i]), max(hx, points[i])
        ly, hy = min(ly, points[i + 1]), max(hy, points[i + 1])
        lz, hz = min(lz, points[i + 2]), max(hz, points[i + 2])
    best, whose, bound = math.inf, -1, math.inf
    for s in range(len(solids) // WIDTH):
        if bounds_apart(solids, s, enough, (lx, ly, lz), (hx, hy, hz)):
            continue
        axes = axes_of(solids, s)
        p = in_body(axes, sub(x, centre_of(solids, s)))
        away, outward = signed_distance_gradient(core_of(solids, s), p)
        gx, gy, gz = in_world(axes, outward)
        rise = 0.0
        for i in range(piece, piece + 3 * width, 3):
            ahead = gx * (points[i] - x[0]) + gy * (points[i + 1] - x[1])
            rise = min(rise, ahead + gz * (points[i + 2] - x[2]))
        bound = min(bound, away + rise)
        if away < best:
            best, whose = away, s
    return best, whose, bound


@compiled(example=(FLOATS, FLOATS, 1, FLOATS, 1.0, 0.1, 0.1))
def curve(
    control: FloatArray,
    breaks: FloatArray,
    parts: int,
    solids: FloatArray,
    asked: float,
    tolerance: float,
    finest: float,
) -> Seen:
    """How near a curve of Bézier pieces comes to solids; see ``curve_clearance.measure``.

    Args:
        control: Bézier points of the s polynomials, flat (3 s (degree + 1),), [unit], world.
        breaks: parameters between them (s + 1,).
        parts: equal parts that each polynomial is first cut into.
        solids: rows (k WIDTH,), k >= 1.
        asked: stretches that are nearer than this are told, [unit].
        tolerance: largest excess of the nearest sample over the bound, [unit].
        finest: stretches are not made finer than this just to tell where they end, in the
            parameter.
    """
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
            ratio = 1.0 / (parts - j)
            _divided(rest, 0, rest, size, 0, width, ratio)
            for i in range(size):
                points[piece * size + i] = rest[size + i]
            starts[piece] = breaks[k] + (breaks[k + 1] - breaks[k]) * (j / parts)
            ends[piece] = breaks[k] + (breaks[k + 1] - breaks[k]) * ((j + 1) / parts)
        ends[k * parts + parts - 1] = breaks[k + 1]

    at, nearest = starts[0], math.inf
    whose = -1
    at_starts, at_ends = [math.inf] * count, [math.inf] * count
    for piece in range(count + 1):
        last = piece == count
        i = count * size - 3 if last else piece * size
        enough = max(nearest, asked)
        away, solid = _sampled(solids, enough, vec3_at(points, i))
        if piece > 0:
            at_ends[piece - 1] = away
        if not last:
            at_starts[piece] = away
        if solid >= 0 and away < nearest:
            at = ends[count - 1] if last else starts[piece]
            nearest, whose = away, solid
    bottom = nearest
    stretches = [(0.0, 0.0)]
    line = asked - 1e-9
    for halvings in range(MOST_HALVINGS + 1):
        middles, bounds = [math.inf] * count, [math.inf] * count
        for piece in range(count):
            _divided(points, piece * size, rest, 0, size, width, 0.5)
            x = (rest[size], rest[size + 1], rest[size + 2])
            enough = max(nearest, asked)
            away, solid, bound = _bounded(solids, enough, points, piece * size, width, x)
            middles[piece], bounds[piece] = away, bound
            if away < nearest:
                nearest, whose = away, solid
                at = (starts[piece] + ends[piece]) / 2
        unsure = [0] * 0
        for piece in range(count):
            first, middle, last_ = at_starts[piece], middles[piece], at_ends[piece]
            violating = min(first, middle, last_) < line
            partly = violating and max(first, middle, last_) >= line
            if (
                bounds[piece] < nearest - tolerance
                or (not violating and bounds[piece] < asked - tolerance)
                or (partly and ends[piece] - starts[piece] > finest)
            ):
                unsure.append(piece)
        if halvings == MOST_HALVINGS or 2 * len(unsure) > MOST_PIECES:
            unsure.clear()
        number = 2 * len(unsure)
        halves = [0.0] * (number * size)
        froms, tos = [0.0] * number, [0.0] * number
        at_froms, at_tos = [0.0] * number, [0.0] * number
        j = 0
        for piece in range(count):
            middle = (starts[piece] + ends[piece]) / 2
            if 2 * j < number and unsure[j] == piece:
                left = 2 * j
                _divided(points, piece * size, halves, left * size, left * size + size, width, 0.5)
                froms[left], tos[left], tos[left + 1] = starts[piece], middle, ends[piece]
                froms[left + 1] = middle
                at_froms[left], at_tos[left] = at_starts[piece], middles[piece]
                at_froms[left + 1], at_tos[left + 1] = middles[piece], at_ends[piece]
                j += 1
                continue
            bottom = min(bottom, bounds[piece])
            if min(at_starts[piece], middles[piece], at_ends[piece]) < line:
                stretches.append((starts[piece], ends[piece]))
        if number == 0:
            break
        points, count = halves, number
        starts, ends, at_starts, at_ends = froms, tos, at_froms, at_tos
    return min(bottom, nearest), at, nearest, whose, stretches
