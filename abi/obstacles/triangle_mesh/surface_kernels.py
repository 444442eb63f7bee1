"""Signed distances of points and segments to a surface that is placed in the world.

Queries in the world are answered in the surface's body frame, which is centred on its bounding box
and in the unit of its file. Bounds from the grid answer most of them, the tree the others.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.compiled import FLOATS, NEW_FLAGS, NEW_FLOATS, compiled
from abi.obstacles.primitive_kernels import Axes, in_body, in_world
from abi.obstacles.triangle_mesh.bvh import NO_DIPOLES, NO_TREE, Dipoles, TriangleTree
from abi.obstacles.triangle_mesh.closest_point_kernels import DEPTH, nearest_triangle
from abi.obstacles.triangle_mesh.distance_grid_kernels import (
    NO_GRID,
    DistanceGrid,
    distance_bounds,
    side_of,
    steepest,
)
from abi.obstacles.triangle_mesh.segment_kernels import (
    comes_near,
    near_triangle,
    segment_distance,
    towards_nearest,
)
from abi.obstacles.triangle_mesh.triangle_kernels import (
    closest_point,
    segment_to_triangle,
    triangle_at,
)
from abi.obstacles.triangle_mesh.winding_kernels import is_inside
from abi.obstacles.vector_kernels import Vec3, axpy, cross, distance, norm, sub, vec3_at

SAMPLES = 32
"""Parts into which a segment that enters a solid is cut to bound its depth."""

_PARALLEL = 1e-8
"""Part of a segment's length: error of its distance to a nearly parallel edge."""

_TOUCHING = 1e-12
"""Part of the surface's size that counts as touching it."""

_BETWEEN = 1e-9
"""Part of the surface's size and a step of its grid: what is nearer to the way between two points
may be between them."""

_IN_DOUBT = 1e-14
"""Part of the surface's size: nearer points may be on either side, by rounding."""


class SurfaceTables(NamedTuple):
    """A surface as the kernels take it, in its body frame.

    Attributes:
        tree: over its triangles.
        dipoles: of the nodes of the tree.
        grid: signed distances around it.
        closed: whether it has an inside.
        extent: longest side of its bounding box.
        error: bound of the error of a point's distance where that is 0, and of what it grows by
            with the distance.
    """

    tree: TriangleTree
    dipoles: Dipoles
    grid: DistanceGrid
    closed: bool
    extent: float
    error: tuple[float, float]


class Placement(NamedTuple):
    """Where the body frame is in the world.

    Attributes:
        origin: its origin, [unit], world.
        axes: its axes, in the world.
        factor: scene's [unit] per unit of the body frame.
    """

    origin: Vec3
    axes: Axes
    factor: float


class Room(NamedTuple):
    """Room for descents of a tree.

    Attributes:
        waiting: (``DEPTH``,) nodes.
        squares: (``DEPTH``,) their squared distances.
        stack: (128,) nodes of a tree of dipoles.
        latest: (1,) place of the triangle that the last segment was too near to, or -1: the next
            one, beside it, often is, too.
        nearest: (1,) place of the triangle that the last point was nearest to, or -1.
        samples: (``SAMPLES`` + 1,) signed distances along a segment, or bounds of them from below.
        known: (``SAMPLES`` + 1,) which are no bounds.
    """

    waiting: IntArray
    squares: FloatArray
    stack: IntArray
    latest: IntArray
    nearest: IntArray
    samples: FloatArray
    known: BoolArray


NO_TABLES = SurfaceTables(NO_TREE, NO_DIPOLES, NO_GRID, True, 1.0, (0.0, 0.0))
"""In an example: a surface."""

NO_PLACEMENT = Placement((0.0, 0.0, 0.0), ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), 1.0)
"""In an example: a placement."""


