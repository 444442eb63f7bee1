"""How clear of the obstacles polylines are, the paths among them: exactly, segment by segment."""

from __future__ import annotations

import numpy as np

from abi.arrays import FloatArray, flat
from abi.obstacles import obstacle_set_kernels as kernels
from abi.obstacles.obstacle_set import meshes, rows
from abi.obstacles.primitives import Obstacles


def measure_polyline(points: FloatArray, obstacles: Obstacles) -> float:
    """Exact least signed distance from a polyline to the obstacles, [unit].

    Args:
        points: vertices (k, 3), k >= 1, [unit], world.
        obstacles: the solids; without any the distance is inf.
    """
    vertices = points if len(points) > 1 else np.repeat(points, 2, axis=0)
    return float(runs_apart(vertices[None], obstacles)[0])


def runs_apart(points: FloatArray, obstacles: Obstacles) -> FloatArray:
    """:func:`measure_polyline` of polylines of equally many vertices (n, k, 3), k >= 2, (n,)."""
    found = np.empty(len(points))
    kernels.polylines(flat(points), points.shape[1], rows(obstacles), found)
    for mesh in meshes(obstacles):
        starts, ends = points[:, :-1].reshape(-1, 3), points[:, 1:].reshape(-1, 3)
        legs = mesh.segment_distance(starts, ends).reshape(len(points), points.shape[1] - 1)
        np.minimum(found, legs.min(axis=1), out=found)
    return found


def segment_clearances(points: FloatArray, obstacles: Obstacles) -> FloatArray:
    """Exact least signed distance (k - 1,) of a polyline's segments to the obstacles, [unit].

    Args:
        points: vertices (k, 3), k >= 1, [unit], world; one alone is a segment.
        obstacles: the solids; without any the distance is inf.
    """
    if len(points) == 1:
        points = np.concatenate([points, points])
    return runs_apart(np.stack([points[:-1], points[1:]], axis=1), obstacles)
