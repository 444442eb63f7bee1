"""Distances of polylines and points to convex primitives.

For the rows of primitives see ``primitive_kernels``. A point is three
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

_STEPS = 100  # far more than it takes to find a minimum to the last bit
_STRIDE = 20
_ROUNDING = 4 * 2.0**-52


@register_jitable
def _least_distance(core: Core, best: float, p: Vec3, d: Vec3) -> float:
    """Least signed distance along the segment from p to p + d, body frame; ``best`` if above.

    Tangents bound a convex function from below. The next place is where those at both ends of the
    bracket meet, in turn with its middle.
    """
    low, high = 0.0, 1.0
    at_low, gradient = signed_distance_gradient(core, p)
    fall = dot(gradient, d)
    best = min(best, at_low)
    if fall >= 0 or at_low + fall >= best:
        return best
    at_high, gradient = signed_distance_gradient(core, add(p, d))
    rise = dot(gradient, d)
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
        distance, gradient = signed_distance_gradient(core, axpy(t, d, p))
        slope = dot(gradient, d)
        best = min(best, distance)
        if slope < 0:
            low, at_low, fall = t, distance, slope
        elif slope > 0:
            high, at_high, rise = t, distance, slope
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
    return _least_distance(core_of(primitives, s), best, p, in_body(axes, sub(b, a)))


@register_jitable(forceinline=True)
def nearest_primitive(primitives: FloatArray, enough: float, x: Vec3) -> tuple[float, int]:
    """Least signed distance of a point and whose it is; ``enough`` and -1 if it is not below."""
    best, whose = enough, -1
    for s in range(len(primitives) // WIDTH):
        if not bounds_apart(primitives, s, best, x, x):
            p = in_body(axes_of(primitives, s), sub(x, centre_of(primitives, s)))
            distance = signed_distance(core_of(primitives, s), p)
            if distance < best:
                best, whose = distance, s
    return best, whose


@register_jitable(forceinline=True)
def distance_gradient(primitives: FloatArray, s: int, x: Vec3) -> tuple[float, Vec3]:
    """Signed distance of a point to primitive s, and a unit subgradient of it, world."""
    axes = axes_of(primitives, s)
    p = in_body(axes, sub(x, centre_of(primitives, s)))
    distance, gradient = signed_distance_gradient(core_of(primitives, s), p)
    return distance, in_world(axes, gradient)


@compiled(example=(FLOATS, 2, FLOATS, NEW_FLOATS))
def polyline_distances(
    points: FloatArray, size: int, primitives: FloatArray, distances: FloatArray
) -> None:
    """Least signed distances from polylines to all primitives.

    Args:
        points: of one polyline after the other, flat (3 n size,), [unit], world.
        size: points of each polyline, at least 2.
        primitives: rows (k WIDTH,).
        distances: of each polyline (n,), [unit], inf without primitives; written.
    """
    for run in range(len(distances)):
        best = math.inf
        for s in range(len(primitives) // WIDTH):
            for i in range(3 * run * size, 3 * (run * size + size - 1), 3):
                a, b = vec3_at(points, i), vec3_at(points, i + 3)
                best = _to_segment(primitives, s, best, a, b)
        distances[run] = best


@compiled(example=(FLOATS, 2, FLOATS))
def nearest_polyline(
    points: FloatArray, size: int, primitives: FloatArray
) -> tuple[float, int, int]:
    """Least signed distance from polylines to primitives, and between which of them it is.

    Args:
        points: of one polyline after the other, flat (3 n size,), [unit], world.
        size: points of each polyline, at least 2.
        primitives: rows (k WIDTH,), k >= 1.
    """
    best, which, whose = math.inf, 0, -1
    # A few first: their least distance rules out most of the others.
    for stride in (_STRIDE, 1):
        for run in range(0, len(points) // (3 * size), stride):
            for i in range(3 * run * size, 3 * (run * size + size - 1), 3):
                a, b = vec3_at(points, i), vec3_at(points, i + 3)
                for s in range(len(primitives) // WIDTH):
                    distance = _to_segment(primitives, s, best, a, b)
                    if distance < best:
                        best, which, whose = distance, run, s
    return best, which, whose


@compiled(example=(FLOATS, FLOATS, NEW_FLOATS, NEW_FLOATS))
def nearest(
    points: FloatArray, primitives: FloatArray, distances: FloatArray, gradients: FloatArray
) -> None:
    """Signed distances of points to the nearest primitive, and their gradients.

    Args:
        points: flat (3 n,), [unit], world.
        primitives: rows (k WIDTH,).
        distances: (n,), [unit], inf without primitives; written.
        gradients: unit subgradients of the distances, flat (3 n,), world; written.
    """
    for i in range(len(distances)):
        x = vec3_at(points, 3 * i)
        distances[i], whose = nearest_primitive(primitives, math.inf, x)
        if whose >= 0:
            gradient = distance_gradient(primitives, whose, x)[1]
            gradients[3 * i], gradients[3 * i + 1], gradients[3 * i + 2] = gradient


@compiled(example=(FLOATS, FLOATS, NEW_FLOATS))
def signed_distances(points: FloatArray, primitives: FloatArray, distances: FloatArray) -> None:
    """Signed distance of each point to each primitive.

    Args:
        points: flat (3 n,), [unit], world.
        primitives: rows (k WIDTH,).
        distances: (n k,), [unit], the primitives of the first point first; written.
    """
    count = len(primitives) // WIDTH
    for i in range(len(points) // 3):
        x = vec3_at(points, 3 * i)
        for s in range(count):
            p = in_body(axes_of(primitives, s), sub(x, centre_of(primitives, s)))
            distances[i * count + s] = signed_distance(core_of(primitives, s), p)
