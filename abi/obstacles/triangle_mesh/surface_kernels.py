"""Signed distances to a surface that is placed in the world, of arrays of points and segments."""

from __future__ import annotations

from abi.arrays import BoolArray, FloatArray
from abi.compilation.borrowed import borrowed, held
from abi.compiled import FLOATS, NEW_FLAGS, NEW_FLOATS, compiled
from abi.obstacles.primitive_kernels import in_world
from abi.obstacles.triangle_mesh.blocked_segment_kernels import is_blocked
from abi.obstacles.triangle_mesh.distance_grid_kernels import distance_bounds
from abi.obstacles.triangle_mesh.point_distance_kernels import gradient_of, signed_distance_at
from abi.obstacles.triangle_mesh.surface_segment_kernels import least_distance
from abi.obstacles.triangle_mesh.surface_tables_kernels import (
    NO_PLACEMENT,
    NO_TABLES,
    Placement,
    SurfaceTables,
    new_room,
    to_surface,
)
from abi.obstacles.vector_kernels import vec3_at


@compiled(example=(NO_TABLES, NO_PLACEMENT, FLOATS, NEW_FLOATS), fallback=False)
def signed_distances(
    tables: SurfaceTables, placement: Placement, points: FloatArray, distances: FloatArray
) -> None:
    """Signed distances (n,) of points (3 n,), [unit], world; written."""
    own = new_room()
    room = borrowed(own)
    for i in range(len(points) // 3):
        x = to_surface(placement, vec3_at(points, 3 * i))
        away, _ = signed_distance_at(tables, x, room)
        distances[i] = away * placement.factor
    held(own)


@compiled(example=(NO_TABLES, NO_PLACEMENT, FLOATS, NEW_FLOATS, NEW_FLOATS), fallback=False)
def signed_distance_gradients(
    tables: SurfaceTables,
    placement: Placement,
    points: FloatArray,
    distances: FloatArray,
    gradients: FloatArray,
) -> None:
    """Signed distances (n,) of points (3 n,), [unit], world, and gradients (3 n,); written."""
    own = new_room()
    room = borrowed(own)
    for i in range(len(points) // 3):
        x = to_surface(placement, vec3_at(points, 3 * i))
        away, number = signed_distance_at(tables, x, room)
        distances[i] = away * placement.factor
        gradient = in_world(placement.axes, gradient_of(tables, x, away, number))
        gradients[3 * i], gradients[3 * i + 1], gradients[3 * i + 2] = gradient
    held(own)


@compiled(example=(NO_TABLES, NO_PLACEMENT, FLOATS, FLOATS, NEW_FLOATS), fallback=False)
def least_distances(
    tables: SurfaceTables,
    placement: Placement,
    starts: FloatArray,
    ends: FloatArray,
    distances: FloatArray,
) -> None:
    """Least signed distances (n,) along segments (3 n,), [unit], world, where less; written."""
    own = new_room()
    room = borrowed(own)
    factor = placement.factor
    for i in range(len(distances)):
        p = to_surface(placement, vec3_at(starts, 3 * i))
        q = to_surface(placement, vec3_at(ends, 3 * i))
        most = distances[i] / factor
        away = least_distance(tables, p, q, most, room)
        if away < most:
            distances[i] = away * factor
    held(own)


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
    own = new_room()
    room = borrowed(own)
    for i in range(len(starts) // 3):
        p = to_surface(placement, vec3_at(starts, 3 * i))
        q = to_surface(placement, vec3_at(ends, 3 * i))
        blocked[i] = is_blocked(tables, p, q, margins[i] / placement.factor, room)
    held(own)


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
