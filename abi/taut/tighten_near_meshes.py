"""Tightening of a path among obstacles of any shape, by the signed distance and its gradient."""

from __future__ import annotations

import numpy as np

from abi.arrays import FloatArray, flat
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.surface_set import surface_set
from abi.taut.tighten_near_meshes_kernels import Surroundings, tightened


def tighten_near_meshes(
    points: FloatArray, obstacles: ObstacleSet, limits: FloatArray
) -> FloatArray:
    """Pull a path taut: never longer, and every new segment clear.

    Skips vertices that it can do without, then moves each in turn towards the chord of its
    neighbours, straight and in the plane across the gradient of the distance, then cuts corners.

    Args:
        points: (k, 3) the path, [unit], world.
        obstacles: the solids, convex or not.
        limits: (4,) distance that a segment keeps, [unit]: in general, from the first point, to the
            last, from the first to the last.

    Returns:
        (m, 3) the new path; the ends stay.
    """
    margins = flat(np.repeat(limits, len(obstacles.primitives)))
    meshes = surface_set(obstacles.meshes)
    around = Surroundings(obstacles.packed, margins, meshes, flat(limits))
    return np.asarray(tightened(flat(points), around)).reshape(-1, 3)
