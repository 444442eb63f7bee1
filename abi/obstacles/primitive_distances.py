"""Signed distances of many points to primitives by numpy, while kernels are not compiled.

Bit by bit those of ``primitive_kernels``.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from abi import arguments
from abi.arrays import FloatArray, IntArray
from abi.obstacles.primitive_kernels import WIDTH, axes_of, centre_of, core_of, in_body
from abi.obstacles.vector_kernels import sub

_AT_ONCE = 100_000
"""Distances in one array, at most."""


def nearest(
    points: FloatArray, primitives: FloatArray, distances: FloatArray, numbers: IntArray
) -> None:
    """Write distances to the nearest primitive: see the kernel of the same name."""
    distances[:], numbers[:] = math.inf, -1
    count = len(primitives) // WIDTH
    size = max(_AT_ONCE // max(count, 1), 1)
    for first in range(0, len(distances) if count else 0, size):
        part = slice(first, first + size)
        to_each = distances_to_each(points[3 * first : 3 * (first + size)], primitives)
        numbers[part] = to_each.argmin(axis=0)  # the first on a tie
        distances[part] = to_each.min(axis=0)


def distances_to_each(points: FloatArray, primitives: FloatArray) -> FloatArray:
    """Signed distances (k, n) of points, flat (3 n,), to primitives."""
    points = arguments.numbers("points", points, (-1,))
    # arrays in place of numbers
    x: Any = tuple(points.reshape(-1, 3).T.copy())
    columns: Any = [*primitives.reshape(-1, WIDTH).T[..., None].copy()]
    u, v, w = in_body(axes_of(columns, 0), sub(x, centre_of(columns, 0)))
    core: Any = core_of(columns, 0)
    is_cylinder = core.is_cylinder == 1
    a = np.where(is_cylinder, np.sqrt(u * u + v * v), np.abs(u)) - core.x
    b = np.where(is_cylinder, -core.x, np.abs(v) - core.y)
    c = np.abs(w) - core.z
    most = np.maximum(a, np.maximum(b, c))
    a, b, c = np.maximum(a, 0.0), np.maximum(b, 0.0), np.maximum(c, 0.0)
    return np.asarray(np.where(most > 0, np.sqrt(a * a + b * b + c * c), most) - core.radius)
