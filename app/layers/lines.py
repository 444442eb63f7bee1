"""Polylines as the fat segments viser draws: whole, dashed, or side by side."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from abi.arrays import FloatArray

Segments = NDArray[np.float32]


def segments(points: FloatArray) -> Segments:
    """(n, 3) points of a polyline as (n-1, 2, 3) segments; one of no length when n < 2."""
    if len(points) < 2:
        points = np.zeros((2, 3))
    return np.stack((points[:-1], points[1:]), axis=1).astype(np.float32)


def dashes(points: FloatArray, length: float) -> Segments:
    """(n, 3) points of a polyline as dashes of ``length`` with gaps 0.7 times as long."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    travelled = np.concatenate(([0.0], np.cumsum(steps)))
    if len(points) < 2 or travelled[-1] <= 0:
        return segments(points)
    starts = np.arange(0.0, travelled[-1], 1.7 * length)
    ends = np.minimum(starts + length, travelled[-1])
    corners = travelled[1:-1]
    pieces = [
        np.concatenate(([a], corners[(corners > a) & (corners < b)], [b]))
        for a, b in zip(starts, ends, strict=True)
    ]
    return np.concatenate([segments(_at(points, travelled, piece)) for piece in pieces])


def _at(points: FloatArray, travelled: FloatArray, distances: FloatArray) -> FloatArray:
    return np.stack([np.interp(distances, travelled, points[:, i]) for i in range(3)], axis=1)
