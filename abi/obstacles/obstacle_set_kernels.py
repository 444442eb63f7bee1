"""Distances of points, segments and polylines to obstacles.

For the rows of primitives see ``primitive_kernels``. A point is three successive numbers.
"""

from __future__ import annotations

import math

import numpy as np

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.compilation.borrowed import borrowed, held
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, IDS, NEW_FLAGS, NEW_FLOATS, NEW_IDS, compiled
from abi.obstacles import primitive_distances
from abi.obstacles.primitive_kernels import (
    WIDTH,
    Core,
    axes_of,
    centre_of,
    core_of,
    distance_to,
    in_body,
    in_world,
    signed_distance_gradient,
)
from abi.obstacles.primitive_tree_kernels import (
    TREE,
    any_nearer,
    first_row,
    next_near,
    next_near_segment,
    row_after,
    row_below,
)
from abi.obstacles.triangle_mesh.surface_kernels import (
    NO_SURFACES,
    SurfaceSet,
    most_to_mesh,
    nearest_mesh_to_segment,
    widened,
)
from abi.obstacles.triangle_mesh.surface_tables_kernels import new_room
from abi.obstacles.vector_kernels import Vec3, add, axpy, dot, point_to_box, sub, vec3_at

_STEPS = 100  # far more than it takes to find a minimum to the last bit
_ROUNDING = 4 * 2.0**-52


@jitable
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
    pad = _ROUNDING * (size + core.x + core.y + core.z + core.radius)
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


@jitable
def distance_to_segment(primitives: FloatArray, s: int, best: float, a: Vec3, b: Vec3) -> float:
    """Least signed distance from the segment a..b, world, to primitive s; ``best`` if above."""
    axes = axes_of(primitives, s)
    p = in_body(axes, sub(a, centre_of(primitives, s)))
    return _least_distance(core_of(primitives, s), best, p, in_body(axes, sub(b, a)))


@jitable
def _likely_nearest(primitives: FloatArray, x: Vec3) -> int:
    """A primitive not far from a point: down the tree, each time to the nearer side."""
    s = first_row(primitives)
    best, whose = math.inf, s
    while True:
        distance = distance_to(primitives, s, x)
        if distance < best:
            best, whose = distance, s
        one, after = row_below(primitives, s), row_after(primitives, s)
        if one == after:
            return whose
        s, other = one, row_after(primitives, one)
        to_one = point_to_box(x, primitives, WIDTH * one + TREE)
        if other != after and point_to_box(x, primitives, WIDTH * other + TREE) < to_one:
            s = other


@jitable
def nearest_to_segment(
    primitives: FloatArray, enough: float, a: Vec3, b: Vec3
) -> tuple[float, int]:
    """Least signed distance of a segment and whose it is; ``enough`` and -1 if it is not below.

    Args:
        primitives: rows (k WIDTH,).
        enough: [unit].
        a: one end, [unit], world; it may be the other one, too.
        b: the other end.
    """
    best, whose = enough, -1
    if len(primitives) > 0 and enough == math.inf:
        whose = _likely_nearest(primitives, axpy(0.5, sub(b, a), a))
        best = distance_to_segment(primitives, whose, enough, a, b)
    s = next_near_segment(primitives, -1, best, a, b)
    while s >= 0:
        distance = distance_to_segment(primitives, s, best, a, b)
        if distance < best:
            best, whose = distance, s
        s = next_near_segment(primitives, s, best, a, b)
    return best, whose


@jitable
def nearest_primitive(primitives: FloatArray, enough: float, x: Vec3) -> tuple[float, int]:
    """Least signed distance of a point and whose it is; ``enough`` and -1 if it is not below.

    The first primitive counts on a tie.
    """
    best, whose = enough, -1
    if len(primitives) > 0 and enough == math.inf:
        whose = _likely_nearest(primitives, x)
        best = distance_to(primitives, whose, x)
    more = best + _ROUNDING * abs(best)  # with those that are as near
    s = next_near(primitives, -1, more, x, x)
    while s >= 0:
        distance = distance_to(primitives, s, x)
        if distance < best or (distance == best and s < whose):
            best, whose = distance, s
            more = best + _ROUNDING * abs(best)
        s = next_near(primitives, s, more, x, x)
    return best, whose


