"""Distances of polylines to obstacles.

For the rows of primitives see ``primitive_kernels``. A point is three successive numbers.
"""

from __future__ import annotations

import math

import numpy as np

from abi.arrays import FloatArray
from abi.compilation.borrowed import borrowed, held
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, NEW_FLOATS, compiled
from abi.obstacles.obstacle_set_kernels import distance_to_segment, nearest_to_segment
from abi.obstacles.primitive_kernels import WIDTH
from abi.obstacles.primitive_tree_kernels import next_near_segment
from abi.obstacles.surface_set import NO_SURFACES, SurfaceSet
from abi.obstacles.surface_set_kernels import most_to_mesh, nearest_mesh_to_segment, widened
from abi.obstacles.triangle_mesh.surface_tables_kernels import new_room
from abi.obstacles.vector_kernels import vec3_at


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


@compiled(example=(FLOATS, 2, FLOATS, NO_SURFACES, 1.0, NEW_FLOATS), fallback=False)
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
