"""Tightening of a path among obstacles of any shape, by the signed distance and its gradient."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from abi import arguments
from abi.arrays import FloatArray, flat, read_only
from abi.obstacles.obstacle_set import ObstacleSet
from abi.search.taut.tighten_near_meshes_kernels import PathObstacles, tightened


def tighten_near_meshes(
    points: FloatArray, obstacles: ObstacleSet, limits: FloatArray
) -> FloatArray:
    """Pull a path taut: never longer, and every new segment clear.

    It drops vertices that are not needed, then moves each in turn towards the chord of its
    neighbours, straight and in the plane across the gradient of the distance, then cuts corners.

    Args:
        points: (k, 3) the path, [unit], world.
        obstacles: the solids, convex or not.
        limits: (4,) distance that a segment keeps, [unit]: in general, from the first point, to the
            last, from the first to the last.

    Returns:
        (m, 3) the new path; the ends stay.
    """
    path = arguments.polyline("points", points)
    margins = arguments.numbers("limits", limits, (4,))
    return _tightened(flat(path).tobytes(), obstacles, flat(margins).tobytes())


@lru_cache(maxsize=4)
def _tightened(points: bytes, obstacles: ObstacleSet, limits: bytes) -> FloatArray:
    """The tightened path, cached as the arm's plan often begins with the tool's."""
    path = tightened(flat(np.frombuffer(points)), _surroundings(obstacles, np.frombuffer(limits)))
    return read_only(path)


def clear_of(obstacles: ObstacleSet, margin: float) -> PathObstacles:
    """The obstacles in the format of the kernels, with one margin for all segments, [unit]."""
    return _surroundings(obstacles, np.full(4, margin))


def _surroundings(obstacles: ObstacleSet, limits: FloatArray) -> PathObstacles:
    margins = flat(np.repeat(limits, len(obstacles.primitives)))
    return PathObstacles(obstacles.packed, margins, obstacles.surfaces, flat(limits))
