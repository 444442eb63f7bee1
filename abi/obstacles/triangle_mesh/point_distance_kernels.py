"""Signed distances of points to a surface, in its body frame.

Bounds by the grid answer most questions, the tree the others.
"""

from __future__ import annotations

import math

from abi.compilation.jitable import jitable
from abi.obstacles.triangle_mesh.closest_point_kernels import nearest_triangle
from abi.obstacles.triangle_mesh.distance_grid_kernels import distance_bounds, side_of
from abi.obstacles.triangle_mesh.segment_kernels import near_triangle
from abi.obstacles.triangle_mesh.surface_tables_kernels import (
    TOUCHING,
    DescentWorkspace,
    SurfaceTables,
)
from abi.obstacles.triangle_mesh.triangle_kernels import closest_point, triangle_at
from abi.obstacles.triangle_mesh.winding_kernels import is_inside
from abi.obstacles.vector_kernels import Vec3, cross, norm, sub

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
