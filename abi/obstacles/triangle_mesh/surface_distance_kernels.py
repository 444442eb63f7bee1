"""Signed distances of points to a surface, and distances along segments, in its body frame.

Bounds by the grid answer most questions, the tree the others.
"""

from __future__ import annotations

import math

from abi.compilation.jitable import jitable
from abi.obstacles.triangle_mesh.segment_kernels import (
    near_triangle,
    segment_distance,
    towards_nearest,
)
from abi.obstacles.triangle_mesh.surface_tables_kernels import (
    SAMPLES,
    TOUCHING,
    DescentWorkspace,
    SurfaceTables,
    distance_bounds,
    side_of,
)
from abi.obstacles.triangle_mesh.triangle_kernels import (
    closest_point,
    is_inside,
    nearest_triangle,
    point_to_triangle,
)
from abi.obstacles.vector_kernels import Vec3, axpy, cross, distance, norm, sub, triangle_at

_BETWEEN = 1e-9
"""Part of the surface's size and a step of its grid: what is nearer to the way between two points
may be between them."""

_IN_DOUBT = 1e-14
"""Part of the surface's size: nearer points may be on either side, by rounding."""


@jitable
def is_inside_near(tables: SurfaceTables, x: Vec3, room: DescentWorkspace) -> bool:
    """Check whether a point of the body frame, near a closed surface, is inside."""
    side = side_of(tables.grid, tables.tree, x, room.waiting)
    return side == 1 if side >= 0 else is_inside(tables.tree, tables.dipoles, x, room.stack)


@jitable
def is_inside_surface(tables: SurfaceTables, x: Vec3, room: DescentWorkspace) -> bool:
    """Check whether a point of the body frame is inside a closed surface."""
    lower, upper = distance_bounds(tables.grid, x)
    if lower > 0.0 or upper < 0.0:
        return upper < 0.0
    return is_inside_near(tables, x, room)


@jitable
def signed_distance_at(tables: SurfaceTables, x: Vec3, room: DescentWorkspace) -> tuple[float, int]:
    """Signed distance of a point in the body frame, or less by rounding; and the nearest triangle.

    The triangle is its place in the tree.
    """
    return signed_distance_beside(tables, x, math.inf, (0.0, x, math.inf), room)


@jitable
def signed_distance_beside(
    tables: SurfaceTables,
    x: Vec3,
    enough: float,
    given: tuple[float, Vec3, float],
    room: DescentWorkspace,
) -> tuple[float, int]:
    """Signed distance, given that of another point; see :func:`signed_distance_at`.

    They are on one side where balls around both that nothing is in overlap, or where nothing is
    between them, which costs less to see than to find out anew.

    Args:
        tables: the surface.
        x: the point.
        enough: where it is not below, even if the point is inside, that bound of it is returned.
        given: signed distance of the other, as it is returned, or 0 where it is not known; the
            other point; the distance of both.
        room: for descents.
    """
    tree, _, grid, closed, extent, error = tables
    beside, other, apart = given
    lower, upper = distance_bounds(grid, x)
    most = min(max(-lower, upper), abs(beside) * (1.0 + error[1]) + error[0] + apart)
    most = most * (1.0 + 1e-9) + TOUCHING * extent
    # it may be of another surface, but is a triangle of this one all the same
    guess = room.nearest[0] if room.nearest[0] < len(tree.corners) // 9 else -1
    away, number = nearest_triangle(tree, x, most, 0.0, room.waiting, room.squares, guess)
    room.nearest[0] = number
    doubt = error[0] + error[1] * away
    if not closed:
        return max(away - doubt, 0.0), number
    inside = upper < 0.0
    if lower <= 0.0 <= upper and -away - doubt >= enough:
        inside = True
    elif lower <= 0.0 <= upper:
        if away - doubt <= _IN_DOUBT * extent:
            inside = True
        else:
            free = abs(beside) - 2.0 * (error[0] + error[1] * abs(beside))
            touching = _BETWEEN * (grid.step + tree.size)
            if free > 0.0 and (
                free + away - doubt > apart * (1.0 + 1e-9)
                or near_triangle(tree, other, x, touching, (0.0, 0.0, 0.0), room.waiting) < 0
            ):
                inside = beside < 0.0
            else:
                inside = is_inside_near(tables, x, room)
    return (-away if inside else away) - doubt, number


@jitable
def gradient_of(tables: SurfaceTables, x: Vec3, away: float, number: int) -> Vec3:
    """Gradient of the signed distance ``away`` of a point, given the nearest triangle.

    It leads away from the closest point, towards it inside a solid; on the surface itself it is
    the normal of a triangle there.
    """
    a, b, c = triangle = triangle_at(tables.tree.corners, number)
    offset = sub(x, closest_point(x, triangle))
    size = norm(offset)
    if size <= TOUCHING * tables.extent:
        offset = cross(sub(b, a), sub(c, a))
        size = norm(offset)
    elif tables.closed and away + tables.error[0] + tables.error[1] * size < 0.0:
        size = -size
    return offset[0] / size, offset[1] / size, offset[2] / size


_FINE = 1 / 8
"""Part of the grid's step within which its bounds are about the same."""