@jitable(forceinline=True)
def distance_gradient(primitives: FloatArray, s: int, x: Vec3) -> tuple[float, Vec3]:
    """Signed distance of a point to primitive s, and a unit subgradient of it, world."""
    axes = axes_of(primitives, s)
    p = in_body(axes, sub(x, centre_of(primitives, s)))
    distance, gradient = signed_distance_gradient(core_of(primitives, s), p)
    return distance, in_world(axes, gradient)


@compiled(example=(FLOATS, FLOATS, NEW_FLOATS, NEW_IDS), in_numpy=primitive_distances.nearest)
def nearest(
    points: FloatArray, primitives: FloatArray, distances: FloatArray, numbers: IntArray
) -> None:
    """Signed distances of points to the nearest primitive, and whose they are.

    Args:
        points: flat (3 n,), [unit], world.
        primitives: rows (k WIDTH,).
        distances: (n,), [unit], inf without primitives; written.
        numbers: rows of the nearest (n,), -1 without primitives; written.
    """
    for i in range(len(distances)):
        x = vec3_at(points, 3 * i)
        distances[i], numbers[i] = nearest_primitive(primitives, math.inf, x)


@compiled(example=(FLOATS, FLOATS, IDS, NEW_FLOATS))
def gradients(
    points: FloatArray, primitives: FloatArray, numbers: IntArray, found: FloatArray
) -> None:
    """Gradients of the signed distances of points, each to one primitive.

    Args:
        points: flat (3 n,), [unit], world.
        primitives: rows (k WIDTH,).
        numbers: rows of the primitives (n,); nothing is written where they are negative.
        found: unit subgradients, flat (3 n,), world; written.
    """
    for i in range(len(numbers)):
        if numbers[i] >= 0:
            gradient = distance_gradient(primitives, numbers[i], vec3_at(points, 3 * i))[1]
            found[3 * i], found[3 * i + 1], found[3 * i + 2] = gradient


@compiled(example=(FLOATS, FLOATS, FLOATS, FLOATS, NEW_FLAGS))
def blocked_segments(
    starts: FloatArray,
    ends: FloatArray,
    margins: FloatArray,
    primitives: FloatArray,
    found: BoolArray,
) -> None:
    """Flags of the segments that come nearer to a primitive than their margins.

    Args:
        starts, ends: flat (3 n,), [unit], world.
        margins: (n,), [unit].
        primitives: rows (k WIDTH,).
        found: (n,); written.
    """
    for i in range(len(margins)):
        a, b = vec3_at(starts, 3 * i), vec3_at(ends, 3 * i)
        found[i] = any_nearer(primitives, margins[i], a, b)


