"""Polylines as the fat line segments that viser draws, whole or dashed."""

from __future__ import annotations

import functools

import numpy as np
import viser
from numpy.typing import NDArray

from abi.arrays import FloatArray, read_only
from app.ui import style

Segments = NDArray[np.float32]
NO_SEGMENTS: Segments = read_only(np.zeros((1, 2, 3), np.float32))
"""A single segment of zero length, since viser accepts no empty line set."""


@functools.lru_cache(64)
def parameters(interval: tuple[float, float], count: int) -> FloatArray:
    """``count`` equally spaced parameters over an interval."""
    return read_only(np.linspace(*interval, count))


def add_line(
    scene: viser.SceneApi, name: str, colour: style.Colour, thickness: float
) -> viser.LineSegmentsHandle:
    """Add a line without segments yet, ``thickness`` [px] wide."""
    return scene.add_line_segments(
        name, NO_SEGMENTS, colour, thickness=thickness, thickness_units="screen"
    )


def segments(points: FloatArray) -> Segments:
    """Segments (n-1, 2, 3) of a polyline (n, 3); one of zero length when n < 2."""
    if len(points) < 2:
        return NO_SEGMENTS
    pairs = np.empty((len(points) - 1, 2, 3), np.float32)
    pairs[:, 0], pairs[:, 1] = points[:-1], points[1:]
    return pairs


def dashes(points: FloatArray, length: float) -> Segments:
    """Dashes of ``length`` along a polyline (n, 3), with gaps 0.7 times as long."""
    arc = _arc(points)
    if len(points) < 2 or arc[-1] <= 0:
        return segments(points)
    period = 1.7 * length
    starts = np.arange(0.0, arc[-1], period)
    ends = np.minimum(starts + length, arc[-1])
    # between two of these places next to each other is a straight piece of a dash, or of a gap
    places = np.sort(np.concatenate((starts, ends, arc[1:-1])))
    middles = (places[:-1] + places[1:]) / 2
    drawn = (middles % period < length) & (np.diff(places) > 0)
    return np.asarray(segments(rows_at(places, arc, points))[drawn])


def points_at(points: FloatArray, parts: FloatArray) -> FloatArray:
    """Points (m, 3) at fractions (m,) of a polyline's length (n, 3)."""
    arc = _arc(points)
    return rows_at(parts * arc[-1], arc, points)


def rows_at(places: FloatArray | float, known: FloatArray, rows: FloatArray) -> FloatArray:
    """Linear interpolation of rows (n, k) known at (n,), at places (m,) or one place."""
    return np.stack([np.interp(places, known, column) for column in rows.T], axis=-1)


def _arc(points: FloatArray) -> FloatArray:
    """Arc length of a polyline (n, 3) up to each of its points, (n,)."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate(([0.0], np.cumsum(steps)))