@register_jitable
def new_room() -> Room:
    """Room for descents."""
    waiting, stack = np.empty(DEPTH, np.int32), np.empty(128, np.int32)
    latest, nearest = np.full(1, -1, np.int32), np.full(1, -1, np.int32)
    samples, known = np.empty(SAMPLES + 1), np.zeros(SAMPLES + 1, np.bool_)
    return Room(waiting, np.empty(DEPTH), stack, latest, nearest, samples, known)


@register_jitable
def to_surface(placement: Placement, p: Vec3) -> Vec3:
    """A point of the world in the body frame."""
    x, y, z = in_body(placement.axes, sub(p, placement.origin))
    return x / placement.factor, y / placement.factor, z / placement.factor


@register_jitable
def _is_inside(tables: SurfaceTables, x: Vec3, room: Room) -> bool:
    """Whether a point of the body frame, near a closed surface, is inside."""
    side = side_of(tables.grid, tables.tree, x, room.waiting)
    return side == 1 if side >= 0 else is_inside(tables.tree, tables.dipoles, x, room.stack)


@register_jitable
def signed_distance_at(tables: SurfaceTables, x: Vec3, room: Room) -> tuple[float, int]:
    """Signed distance of a point in the body frame, or less by rounding; and the nearest triangle.

    The triangle is its place in the tree.
    """
    return _signed_distance_beside(tables, x, 0.0, x, math.inf, room)


@register_jitable
def _signed_distance_beside(
    tables: SurfaceTables, x: Vec3, beside: float, other: Vec3, apart: float, room: Room
) -> tuple[float, int]:
    """As :func:`signed_distance_at`, given that of another point.

    They are on one side where balls around both that nothing is in overlap, or where nothing is
    between them, which costs less to see than to find out anew.

    Args:
        tables: the surface.
        x: the point.
        beside: signed distance of the other, as it is returned; 0 where it is not known.
        other: the other point.
        apart: the distance of both.
        room: for descents.
    """
    tree, _, grid, closed, extent, error = tables
    lower, upper = distance_bounds(grid, x)
    most = min(max(-lower, upper), abs(beside) * (1.0 + error[1]) + error[0] + apart)
    most = most * (1.0 + 1e-9) + _TOUCHING * extent
    # it may be of another surface, but is a triangle of this one all the same
    guess = room.nearest[0] if room.nearest[0] < len(tree.corners) // 9 else -1
    away, number = nearest_triangle(tree, x, most, 0.0, room.waiting, room.squares, guess)
    room.nearest[0] = number
    doubt = error[0] + error[1] * away
    if not closed:
        return max(away - doubt, 0.0), number
    inside = upper < 0.0
    if lower <= 0.0 <= upper:
        if away - doubt <= _IN_DOUBT * extent:
            inside = True
        else:
            free = abs(beside) - 2.0 * (error[0] + error[1] * abs(beside))
            touching = _BETWEEN * (grid.step + tree.size)
            if free > 0.0 and (
                free + away - doubt > apart * (1.0 + 1e-9)
                or not comes_near(tree, other, x, touching, (0.0, 0.0, 0.0), room.waiting)
            ):
                inside = beside < 0.0
            else:
                inside = _is_inside(tables, x, room)
    return (-away if inside else away) - doubt, number


@register_jitable
def gradient_at(tables: SurfaceTables, x: Vec3, room: Room) -> tuple[float, Vec3]:
    """Signed distance of a point in the body frame, and its gradient, a unit vector.

    That leads away from the closest point, towards it inside a solid; on the surface itself it is
    the normal of a triangle there.
    """
    away, number = signed_distance_at(tables, x, room)
    a, b, c = triangle = triangle_at(tables.tree.corners, number)
    offset = sub(x, closest_point(x, triangle))
    size = norm(offset)
    if size <= _TOUCHING * tables.extent:
        offset = cross(sub(b, a), sub(c, a))
        size = norm(offset)
    elif tables.closed and away + tables.error[0] + tables.error[1] * size < 0.0:
        size = -size
    return away, (offset[0] / size, offset[1] / size, offset[2] / size)


