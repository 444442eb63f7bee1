"""Tightening of a path in free space: in the box that contains it, between convex solids.

Plain Python that numba compiles with its caller; uncompiled it runs on lists. A path is a list of
points, [unit], world.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from abi.arrays import FloatArray
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS
from abi.obstacles.primitive_kernels import (
    WIDTH,
    axes_of,
    centre_of,
    core_of,
    in_body,
    in_world,
    segment_within,
    signed_distance_gradient,
)
from abi.obstacles.primitive_tree_kernels import blocked, next_near_segment
from abi.obstacles.vector_kernels import Vec3, add, axpy, cross, distance, dot, norm, sub


class FreeSpace(NamedTuple):
    """Set of points that a path may take.

    Attributes:
        solids: (k WIDTH,) rows, one after the other, see ``abi.obstacles.primitive_kernels``.
        margins: (4k,) distance from each solid that a segment keeps, [unit]: in general, from the
            first point, to the last point, from the first to the last.
        low: low corner of the box, [unit], world.
        high: high corner.
    """

    solids: FloatArray
    margins: FloatArray
    low: Vec3
    high: Vec3


SPACE = FreeSpace(FLOATS, FLOATS, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
"""Example of free space."""


@jitable
def kind_of(i: int, j: int, last: int) -> int:
    """Number of the margin that counts from point i to point j of a path that ends at ``last``."""
    return (1 if i == 0 else 0) + (2 if j == last else 0)


@jitable(inline="always")  # else the arrays are counted in and out: 4 % of ``pull``
def is_clear(space: FreeSpace, kind: int, a: Vec3, b: Vec3) -> bool:
    """Check whether the segment a..b keeps its margins from all solids.

    Args:
        space: free space.
        kind: see :func:`kind_of`.
        a: one end, [unit], world.
        b: the other end.
    """
    count = len(space.solids) // WIDTH
    return not blocked(space.solids, space.margins, kind * count, a, b)


@jitable
def in_bounds(space: FreeSpace, p: Vec3) -> bool:
    """Check whether a point lies in the box."""
    low, high = space.low, space.high
    return low[0] <= p[0] <= high[0] and low[1] <= p[1] <= high[1] and low[2] <= p[2] <= high[2]


_STEPS = 14  # halvings when a corner is cut: to 1/16,000 of the leg
_HALVINGS = 24  # when the point is looked for that touches a solid
_LOOK_BACK = 64  # points to which one may be joined
_ALL_BACK = 8  # of which so many are tried, and of the others each fourth
_STRIDE = 4
_MOST_POINTS = 256
_SWEEPS = 24
_SWEEPS_AFTER_CUT = 4  # sweeps after each round of cuts
_CUTS = 8
_SETTLED = 1e-6  # part of the length that a sweep must gain to be followed by another
_QUICK_SETTLED = 3e-4  # the same, and how many sweeps, for a first look
_QUICK_SWEEPS = 3


@jitable
def _touched(space: FreeSpace, kind: int, reach: float, a: Vec3, b: Vec3) -> Vec3:
    """Unit normal, in the world, of the solid that the segment a..b touches first from a.

    Zero where none is within ``reach`` of its margin.
    """
    solids, margins = space.solids, space.margins
    first = kind * (len(solids) // WIDTH)
    earliest, normal = 2.0, (0.0, 0.0, 0.0)
    most = margins[0] + reach if len(margins) > 0 else reach
    s = next_near_segment(solids, -1, most, a, b)
    while s >= 0:
        limit = margins[first + s] + reach
        axes, core = axes_of(solids, s), core_of(solids, s)
        p = in_body(axes, sub(a, centre_of(solids, s)))
        d = in_body(axes, sub(b, a))
        if segment_within(core, limit, p, d):
            low, high = 0.0, 1.0
            for _ in range(_HALVINGS):
                t = (low + high) / 2
                if dot(signed_distance_gradient(core, axpy(t, d, p))[1], d) > 0:
                    high = t
                else:
                    low = t
            if low < earliest:
                earliest = low
                normal = in_world(axes, signed_distance_gradient(core, axpy(low, d, p))[1])
        s = next_near_segment(solids, s, most, a, b)
    return normal


@jitable
def _divided(a: Vec3, t: float) -> Vec3:
    """a / t."""
    return (a[0] / t, a[1] / t, a[2] / t)


@jitable
def _fits(path: list[Vec3], i: int, p: Vec3, space: FreeSpace) -> bool:
    """Check whether point i can be p: both its legs are clear."""
    last = len(path) - 1
    return is_clear(space, kind_of(i - 1, i, last), path[i - 1], p) and is_clear(
        space, kind_of(i, i + 1, last), p, path[i + 1]
    )


@jitable
def _straighten(path: list[Vec3], i: int, space: FreeSpace) -> None:
    """Move point i towards the chord of its neighbours as far as its legs stay clear."""
    a, here, b = path[i - 1], path[i], path[i + 1]
    before, after = distance(a, here), distance(here, b)
    if before + after == 0:
        return
    to_chord = sub(axpy(before / (before + after), sub(b, a), a), here)
    low, high, step = 0.0, 1.0, 0.5**_STEPS
    for _ in range(_STEPS):
        if _fits(path, i, axpy(step, to_chord, here), space):
            low = step
        elif low == 0:
            break
        else:
            high = step
        step = (low + high) / 2
    if low > 0:
        path[i] = axpy(low, to_chord, here)


@jitable
def _slide_direction(a: Vec3, b: Vec3, m: Vec3, n: Vec3) -> Vec3:
    """Direction in which a point stays in two planes; of the pull within it where there is one.

    Args:
        a: unit vector to one neighbour.
        b: unit vector to the other.
        m: normal of the plane in which the leg to the first touches, or zero.
        n: of that in which the other touches.

    Returns:
        A unit vector, or zero where nothing can be gained.
    """
    direction = cross(m, n)
    if dot(direction, direction) < 1e-8:
        if n[0] == 0 and n[1] == 0 and n[2] == 0:
            n = m
        pull = add(a, b)
        direction = axpy(-dot(pull, n), n, pull)
    size = norm(direction)
    return _divided(direction, size) if size >= 1e-9 else (0.0, 0.0, 0.0)


@jitable
def _slide(path: list[Vec3], i: int, space: FreeSpace, reach: float) -> None:
    """Move point i along the surfaces that its legs touch to where the legs are shortest.

    Both legs stay in the planes in which they touch, so the point moves along the line in which
    these meet; where there is only one plane, along the pull of the legs within it.
    """
    last, here = len(path) - 1, path[i]
    a, b = sub(path[i - 1], here), sub(path[i + 1], here)
    to_a, to_b = norm(a), norm(b)
    if to_a == 0 or to_b == 0:
        return
    m = _touched(space, kind_of(i - 1, i, last), reach, here, path[i - 1])
    n = _touched(space, kind_of(i, i + 1, last), reach, here, path[i + 1])
    direction = _slide_direction(_divided(a, to_a), _divided(b, to_b), m, n)
    # On a line the path from a to b is shortest where the mirror image of b about it is in line.
    along_a, along_b = dot(a, direction), dot(b, direction)
    off_a = math.sqrt(max(to_a * to_a - along_a * along_a, 0.0))
    off_b = math.sqrt(max(to_b * to_b - along_b * along_b, 0.0))
    if dot(direction, direction) == 0 or off_a + off_b == 0:
        return
    step = (along_a * off_b + along_b * off_a) / (off_a + off_b)
    for _ in range(6):
        p = axpy(step, direction, here)
        if (
            in_bounds(space, p)
            and distance(path[i - 1], p) + distance(p, path[i + 1]) < to_a + to_b
            and _fits(path, i, p, space)
        ):
            path[i] = p
            return
        step /= 4


@jitable
def _settle(path: list[Vec3], space: FreeSpace, sweeps: int, settled: float) -> None:
    """Drop, straighten and slide the points in turn until the path gets no shorter."""
    length = length_of(path)
    for _ in range(sweeps):
        i = 1
        while i < len(path) - 1:
            if is_clear(space, kind_of(i - 1, i + 1, len(path) - 1), path[i - 1], path[i + 1]):
                path.pop(i)
                continue
            _straighten(path, i, space)
            _slide(path, i, space, 1e-3 * length)
            i += 1
        before = length
        length = length_of(path)
        if before - length < settled * length:
            break


@jitable
def _widest_cut(
    space: FreeSpace, corner: Vec3, a: Vec3, b: Vec3, least: float, most: float
) -> float:
    """Distance from a corner at which it can be cut on both legs, 0 where it cannot.

    Args:
        space: free space.
        corner: point of the path.
        a: unit vector along one leg.
        b: unit vector along the other.
        least: a shorter cut gains too little, [unit].
        most: a cut stays below this, [unit].
    """
    low, cut = 0.0, least
    if cut < most:
        for _ in range(_STEPS):
            if is_clear(space, 0, axpy(cut, a, corner), axpy(cut, b, corner)):
                low = cut
            elif low == 0:
                break
            else:
                most = cut
            cut = (low + most) / 2
    return low


@jitable
def _cut_corners(path: list[Vec3], space: FreeSpace, least_gain: float) -> bool:
    """Cut each corner at one distance on both legs where that gains enough; whether any was."""
    any_cut = False
    i = 1
    while i < len(path) - 1 and len(path) < _MOST_POINTS:
        corner = path[i]
        before, after = distance(path[i - 1], corner), distance(corner, path[i + 1])
        if before == 0 or after == 0:
            i += 1
            continue
        a = _divided(sub(path[i - 1], corner), before)
        b = _divided(sub(path[i + 1], corner), after)
        # between two bends each takes half of the leg
        most = min(before if i == 1 else before / 2, after if i == len(path) - 2 else after / 2)
        gain = 2 - distance(a, b)
        cut = _widest_cut(space, corner, a, b, least_gain / max(gain, 1e-12), most)
        if cut > 0:
            path[i] = axpy(cut, a, corner)
            path.insert(i + 1, axpy(cut, b, corner))
            any_cut = True
            i += 1
        i += 1
    return any_cut


@jitable
def _shortcut(path: list[Vec3], space: FreeSpace) -> list[Vec3]:
    """The shortest path from first to last by points of the path that see each other."""
    last = len(path) - 1
    cost = [0.0]
    parent = [0]
    for j in range(1, last + 1):
        best, by = math.inf, j - 1
        for i in range(max(0, j - _LOOK_BACK), j):
            if j - i > _ALL_BACK and i % _STRIDE != 0:
                continue
            through = cost[i] + distance(path[i], path[j])
            if through < best and (
                i == j - 1 or is_clear(space, kind_of(i, j, last), path[i], path[j])
            ):
                best, by = through, i
        cost.append(best)
        parent.append(by)
    kept = [last]
    while kept[-1] != 0:
        kept.append(parent[kept[-1]])
    return [path[i] for i in kept[::-1]]


@jitable
def length_of(path: list[Vec3]) -> float:
    """Length of a path."""
    length = 0.0
    for i in range(1, len(path)):
        length += distance(path[i - 1], path[i])
    return length


@jitable
def tighten(path: list[Vec3], space: FreeSpace, least_gain: float) -> list[Vec3]:
    """Pull a path taut: never longer, and every new segment clear.

    Skips points that it can do without, then moves each to where its legs are shortest, on the
    planes in which these touch a solid, until the length stops improving. Then cuts the corners:
    around a rounded edge one point becomes several.

    Args:
        path: n >= 2 points, its segments clear.
        space: free space.
        least_gain: part of the length that a cut corner must gain; inf for a first look, which cuts
            none and stops sooner.
    """
    taut = _shortcut(path, space)
    if least_gain == math.inf:
        _settle(taut, space, _QUICK_SWEEPS, _QUICK_SETTLED)
        return taut
    _settle(taut, space, _SWEEPS, _SETTLED)
    length = length_of(taut)
    for _ in range(_CUTS):
        if not _cut_corners(taut, space, least_gain * length):
            break
        _settle(taut, space, _SWEEPS_AFTER_CUT, _SETTLED)
    return taut
