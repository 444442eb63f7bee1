"""Surroundings of an arm in the format of the kernels, and their separation from a segment.

``abi.arm_planning.world.collision_world`` makes them from a scene's obstacles, with boxes that
contain its triangle meshes as rows in the format of convex primitives.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.compilation.jitable import jitable
from abi.compiled import FLAGS, FLOATS, IDS, NEW_FLOATS, compiled
from abi.curves.clearance.separation_kernels import CERTIFIED, REFUTED, UNDECIDED
from abi.obstacles.primitive_kernels import (
    BOUNDS,
    WIDTH,
    Axes,
    Core,
    centre_of,
    in_world,
    signed_distance_gradient,
    support,
)
from abi.obstacles.vector_kernels import Vec3, add, axpy, dot, sub, vec3_at

_STEPS = 40


class Obstacles(NamedTuple):
    """Everything around that the arm is to keep clear of.

    Attributes:
        primitives: rows (k WIDTH,).
        inside: first and last row but one of those inside a row that is a box around others; 0 and
            0 of what is itself solid (2 k,).
        meshes: number of the triangle mesh that a row holds a part of, -1 of others (k + 1,).
        margins: distance to prove from each of them and, last, from the floor (k + 1,), [unit].
        asked: whether a capsule is to keep clear of one of them, flat (c (k + 1),).
        outer: those of which that may be, in their order, at most all of them.
        floor: height of the floor, [unit].
        size: largest coordinate of arm and obstacles, [unit].
    """

    primitives: FloatArray
    inside: IntArray
    meshes: IntArray
    margins: FloatArray
    asked: BoolArray
    outer: IntArray
    floor: float
    size: float


NO_OBSTACLES = Obstacles(FLOATS, IDS, IDS, FLOATS, FLAGS, IDS, 0.0, 1.0)
"""Example for the compiler."""


@jitable(forceinline=True)
def box_gap(primitives: FloatArray, s: int, a: Vec3, b: Vec3) -> float:
    """Largest gap along an axis of the world between a segment and primitive s."""
    k = WIDTH * s + BOUNDS
    # written out: a loop over the axes takes half as long again
    x = max(min(a[0], b[0]) - primitives[k + 3], primitives[k] - max(a[0], b[0]))
    y = max(min(a[1], b[1]) - primitives[k + 4], primitives[k + 1] - max(a[1], b[1]))
    z = max(min(a[2], b[2]) - primitives[k + 5], primitives[k + 2] - max(a[2], b[2]))
    gap: float = max(x, max(y, z))
    return gap


@jitable(forceinline=True)
def between_boxes(primitives: FloatArray, s: int, a: Vec3, b: Vec3) -> tuple[float, Vec3]:
    """Gap between a segment and a box, as :func:`box_gap` gives it, and the axis across it."""
    k, best = WIDTH * s + BOUNDS, box_gap(primitives, s, a, b)
    if min(a[0], b[0]) - primitives[k + 3] == best:
        return best, (1.0, 0.0, 0.0)
    if primitives[k] - max(a[0], b[0]) == best:
        return best, (-1.0, 0.0, 0.0)
    if min(a[1], b[1]) - primitives[k + 4] == best:
        return best, (0.0, 1.0, 0.0)
    if primitives[k + 1] - max(a[1], b[1]) == best:
        return best, (0.0, -1.0, 0.0)
    if min(a[2], b[2]) - primitives[k + 5] == best:
        return best, (0.0, 0.0, 1.0)
    return best, (0.0, 0.0, -1.0)


@jitable(forceinline=True)
def judged(core: Core, p: Vec3, d: Vec3, near: float, far: float) -> tuple[int, float, Vec3]:
    """Check if the segment from p to p + d, body frame, is separated by more than ``far``.

    A tangent bounds the distance, which is convex along the segment, from below, and its gradient
    separates as far as that bound. The next place is where those at both ends of the bracket meet,
    in turn with its middle.

    Returns:
        CERTIFIED with the gap and its direction; REFUTED with a distance below ``near``; else
        UNDECIDED.
    """
    low, high = 0.0, 1.0
    at_low, fall, at_high, rise = 0.0, 0.0, 0.0, 0.0  # distances and slopes once they are known
    square = dot(d, d)
    # nearest to the centre: there most segments are decided
    t = min(max(-dot(p, d) / square, 0.0), 1.0) if square > 0 else 0.0
    best, way = math.inf, (0.0, 0.0, 1.0)
    for step in range(_STEPS):
        away, way = signed_distance_gradient(core, axpy(t, d, p))
        best = min(best, away)
        if best < near:
            return REFUTED, best, way
        slope = dot(way, d)
        gap = dot(way, p) + min(0.0, slope) - support(core, way)
        if gap > far:
            return CERTIFIED, gap, way
        if slope == 0 or (slope < 0 and t == 1) or (slope > 0 and t == 0):
            return UNDECIDED, best, way
        if slope < 0:
            low, at_low, fall = t, away, slope
        else:
            high, at_high, rise = t, away, slope
        if fall == 0:
            t = 0.0
        elif rise == 0:
            t = 1.0
        else:
            t = (at_low - at_high + rise * high - fall * low) / (rise - fall)
            if best <= far and at_low + fall * (t - low) >= near:
                return UNDECIDED, best, way
            if step % 3 == 2 or not low < t < high:
                t = (low + high) / 2
            if not low < t < high:
                return UNDECIDED, best, way
    return UNDECIDED, best, way


@jitable(forceinline=True)
def is_solid(around: Obstacles, pair: int) -> bool:
    """Check whether the obstacle of a pair is solid, not a box around others."""
    count = len(around.margins)
    s = pair % count
    return s == count - 1 or around.inside[2 * s + 1] == 0


@jitable(forceinline=True)
def open_box(
    around: Obstacles, pair: int, moves: float, segment: tuple[Vec3, Vec3], work: list[int]
) -> bool:
    """Add what is inside a box that is larger than a capsule's way; whether it is one.

    What is nearest to the capsule's segment comes last, to be tried first.
    """
    return not is_solid(around, pair) and _opened(around, pair, moves, segment, work)


@jitable(forceinline=True)
def _opened(
    around: Obstacles, pair: int, moves: float, segment: tuple[Vec3, Vec3], work: list[int]
) -> bool:
    """Push the child boxes of a mesh row, if it is larger than a capsule's displacement."""
    s = pair % len(around.margins)
    k = WIDTH * s + BOUNDS
    size = 0.0
    for axis in range(3):
        size = max(size, around.primitives[k + 3 + axis] - around.primitives[k + axis])
    if size < moves:
        return False
    a, b = segment
    way = sub(b, a)
    square = max(dot(way, way), 1e-300)
    nearest, at = math.inf, 0
    for row in range(around.inside[2 * s], around.inside[2 * s + 1]):
        work.append(pair - s + row)
        p = sub(centre_of(around.primitives, row), a)
        p = axpy(-min(max(dot(p, way) / square, 0.0), 1.0), way, p)
        if dot(p, p) < nearest:
            nearest, at = dot(p, p), len(work) - 1
    last = len(work) - 1
    work[at], work[last] = work[last], work[at]
    return True