@register_jitable
def distance_along(tables: SurfaceTables, p: Vec3, q: Vec3, most: float, room: Room) -> float:
    """Distance of a segment of the body frame to the surface; ``most`` where that is less.

    0 where some of it is seen to be inside. Walks along the segment as far as the grid's bounds
    leave nothing nearer (Hart, Sphere tracing, 1996). In the stretch where they leave something the
    nearest triangle is looked for, from the place that seems nearest.
    """
    tree, grid = tables.tree, tables.grid
    d = sub(q, p)
    length = norm(d)
    inverse = 1.0 / length if length > 0.0 else 0.0
    lower, upper = distance_bounds(grid, axpy(0.5, d, p))
    if upper < 0.0 and tables.closed:
        return 0.0
    pad = _TOUCHING * tables.extent
    best = min(most, max(-lower, upper) * (1.0 + 1e-9) + pad)
    nearest, there = max(lower, -upper), length / 2
    first, last, at = length, -1.0, 0.0
    while at <= length:
        lower, upper = distance_bounds(grid, axpy(at * inverse, d, p))
        if upper < 0.0 and tables.closed:
            return 0.0
        least = max(lower, -upper)
        best = min(best, max(-lower, upper) * (1.0 + 1e-9) + pad)
        if least < nearest:
            nearest, there = least, at
        far = least - best
        if far < grid.step / 2:
            far = min(grid.step, length - at)
            first, last = min(first, at), at + far
        if at + far >= length:
            break
        at += far
    if last < 0.0:
        return best
    best, normal = towards_nearest(tree, (p, q), there * inverse, best, room.waiting, room.squares)
    x, y = axpy(first * inverse, d, p), axpy(last * inverse, d, p)
    return segment_distance(tree, x, y, best, normal, room.waiting)


@register_jitable
def least_distance(tables: SurfaceTables, p: Vec3, q: Vec3, most: float, room: Room) -> float:
    """Least signed distance along a segment of the body frame; ``most`` where that is less.

    Below 0 it is a lower bound. Between two samples s and t at a distance l, the signed distance is
    at least (s + t - l) / 2 and the least at most s and t: so it is off by at most 1/64 of the
    length.
    """
    # whether it touches counts whatever the most is
    away = distance_along(tables, p, q, max(most, _TOUCHING * tables.extent), room)
    if not tables.closed or (away > 0.0 and not _inside(tables, p, room)):
        return min(away, most)
    d = sub(q, p)
    step = norm(d) / SAMPLES
    samples, known = room.samples, room.known
    for k in range(SAMPLES + 1):
        samples[k], known[k] = distance_bounds(tables.grid, axpy(k / SAMPLES, d, p))[0], False
    least = most
    while True:
        first, lowest = -1, least
        for k in range(SAMPLES):
            bound = (samples[k] + samples[k + 1] - step) / 2
            if bound < lowest:
                first, lowest = k, bound
        if first < 0:
            return least
        # the lower of the two that is not known
        k = first + 1 if samples[first + 1] < samples[first] else first
        k = 2 * first + 1 - k if known[k] else k
        _take_sample(tables, (p, d), k, step, room)
        if known[first] and known[first + 1]:
            least = min(least, (samples[first] + samples[first + 1] - step) / 2)


@register_jitable
def _take_sample(
    tables: SurfaceTables, way: tuple[Vec3, Vec3], k: int, step: float, room: Room
) -> None:
    """Find a sample's signed distance, which bounds the others: it is 1-Lipschitz.

    Args:
        tables: the surface.
        way: first end of a segment and its second end less that.
        k: number of the sample.
        step: between samples.
        room: see ``Room``; the sample and the bounds are written.
    """
    samples, known = room.samples, room.known
    p, d = way
    x = axpy(k / SAMPLES, d, p)
    other = k - 1 if k > 0 and known[k - 1] else k + 1
    if other <= SAMPLES and known[other]:
        beside = samples[other]
        here, _ = _signed_distance_beside(
            tables, x, beside, axpy(other / SAMPLES, d, p), step, room
        )
    else:
        here, _ = signed_distance_at(tables, x, room)
    samples[k], known[k] = here, True
    for i in range(SAMPLES + 1):
        if not known[i]:
            samples[i] = max(samples[i], here - abs(i - k) * step)