@compiled(example=(FLOATS, FLOATS, FLOATS, FLOATS))
def near_boxes(
    starts: FloatArray, ends: FloatArray, limits: FloatArray, boxes: FloatArray
) -> tuple[IntArray, IntArray]:
    """Pairs of a segment and a box that may be nearer to each other than the segment's limit.

    Args:
        starts, ends: flat (3 n,), [unit], world.
        limits: (n,), [unit].
        boxes: primitives parallel to the axes, rows (k WIDTH,).

    Returns:
        Segments and boxes of the pairs (m,); each box's pairs together, the segments in order.
    """
    segments, near = np.empty(64, np.int32), np.empty(64, np.int32)
    counts = np.zeros(len(boxes) // WIDTH + 1, np.int32)
    found = 0
    for i in range(len(limits)):
        a, b = vec3_at(starts, 3 * i), vec3_at(ends, 3 * i)
        s = next_near_segment(boxes, -1, limits[i], a, b)
        while s >= 0:
            if found == len(near):
                segments = np.concatenate((segments, np.empty_like(segments)))
                near = np.concatenate((near, np.empty_like(near)))
            segments[found], near[found] = i, s
            counts[s + 1] += 1
            found += 1
            s = next_near_segment(boxes, s, limits[i], a, b)
    for s in range(1, len(counts)):
        counts[s] += counts[s - 1]
    in_order, of_box = np.empty(found, np.int32), np.empty(found, np.int32)
    for k in range(found):
        at = counts[near[k]]
        in_order[at], of_box[at] = segments[k], near[k]
        counts[near[k]] += 1
    return in_order, of_box


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
            distances[i * count + s] = distance_to(primitives, s, x)


@jitable
def _from_primitives(
    primitives: FloatArray, enough: float, points: FloatArray, first: int, last: int
) -> float:
    """Least of ``enough`` and the signed distances of a polyline's segments to primitives."""
    best = enough
    for i in range(first, last, 3):
        a, b = vec3_at(points, i), vec3_at(points, i + 3)
        best = nearest_to_segment(primitives, best, a, b)[0]
    return best


@compiled(example=(FLOATS, 2, FLOATS, 1.0, NEW_FLOATS))
def polyline_distances(
    points: FloatArray, size: int, primitives: FloatArray, enough: float, distances: FloatArray
) -> None:
    """Least signed distances from polylines to primitives.

    Args:
        points: of one polyline after the other, flat (3 n size,), [unit], world.
        size: points of each polyline, at least 2.
        primitives: rows (k WIDTH,).
        enough: distances from here on, but for the least of all, may be any from here on, [unit].
        distances: of each polyline (n,), [unit], inf without obstacles; written.
    """
    least = math.inf
    for run in range(len(distances)):
        first, last = 3 * run * size, 3 * (run * size + size - 1)
        best = _from_primitives(primitives, max(enough, least), points, first, last)
        distances[run] = best
        least = min(least, best)


@compiled(example=(FLOATS, 2, FLOATS, NO_SURFACES, 1.0, NEW_FLOATS))
def polyline_distances_near_meshes(
    points: FloatArray,
    size: int,
    primitives: FloatArray,
    surfaces: SurfaceSet,
    enough: float,
    distances: FloatArray,
) -> None:
    """Least signed distances from polylines to primitives and meshes.

    Args:
        points, size, primitives, enough, distances: as for :func:`polyline_distances`.
        surfaces: the meshes, at least one.
    """
    own = new_room()
    room = borrowed(own)
    least = math.inf
    for run in range(len(distances)):
        first, last = 3 * run * size, 3 * (run * size + size - 1)
        best = most = _from_primitives(primitives, max(enough, least), points, first, last)
        for i in range(first, last + 3, 3):
            most = most_to_mesh(surfaces, most, vec3_at(points, i))
        most = widened(most)
        for i in range(first, last, 3):
            a, b = vec3_at(points, i), vec3_at(points, i + 3)
            most = nearest_mesh_to_segment(surfaces, most, a, b, room)[0]
        distances[run] = best = min(best, most)
        least = min(least, best)
    held(own)


@compiled(example=(FLOATS, FLOATS, 1.0))
def near_polyline(points: FloatArray, primitives: FloatArray, reach: float) -> FloatArray:
    """Signed distances of primitives to a polyline, inf where they are not below ``reach``.

    Args:
        points: flat (3 n,), n >= 2, [unit], world.
        primitives: rows (k WIDTH,).
        reach: [unit].

    Returns:
        Distances (k,), [unit].
    """
    distances = np.full(len(primitives) // WIDTH, math.inf)
    for i in range(0, len(points) - 3, 3):
        a, b = vec3_at(points, i), vec3_at(points, i + 3)
        s = next_near_segment(primitives, -1, reach, a, b)
        while s >= 0:
            most = min(reach, distances[s])
            distance = distance_to_segment(primitives, s, most, a, b)
            if distance < most:
                distances[s] = distance
            s = next_near_segment(primitives, s, reach, a, b)
    return distances
