"""Distances of polylines and points to convex solids.

Compiled by numba; each runs uncompiled too, by its ``py_func`` on plain lists. For the rows of
numbers that describe solids see ``primitive_kernels``. A point is three successive numbers.
"""

from __future__ import annotations

import math

from numba.extending import register_jitable

from abi.arrays import FloatArray
from abi.compiled import FLOATS, NEW_FLOATS, compiled
from abi.obstacles.primitive_kernels import (
    WIDTH,
    Core,
    Point,
    apart,
    axes_of,
    core_of,
    distance,
    in_body,
    in_world,
    level,
)

_STEPS = 100  # far more than it takes to find a lowest point to the last bit
_STRIDE = 20
_ROUNDING = 4 * 2.0**-52


@register_jitable
def _lowest(core: Core, best: float, p: Point, d: Point) -> float:
    """Least signed distance along the segment from p to p + d, body frame; ``best`` if above.

    Tangents bound a convex function from below. The next place is where those at both ends of the
    bracket meet, in turn with its middle.
    """
    low, high = 0.0, 1.0
    at_low, gx, gy, gz = distance(core, p[0], p[1], p[2])
    fall = gx * d[0] + gy * d[1] + gz * d[2]
    best = min(best, at_low)
    if fall >= 0 or at_low + fall >= best:
        return best
    at_high, gx, gy, gz = distance(core, p[0] + d[0], p[1] + d[1], p[2] + d[2])
    rise = gx * d[0] + gy * d[1] + gz * d[2]
    best = min(best, at_high)
    if rise <= 0:
        return best
    size = abs(p[0]) + abs(p[1]) + abs(p[2]) + abs(d[0]) + abs(d[1]) + abs(d[2])
    pad = _ROUNDING * (size + core[0] + core[1] + core[2] + core[3])
    for step in range(_STEPS):
        t = (at_low - at_high + rise * high - fall * low) / (rise - fall)
        if at_low + fall * (t - low) >= best - pad:
            break
        if step % 2 == 1 or not low < t < high:
            t = (low + high) / 2
            if not low < t < high:
                break
        away, gx, gy, gz = distance(core, p[0] + t * d[0], p[1] + t * d[1], p[2] + t * d[2])
        slope = gx * d[0] + gy * d[1] + gz * d[2]
        best = min(best, away)
        if slope < 0:
            low, at_low, fall = t, away, slope
        elif slope > 0:
            high, at_high, rise = t, away, slope
        else:
            break
    return best


@register_jitable
def _along(solids: FloatArray, s: int, best: float, a: Point, b: Point) -> float:
    """Least signed distance from the segment a..b, world, to a solid; ``best`` if above."""
    if apart(solids, s, best, a[0], a[1], a[2], b[0], b[1], b[2]):
        return best
    k = WIDTH * s
    axes = axes_of(solids, s)
    p = in_body(axes, a[0] - solids[k], a[1] - solids[k + 1], a[2] - solids[k + 2])
    d = in_body(axes, b[0] - a[0], b[1] - a[1], b[2] - a[2])
    return _lowest(core_of(solids, s), best, p, d)


@compiled(example=(FLOATS, 2, FLOATS, NEW_FLOATS))
def polylines(points: FloatArray, size: int, solids: FloatArray, found: FloatArray) -> None:
    """Least signed distances from polylines to all solids.

    Args:
        points: of one polyline after the other, flat (3 n size,), [unit], world.
        size: points of each polyline, at least 2.
        solids: rows (k WIDTH,).
        found: of each polyline (n,), [unit], inf without solids; written.
    """
    for run in range(len(found)):
        best = math.inf
        for s in range(len(solids) // WIDTH):
            for i in range(3 * run * size, 3 * (run * size + size - 1), 3):
                a = (points[i], points[i + 1], points[i + 2])
                b = (points[i + 3], points[i + 4], points[i + 5])
                best = _along(solids, s, best, a, b)
        found[run] = best


@compiled(example=(FLOATS, 2, FLOATS))
def skeletons(points: FloatArray, size: int, solids: FloatArray) -> tuple[float, int, int]:
    """Least signed distance from polylines to all solids; of which polyline, and to which solid.

    Args:
        points: of one polyline after the other, flat (3 n size,), [unit], world.
        size: points of each polyline, at least 2.
        solids: rows (k WIDTH,), k >= 1.
    """
    best, which, whose = math.inf, 0, -1
    # A few first: what they come to leaves little to look for in the others.
    for stride in (_STRIDE, 1):
        for run in range(0, len(points) // (3 * size), stride):
            for i in range(3 * run * size, 3 * (run * size + size - 1), 3):
                a = (points[i], points[i + 1], points[i + 2])
                b = (points[i + 3], points[i + 4], points[i + 5])
                for s in range(len(solids) // WIDTH):
                    found = _along(solids, s, best, a, b)
                    if found < best:
                        best, which, whose = found, run, s
    return best, which, whose


@compiled(example=(FLOATS, FLOATS, NEW_FLOATS, NEW_FLOATS))
def nearest(
    points: FloatArray,
    solids: FloatArray,
    away: FloatArray,
    outward: FloatArray,
) -> None:
    """Signed distances of points to the nearest solid, and the way out of it.

    Args:
        points: flat (3 n,), [unit], world.
        solids: rows (k WIDTH,).
        away: least distance (n,), inf without solids; written.
        outward: unit subgradients of that distance, flat (3 n,), world; written.
    """
    for i in range(len(away)):
        best, chosen = math.inf, -1
        x, y, z = points[3 * i], points[3 * i + 1], points[3 * i + 2]
        for s in range(len(solids) // WIDTH):
            if apart(solids, s, best, x, y, z, x, y, z):
                continue
            k = WIDTH * s
            p = in_body(axes_of(solids, s), x - solids[k], y - solids[k + 1], z - solids[k + 2])
            found = level(core_of(solids, s), p[0], p[1], p[2])
            if found < best:
                best, chosen = found, s
        away[i] = best
        if chosen >= 0:
            k = WIDTH * chosen
            axes = axes_of(solids, chosen)
            p = in_body(axes, x - solids[k], y - solids[k + 1], z - solids[k + 2])
            _, gx, gy, gz = distance(core_of(solids, chosen), p[0], p[1], p[2])
            way = in_world(axes, gx, gy, gz)
            outward[3 * i], outward[3 * i + 1], outward[3 * i + 2] = way


@compiled(example=(FLOATS, FLOATS, NEW_FLOATS))
def levels(points: FloatArray, solids: FloatArray, found: FloatArray) -> None:
    """Signed distance of each point to each solid.

    Args:
        points: flat (3 n,), [unit], world.
        solids: rows (k WIDTH,).
        found: (n k,), [unit], the solids of the first point first; written.
    """
    count = len(solids) // WIDTH
    for i in range(len(points) // 3):
        x, y, z = points[3 * i], points[3 * i + 1], points[3 * i + 2]
        for s in range(count):
            k = WIDTH * s
            axes = axes_of(solids, s)
            p = in_body(axes, x - solids[k], y - solids[k + 1], z - solids[k + 2])
            found[i * count + s] = level(core_of(solids, s), p[0], p[1], p[2])