@register_jitable
def _inside(tables: SurfaceTables, x: Vec3, room: Room) -> bool:
    """Whether a point of the body frame is inside a closed surface."""
    lower, upper = distance_bounds(tables.grid, x)
    if lower > 0.0 or upper < 0.0:
        return upper < 0.0
    return _is_inside(tables, x, room)


@register_jitable
def limit_of(tables: SurfaceTables, margin: float, length: float) -> float:
    """Distance at which a segment of some length counts as nearer than a margin, by rounding."""
    return max(margin, _TOUCHING * tables.extent) + _PARALLEL * length


@register_jitable
def is_blocked(tables: SurfaceTables, p: Vec3, q: Vec3, margin: float, room: Room) -> bool:
    """Whether a segment of the body frame comes nearer to the surface than a margin, or touches it.

    Walks along the segment as far as the grid's bounds allow at each place (Hart, Sphere tracing,
    1996). The stretch in which they allow less than half a step of the grid is tested against the
    triangles.
    """
    tree, _, grid, closed, _, _ = tables
    length = distance(p, q)
    limit = limit_of(tables, margin, length)
    # it may be of another surface, but is a triangle of this one all the same
    latest = room.latest[0]
    if 0 <= latest < len(tree.corners) // 9:
        triangle = triangle_at(tree.corners, latest)
        if segment_to_triangle(p, q, triangle) <= limit * limit:
            return True
    d = sub(q, p)
    inverse = 1.0 / length if length > 0.0 else 0.0
    at, outside = 0.0, not closed
    first, last, nearest, there = length, -1.0, math.inf, 0.0
    while at <= length:
        lower, upper = distance_bounds(grid, axpy(at * inverse, d, p))
        if upper < margin:
            return True
        outside = outside or lower > 0.0
        far = lower - limit
        if far < grid.step / 2:
            if lower < nearest:
                nearest, there = lower, at
            far = min(grid.step, length - at)
            first, last = min(first, at), at + far
        if at + far >= length:
            break
        at += far
    if last >= 0.0:
        normal = steepest(grid, axpy(there * inverse, d, p))
        x, y = axpy(first * inverse, d, p), axpy(last * inverse, d, p)
        found = near_triangle(tree, x, y, limit, normal, room.waiting)
        if found >= 0:
            room.latest[0] = found
            return True
    # a segment that nothing touches is inside or outside as a whole
    return not outside and _is_inside(tables, p, room)


