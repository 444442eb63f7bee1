"""Segments that come too near to a surface, in its body frame."""

from __future__ import annotations

import math

from abi.compilation.jitable import jitable
from abi.obstacles.triangle_mesh.distance_grid_kernels import distance_bounds, steepest
from abi.obstacles.triangle_mesh.point_distance_kernels import is_inside_near
from abi.obstacles.triangle_mesh.segment_kernels import near_triangle
from abi.obstacles.triangle_mesh.surface_tables_kernels import (
    TOUCHING,
    DescentWorkspace,
    SurfaceTables,
)
from abi.obstacles.triangle_mesh.triangle_kernels import segment_to_triangle, triangle_at
from abi.obstacles.vector_kernels import Vec3, axpy, distance, sub

_PARALLEL = 1e-8
"""Part of a segment's length: error of its distance to a nearly parallel edge."""


@jitable
def limit_of(tables: SurfaceTables, margin: float, length: float) -> float:
    """Distance at which a segment of some length counts as nearer than a margin, by rounding."""
    return max(margin, TOUCHING * tables.extent) + _PARALLEL * length


@jitable
def is_blocked(
    tables: SurfaceTables, p: Vec3, q: Vec3, margin: float, room: DescentWorkspace
) -> bool:
    """Check if a segment of the body frame comes nearer to a surface than a margin, or touches it.

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
    return not outside and is_inside_near(tables, p, room)