@jitable
def distance_along(
    tables: SurfaceTables, p: Vec3, q: Vec3, most: float, room: DescentWorkspace
) -> float:
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
    pad = TOUCHING * tables.extent
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


@jitable
def least_distance(
    tables: SurfaceTables, p: Vec3, q: Vec3, most: float, room: DescentWorkspace
) -> float:
    """Least signed distance along a segment of the body frame; ``most`` where that is less.

    Below 0 it is a lower bound. Between two samples s and t at a distance l, the signed distance is
    at least (s + t - l) / 2 and the least at most s and t: so it is off by at most 1/64 of the
    length.
    """
    # whether it is inside is not asked before it would be deep enough
    deepest = most
    if most < 0.0 and tables.closed:
        deepest = _least_inside(tables, p, q, most, room)
        if deepest >= most:
            return most
    # whether it touches counts whatever the most is
    away = distance_along(tables, p, q, max(most, TOUCHING * tables.extent), room)
    if not tables.closed or (away > 0.0 and not is_inside_surface(tables, p, room)):
        return min(away, most)
    return deepest if most < 0.0 else _least_inside(tables, p, q, most, room)


@jitable
def bounds_along(
    tables: SurfaceTables, p: Vec3, q: Vec3, most: float, room: DescentWorkspace
) -> tuple[float, float]:
    """Bounds of what :func:`least_distance` finds, by the grid alone.

    The lower one may be lower than it need be where it is above ``most``.
    """
    upper = _bound_samples(tables, p, q, most, room)
    lower, samples = math.inf, room.samples
    for k in range(SAMPLES):
        lower = min(lower, samples[k] + samples[k + 1])
    return (lower - distance(p, q) / SAMPLES) / 2, upper


@jitable
def _bound_samples(
    tables: SurfaceTables, p: Vec3, q: Vec3, most: float, room: DescentWorkspace
) -> float:
    """Bound the signed distances of the samples from below, and return the least bound from above.

    Samples beside one that is far above ``most``, or very near to it, are bounded by that one.
    """
    d = sub(q, p)
    step, upper, far = norm(d) / SAMPLES, math.inf, 0
    fine = _FINE * tables.grid.step
    for k in range(SAMPLES + 1):
        room.known[k] = False
        if far > 0:
            room.samples[k], far = room.samples[k - 1] - step, far - 1
            continue
        lower, high = distance_bounds(tables.grid, axpy(k / SAMPLES, d, p))
        room.samples[k], upper = lower, min(upper, high)
        if step > 0.0:
            far = int(min(max((lower - most) / step - 1.0, fine / step), SAMPLES))
    return upper


@jitable
def _least_inside(
    tables: SurfaceTables, p: Vec3, q: Vec3, most: float, room: DescentWorkspace
) -> float:
    """The lower bound of :func:`least_distance`; ``most`` where that is less."""
    d = sub(q, p)
    step = norm(d) / SAMPLES
    samples, known = room.samples, room.known
    _bound_samples(tables, p, q, most, room)
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
        enough = 2 * least + step - samples[2 * first + 1 - k]
        if not _is_above(tables, axpy(k / SAMPLES, d, p), k, enough, room):
            _take_sample(tables, (p, d), k, step, enough, room)
        if known[first] and known[first + 1]:
            least = min(least, (samples[first] + samples[first + 1] - step) / 2)


@jitable
def _is_above(
    tables: SurfaceTables, x: Vec3, k: int, enough: float, room: DescentWorkspace
) -> bool:
    """Check if a triangle shows that a sample's signed distance is large enough, and raise it then.

    It is no deeper than any triangle is far: mostly that nearest to the sample before will do.
    """
    tree, error, number = tables.tree, tables.error, room.nearest[0]
    if not 0 <= number < len(tree.corners) // 9 or enough >= 0.0:
        return False
    away = math.sqrt(point_to_triangle(x, triangle_at(tree.corners, number), math.inf))
    bound = -away - error[0] - error[1] * away
    if bound < enough or bound <= room.samples[k]:
        return False
    room.samples[k] = bound
    return True


@jitable
def _take_sample(
    tables: SurfaceTables,
    way: tuple[Vec3, Vec3],
    k: int,
    step: float,
    enough: float,
    room: DescentWorkspace,
) -> None:
    """Find a sample's signed distance, which bounds the others: it is 1-Lipschitz.

    Args:
        tables: the surface.
        way: first end of a segment and its second end less that.
        k: number of the sample.
        step: between samples.
        enough: where it is not below this, a bound will do.
        room: see ``DescentWorkspace``; the sample and the bounds are written.
    """
    samples, known = room.samples, room.known
    p, d = way
    x = axpy(k / SAMPLES, d, p)
    other = k - 1 if k > 0 and known[k - 1] else k + 1
    beside = (0.0, x, math.inf)
    if other <= SAMPLES and known[other]:
        beside = (samples[other], axpy(other / SAMPLES, d, p), step)
    samples[k], _ = signed_distance_beside(tables, x, enough, beside, room)
    known[k] = samples[k] < enough
    if known[k]:
        for i in range(SAMPLES + 1):
            if not known[i]:
                samples[i] = max(samples[i], samples[k] - abs(i - k) * step)