@compiled(example=(NO_TABLES, NO_PLACEMENT, FLOATS, NEW_FLOATS), fallback=False)
def signed_distances(
    tables: SurfaceTables, placement: Placement, points: FloatArray, distances: FloatArray
) -> None:
    """Signed distances (n,) of points (3 n,), [unit], world; written."""
    room = new_room()
    for i in range(len(points) // 3):
        x = to_surface(placement, vec3_at(points, 3 * i))
        away, _ = signed_distance_at(tables, x, room)
        distances[i] = away * placement.factor


@compiled(example=(NO_TABLES, NO_PLACEMENT, FLOATS, NEW_FLOATS, NEW_FLOATS), fallback=False)
def signed_distance_gradients(
    tables: SurfaceTables,
    placement: Placement,
    points: FloatArray,
    distances: FloatArray,
    gradients: FloatArray,
) -> None:
    """Signed distances (n,) of points (3 n,), [unit], world, and gradients (3 n,); written."""
    room = new_room()
    for i in range(len(points) // 3):
        x = to_surface(placement, vec3_at(points, 3 * i))
        away, gradient = gradient_at(tables, x, room)
        distances[i] = away * placement.factor
        gradient = in_world(placement.axes, gradient)
        for k in range(3):
            gradients[3 * i + k] = gradient[k]


@compiled(example=(NO_TABLES, NO_PLACEMENT, FLOATS, FLOATS, NEW_FLOATS), fallback=False)
def least_distances(
    tables: SurfaceTables,
    placement: Placement,
    starts: FloatArray,
    ends: FloatArray,
    distances: FloatArray,
) -> None:
    """Least signed distances (n,) along segments (3 n,), [unit], world, where less; written."""
    room = new_room()
    factor = placement.factor
    for i in range(len(distances)):
        p = to_surface(placement, vec3_at(starts, 3 * i))
        q = to_surface(placement, vec3_at(ends, 3 * i))
        distances[i] = least_distance(tables, p, q, distances[i] / factor, room) * factor


@compiled(example=(NO_TABLES, NO_PLACEMENT, FLOATS, FLOATS, 1, 0.0), fallback=False)
def nearest_segment(
    tables: SurfaceTables,
    placement: Placement,
    starts: FloatArray,
    ends: FloatArray,
    legs: int,
    most: float,
) -> tuple[float, int]:
    """Least signed distance of all segments (3 n,), [unit], world, and the number of the nearest.

    ``most`` and -1 where none is nearer. A segment that is where the one ``legs`` before it is, as
    a link of an arm that stands still, is passed over.
    """
    room = new_room()
    count = len(starts) // 3
    bounds = np.empty(count)
    nearest, found = most / placement.factor, -1
    limit = nearest
    for i in range(count):
        a, b = vec3_at(starts, 3 * i), vec3_at(ends, 3 * i)
        k = 3 * (i - legs)
        if k >= 0 and a == vec3_at(starts, k) and b == vec3_at(ends, k):
            bounds[i] = math.inf
            continue
        p, q = to_surface(placement, a), to_surface(placement, b)
        lower, upper = distance_bounds(tables.grid, axpy(0.5, sub(q, p), p))
        bounds[i] = lower - distance(p, q) / 2
        limit = min(limit, upper)
    limit += _TOUCHING * tables.extent
    for i in range(count):
        # how deep a segment is inside is a bound from below: each that may be inside counts
        if bounds[i] > max(min(limit, nearest), 0.0):
            continue
        p = to_surface(placement, vec3_at(starts, 3 * i))
        q = to_surface(placement, vec3_at(ends, 3 * i))
        away = least_distance(tables, p, q, nearest, room)
        if away < nearest:
            nearest, found = away, i
    return (nearest * placement.factor if found >= 0 else most), found


@compiled(example=(NO_TABLES, NO_PLACEMENT, FLOATS, FLOATS, FLOATS, NEW_FLAGS), fallback=False)
def blocked_segments(
    tables: SurfaceTables,
    placement: Placement,
    starts: FloatArray,
    ends: FloatArray,
    margins: FloatArray,
    blocked: BoolArray,
) -> None:
    """Flags (n,) of the segments (3 n,) nearer than margins (n,), [unit], world; written."""
    room = new_room()
    for i in range(len(starts) // 3):
        p = to_surface(placement, vec3_at(starts, 3 * i))
        q = to_surface(placement, vec3_at(ends, 3 * i))
        blocked[i] = is_blocked(tables, p, q, margins[i] / placement.factor, room)


@compiled(example=(NO_TABLES, NO_PLACEMENT, FLOATS, NEW_FLOATS, NEW_FLOATS), fallback=False)
def bounds_of_distances(
    tables: SurfaceTables,
    placement: Placement,
    points: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
) -> None:
    """Bounds (n,) of the signed distances of points (3 n,), [unit], world; written."""
    for i in range(len(points) // 3):
        least, most = distance_bounds(tables.grid, to_surface(placement, vec3_at(points, 3 * i)))
        lower[i], upper[i] = least * placement.factor, most * placement.factor
