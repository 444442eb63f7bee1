"""Distances of polylines and points to convex primitives.

For the rows of numbers that describe primitives see ``primitive_kernels``. A point is three
successive numbers.
"""

from __future__ import annotations

import math

from numba.extending import register_jitable

from abi.arrays import FloatArray
from abi.compiled import FLOATS, NEW_FLOATS, compiled
from abi.obstacles.primitive_kernels import (
    WIDTH,
    Core,
    axes_of,
    bounds_apart,
    centre_of,
    core_of,
    in_body,
    in_world,
    signed_distance,
    signed_distance_gradient,
)
from abi.obstacles.vector_kernels import Vec3, add, axpy, dot, sub, vec3_at

_STEPS = 100  # far more than it takes to find a lowest point to the last bit
_STRIDE = 20
_ROUNDING = 4 * 2.0**-52


@register_jitable
def _least_along(core: Core, best: float, p: Vec3, d: Vec3) -> float:
    """Least signed distance along the segment from p to p + d, body frame; ``best`` if above.

    Tangents bound a convex function from below. The next place is where those at both ends of the
    bracket meet, in turn with its middle.
    """
    low, high = 0.0, 1.0
    at_low, outward = signed_distance_gradient(core, p)
    fall = dot(outward, d)
    best = min(best, at_low)
    if fall >= 0 or at_low + fall >= best:
        return best
    at_high, outward = signed_distance_gradient(core, add(p, d))
    rise = dot(outward, d)
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
        away, outward = signed_distance_gradient(core, axpy(t, d, p))
        slope = dot(outward, d)
        best = min(best, away)
        if slope < 0:
            low, at_low, fall = t, away, slope
        elif slope > 0:
            high, at_high, rise = t, away, slope
        else:
            break
    return best


@register_jitable
def _to_segment(primitives: FloatArray, s: int, best: float, a: Vec3, b: Vec3) -> float:
    """Least signed distance from the segment a..b, world, to primitive s; ``best`` if above."""
    if bounds_apart(primitives, s, best, a, b):
        return best
    axes = axes_of(primitives, s)
    p = in_body(axes, sub(a, centre_of(primitives, s)))
    return _least_along(core_of(primitives, s), best, p, in_body(axes, sub(b, a)))


@compiled(example=(FLOATS, 2, FLOATS, NEW_FLOATS))
def polyline_distances(
    points: FloatArray, size: int, primitives: FloatArray, found: FloatArray
) -> None:
    """Least signed distances from polylines to all primitives.

    Args:
        points: of one polyline after the other, flat (3 n size,), [unit], world.
        size: points of each polyline, at least 2.
        primitives: rows (k WIDTH,).
        found: of each polyline (n,), [unit], inf without primitives; written.
    """
    for run in range(len(found)):
        best = math.inf
        for s in range(len(primitives) // WIDTH):
            for i in range(3 * run * size, 3 * (run * size + size - 1), 3):
                a, b = vec3_at(points, i), vec3_at(points, i + 3)
                best = _to_segment(primitives, s, best, a, b)
        found[run] = best


@compiled(example=(FLOATS, 2, FLOATS))
def nearest_polyline(
    points: FloatArray, size: int, primitives: FloatArray
) -> tuple[float, int, int]:
    """Least signed distance from polylines to primitives, of which polyline, and to which of them.

    Args:
        points: of one polyline after the other, flat (3 n size,), [unit], world.
        size: points of each polyline, at least 2.
        primitives: rows (k WIDTH,), k >= 1.
    """
    best, which, whose = math.inf, 0, -1
    # A few first: what they come to leaves little to look for in the others.
    for stride in (_STRIDE, 1):
        for run in range(0, len(points) // (3 * size), stride):
            for i in range(3 * run * size, 3 * (run * size + size - 1), 3):
                a, b = vec3_at(points, i), vec3_at(points, i + 3)
                for s in range(len(primitives) // WIDTH):
                    found = _to_segment(primitives, s, best, a, b)
                    if found < best:
                        best, which, whose = found, run, s
    return best, which, whose


@compiled(example=(FLOATS, FLOATS, NEW_FLOATS, NEW_FLOATS))
def nearest(
    points: FloatArray,
    primitives: FloatArray,
    away: FloatArray,
    outward: FloatArray,
) -> None:
    """Signed distances of points to the nearest primitive, and the way out of it.

    Args:
        points: flat (3 n,), [unit], world.
        primitives: rows (k WIDTH,).
        away: least distance (n,), inf without primitives; written.
        outward: unit subgradients of that distance, flat (3 n,), world; written.
    """
    for i in range(len(away)):
        best, chosen = math.inf, -1
        x = vec3_at(points, 3 * i)
        for s in range(len(primitives) // WIDTH):
            if bounds_apart(primitives, s, best, x, x):
                continue
            p = in_body(axes_of(primitives, s), sub(x, centre_of(primitives, s)))
            found = signed_distance(core_of(primitives, s), p)
            if found < best:
                best, chosen = found, s
        away[i] = best
        if chosen >= 0:
            axes = axes_of(primitives, chosen)
            p = in_body(axes, sub(x, centre_of(primitives, chosen)))
            way = in_world(axes, signed_distance_gradient(core_of(primitives, chosen), p)[1])
            outward[3 * i], outward[3 * i + 1], outward[3 * i + 2] = way


@compiled(example=(FLOATS, FLOATS, NEW_FLOATS))
def signed_distances(points: FloatArray, primitives: FloatArray, found: FloatArray) -> None:
    """Signed distance of each point to each primitive.

    Args:
        points: flat (3 n,), [unit], world.
        primitives: rows (k WIDTH,).
        found: (n k,), [unit], the primitives of the first point first; written.
    """
    count = len(primitives) // WIDTH
    for i in range(len(points) // 3):
        x = vec3_at(points, 3 * i)
        for s in range(count):
            p = in_body(axes_of(primitives, s), sub(x, centre_of(primitives, s)))
            found[i * count + s] = signed_distance(core_of(primitives, s), p)
