"""Distances of a curve's samples to triangle meshes, and the bounds that follow for its pieces.

A mesh need not be convex, so the bound of a piece rests on the distance being 1-Lipschitz: no point
of it is nearer than its middle by more than the distance from there to its farthest control point.
A point is three successive numbers. Plain Python that numba compiles with its caller.
"""

from __future__ import annotations

import math

from numba.extending import register_jitable

from abi.clearance.bezier_kernels import divide
from abi.obstacles.primitive_tree_kernels import (
    bounds_apart,
    first_row,
    row_after,
    row_below,
    tree_apart,
)
from abi.obstacles.surface_set import SurfaceSet, surface_at
from abi.obstacles.surface_set_kernels import most_to_mesh, nearest_mesh, widened
from abi.obstacles.triangle_mesh.distance_grid_kernels import distance_bounds
from abi.obstacles.triangle_mesh.surface_kernels import Room, signed_distance_at, to_surface
from abi.obstacles.vector_kernels import Vec3, distance, vec3_at

Sample = tuple[float, int, int]
"""Signed distance, [unit], number of the sample, and the mesh; inf, 0 and -1 without one."""


@register_jitable
def _end(points: list[float], end: int, pieces: int) -> Vec3:
    """First point of a piece of a curve; of the number after the last, where the curve ends."""
    size = len(points) // pieces
    return vec3_at(points, 3 * (len(points) // 3 - 1) if end == pieces else end * size)


@register_jitable
def ends_near_meshes(
    surfaces: SurfaceSet,
    points: list[float],
    at_ends: tuple[list[float], list[float]],
    nearest: float,
    required: float,
    room: Room,
) -> Sample:
    """Lower the distances at the ends of pieces that are one curve to those to the meshes.

    Args:
        surfaces: the meshes.
        points: of the n pieces, flat (3 n (degree + 1),), [unit], world.
        at_ends: distances at their first points (n,), and at their last (n,), [unit]; written.
        nearest: the least distance so far, [unit].
        required: what is farther than that and the nearest sample may be left out, [unit].
        room: for descents.

    Returns:
        The nearest of the ends.
    """
    at_first, at_last = at_ends
    count = len(at_first)
    for end in range(count + 1):
        nearest = most_to_mesh(surfaces, nearest, _end(points, end, count))
    enough = widened(max(nearest, required))
    least, at, whose = math.inf, 0, -1
    for end in range(count + 1):
        away, mesh = nearest_mesh(surfaces, enough, _end(points, end, count), room)
        if mesh < 0:
            continue
        if end > 0:
            at_last[end - 1] = min(at_last[end - 1], away)
        if end < count:
            at_first[end] = min(at_first[end], away)
        if away < least:
            least, at, whose = away, end, mesh
    return least, at, whose


@register_jitable
def middles_near_meshes(
    surfaces: SurfaceSet,
    points: list[float],
    of_middles: tuple[list[float], list[float]],
    nearest: float,
    required: float,
    room: Room,
) -> Sample:
    """Lower the distances at the middles of pieces, and their bounds, to those to the meshes.

    Args:
        surfaces, points, nearest, required, room: see :func:`ends_near_meshes`.
        of_middles: distances at the middles (n,), and bounds of those along the pieces from below
            (n,), [unit]; written.

    Returns:
        The nearest of the middles.
    """
    at_middles, bounds = of_middles
    rows = surfaces.bounds
    size = len(points) // len(at_middles)
    halves = [0.0] * (2 * size)
    least, at, whose = math.inf, 0, -1
    for piece in range(len(at_middles)):
        divide(points, piece * size, halves, 0, size, size // 3, 0.5)
        x = vec3_at(halves, size)
        reach = 0.0
        for i in range(piece * size, (piece + 1) * size, 3):
            reach = max(reach, distance(vec3_at(points, i), x))
        s = first_row(rows)
        while s >= 0:
            enough = widened(max(min(nearest, least), required)) + reach
            if tree_apart(rows, s, enough, x, x):
                s = row_after(rows, s)
                continue
            if not bounds_apart(rows, s, enough, x, x):
                tables, placement = surface_at(surfaces, s)
                p = to_surface(placement, x)
                if distance_bounds(tables.grid, p)[0] * placement.factor < enough:
                    away = signed_distance_at(tables, p, room)[0] * placement.factor
                    at_middles[piece] = min(at_middles[piece], away)
                    bounds[piece] = min(bounds[piece], away - reach)
                    if away < least:
                        least, at, whose = away, piece, s
            s = row_below(rows, s)
    return least, at, whose
