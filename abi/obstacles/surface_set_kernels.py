"""Distances of points and segments to all triangle meshes of a scene.

A tree over the meshes' bounding boxes (``primitive_tree_kernels``) leaves out those that are far.
Plain Python that numba compiles with its caller.
"""

from __future__ import annotations

import math

from abi.compilation.jitable import jitable
from abi.obstacles.primitive_tree_kernels import next_near, next_near_segment
from abi.obstacles.surface_set import SurfaceSet, surface_at
from abi.obstacles.triangle_mesh.blocked_segment_kernels import is_blocked
from abi.obstacles.triangle_mesh.distance_grid_kernels import distance_bounds
from abi.obstacles.triangle_mesh.point_distance_kernels import signed_distance_at
from abi.obstacles.triangle_mesh.surface_segment_kernels import least_distance
from abi.obstacles.triangle_mesh.surface_tables_kernels import DescentWorkspace, to_surface
from abi.obstacles.vector_kernels import Vec3, axpy, distance, sub

WIDER = 1e-9
"""Distance, [unit] and part, by which meshes are looked for farther: rounding leaves none out."""


@jitable
def widened(limit: float) -> float:
    """Distance to a mesh's bounding box up to which the mesh may be nearer than a limit, [unit]."""
    return limit + WIDER * (1.0 + abs(limit))


@jitable
def nearest_mesh(
    surfaces: SurfaceSet, enough: float, sought: float, x: Vec3, room: DescentWorkspace
) -> tuple[float, int, int, float]:
    """Least signed distance of a point, whose it is, the triangle, and a lower bound of it.

    Args:
        surfaces: the meshes.
        enough: where it is not below, [unit], it may be left out: then it is inf and the others -1.
        sought: the bound need not be above this, [unit].
        x: a point, [unit], world.
        room: for descents.
    """
    bounds = surfaces.bounds
    best, whose, triangle, least = math.inf, -1, -1, sought
    s = next_near(bounds, -1, widened(least), x, x)
    while s >= 0:
        tables, placement = surface_at(surfaces, s)
        p = to_surface(placement, x)
        lower = distance_bounds(tables.grid, p)[0] * placement.factor
        if lower < min(enough, least):
            away, number = signed_distance_at(tables, p, room)
            lower = away * placement.factor
            if lower < best:
                best, whose, triangle = lower, s, number
        least = min(least, lower)
        s = next_near(bounds, s, widened(least), x, x)
    return best, whose, triangle, least


@jitable
def most_to_mesh(surfaces: SurfaceSet, most: float, x: Vec3) -> float:
    """Upper bound of a point's signed distance to the nearest mesh; ``most`` if that is less."""
    bounds = surfaces.bounds
    s = next_near(bounds, -1, most, x, x)
    while s >= 0:
        tables, placement = surface_at(surfaces, s)
        upper = distance_bounds(tables.grid, to_surface(placement, x))[1]
        most = min(most, upper * placement.factor)
        s = next_near(bounds, s, most, x, x)
    return most


@jitable
def nearest_mesh_to_segment(
    surfaces: SurfaceSet, enough: float, a: Vec3, b: Vec3, room: DescentWorkspace
) -> tuple[float, int]:
    """Least signed distance of a segment and whose it is; ``enough`` and -1 if it is not below.

    Args:
        surfaces: the meshes.
        enough: [unit].
        a: one end, [unit], world; it may be the other one, too.
        b: the other end.
        room: for descents.
    """
    bounds = surfaces.bounds
    best, whose = enough, -1
    half = distance(a, b) / 2
    # how deep a segment is inside is a bound from below: each that may be inside counts
    wide = widened(max(best, 0.0))
    s = next_near_segment(bounds, -1, wide, a, b)
    while s >= 0:
        tables, placement = surface_at(surfaces, s)
        p, q = to_surface(placement, a), to_surface(placement, b)
        lower = distance_bounds(tables.grid, axpy(0.5, sub(q, p), p))[0]
        if lower * placement.factor - half < wide:
            # in the surface's lengths: back in the world's, rounding would make it nearer
            limit = best / placement.factor
            away = least_distance(tables, p, q, limit, room)
            if away < limit:
                best, whose = away * placement.factor, s
                wide = widened(max(best, 0.0))
        s = next_near_segment(bounds, s, wide, a, b)
    return best, whose


@jitable
def meshes_met(
    surfaces: SurfaceSet, margin: float, a: Vec3, b: Vec3, most: int, room: DescentWorkspace
) -> tuple[int, int]:
    """Number of meshes that the segment a..b, world, meets, up to ``most``; the last one, or -1.

    It meets those that it comes nearer to than ``margin``, and those that it touches.
    """
    bounds, met, whose = surfaces.bounds, 0, -1
    wide = widened(max(margin, 0.0))
    s = next_near_segment(bounds, -1, wide, a, b)
    while s >= 0 and met < most:
        tables, placement = surface_at(surfaces, s)
        p, q = to_surface(placement, a), to_surface(placement, b)
        if is_blocked(tables, p, q, margin / placement.factor, room):
            met, whose = met + 1, s
        s = next_near_segment(bounds, s, wide, a, b)
    return met, whose