@jitable
def asked_rows(around: Obstacles, moving: int) -> list[int]:
    """Rows, of which the last may be the floor's, that some of so many capsules keep clear of."""
    count = len(around.margins)
    rows = []
    for k in range(len(around.outer)):
        s, asked = int(around.outer[k]), False
        for c in range(moving):
            asked = asked or around.asked[c * count + s]
        if asked:
            rows.append(s)
    return rows


@jitable(forceinline=True)
def add_pairs_within(
    around: Obstacles, c: int, segment: tuple[Vec3, Vec3], far: float, pairs: list[int]
) -> None:
    """Add the pairs of capsule c, times the number of rows, that boxes do not keep clear.

    Args:
        around: what to keep clear of.
        c: number of the capsule.
        segment: its ends, [unit], world.
        far: distance from it beyond the margins, [unit]; inf for all pairs that are asked for.
        pairs: written.
    """
    count = len(around.margins)
    for k in range(len(around.outer)):
        s = around.outer[k]
        if around.asked[c * count + s] and (
            s == count - 1
            or box_gap(around.primitives, s, segment[0], segment[1]) <= far + around.margins[s]
        ):
            pairs.append(c * count + s)


_ROUNDING = 1e-12

_AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@compiled(example=(FLOATS, FLOATS, FLOATS, _AXES, (0.0, 0.0, 0.0), 1.0, NEW_FLOATS))
def box_rows(
    middles: FloatArray,
    halves: FloatArray,
    axes: FloatArray,
    turned: Axes,
    position: Vec3,
    factor: float,
    rows: FloatArray,
) -> None:
    """Write the rows of boxes that are placed in the world, a little larger, for rounding.

    Args:
        middles: of the boxes, in the file's unit, flat (3 n,).
        halves: half sizes, flat (3 n,).
        axes: their axes as columns, flat (9 n,).
        turned: axes of the file in the world.
        position: its origin, [unit], world.
        factor: [unit] per unit of the file.
        rows: flat (n WIDTH,), 0 at first; written.
    """
    count = len(rows) // WIDTH
    largest, farthest = 0.0, 0.0
    for i in range(count):
        x, y, z = in_world(turned, vec3_at(middles, 3 * i))
        centre = add(position, (factor * x, factor * y, factor * z))
        for k in range(3):
            rows[WIDTH * i + k] = centre[k]
            farthest = max(farthest, abs(centre[k]))
            largest = max(largest, factor * halves[3 * i + k])
    pad = _ROUNDING * (largest + farthest)
    for i in range(count):
        row = WIDTH * i
        x = y = z = 0.0
        for k in range(3):
            j = 9 * i + k
            u, v, w = in_world(turned, (axes[j], axes[j + 3], axes[j + 6]))
            half = factor * halves[3 * i + k] + pad
            rows[row + 3 + 3 * k], rows[row + 4 + 3 * k], rows[row + 5 + 3 * k] = u, v, w
            rows[row + 12 + k] = half
            x, y, z = x + abs(u) * half, y + abs(v) * half, z + abs(w) * half
        for k in range(3):
            reach = x if k == 0 else y if k == 1 else z
            rows[row + BOUNDS + k] = rows[row + k] - reach
            rows[row + BOUNDS + 3 + k] = rows[row + k] + reach
