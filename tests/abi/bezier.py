"""Bézier pieces of curves that only tests know."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.interpolate import BPoly

from abi.arrays import FloatArray
from abi.curves.bezier import Bezier


def interpolated(curve: Callable[[FloatArray], FloatArray], breaks: FloatArray, n: int) -> Bezier:
    """Bézier points of a curve that is a polynomial of degree n between its breaks."""
    share = np.linspace(0, 1, n + 1)
    start, end = breaks[:-1, None], breaks[1:, None]
    values = curve((start + (end - start) * share).ravel()).reshape(len(start), n + 1, 3)
    bernstein = BPoly(np.eye(n + 1)[:, None], [0, 1])(share) if n else np.ones((1, 1))
    points = np.linalg.solve(bernstein, values)
    return Bezier(breaks.astype(float), points, float(np.abs(points).max()))


def polyline(points: FloatArray) -> Bezier:
    """Polyline on [0, k - 1], its vertices (k, 3) at the whole parameters; k >= 1, [unit]."""
    vertices = points if len(points) > 1 else np.repeat(points, 2, axis=0)
    pieces = np.stack([vertices[:-1], vertices[1:]], axis=1)
    return Bezier(np.arange(float(len(vertices))), pieces, float(np.abs(vertices).max()))
