"""Tightening of a path, leg by leg, for an arm that the compiled loops do not know."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from abi.arm.arm_model import Sight
from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import ObstacleSet
from abi.taut.taut_path import polyline_length

_ROUNDS = 3
_STEPS = (0.8, 0.3, 0.08)
_SETTLED = 1e-3
_CUT = (0.45, 0.2)


def pull_by_legs(
    points: FloatArray, obstacles: ObstacleSet, margin: float, sight: Sight
) -> FloatArray:
    """Pull a path taut, segment by segment, each of them clear for the arm, too.

    Vertices that are not needed are dropped, others move towards the chord of their neighbours, and
    corners are cut, until the length settles.

    Args:
        points: path (k, 3), [unit], world.
        obstacles: the solids.
        margin: distance that the tool keeps from them, [unit].
        sight: the arm.
    """
    free = _Legs(obstacles, margin, sight)
    points = _shortcuts(points, free)
    for _ in range(_ROUNDS):
        before = polyline_length(points)
        points = _cut_corners(_moved(points, free), free)
        if polyline_length(points) > (1 - _SETTLED) * before:
            break
    return points


@dataclass(frozen=True, eq=False)
class _Legs:
    """Legs that tool and arm may run along."""

    obstacles: ObstacleSet
    margin: float
    sight: Sight

    def clear(self, *points: FloatArray) -> bool:
        """Check whether the legs between points (3,) are."""
        polyline = np.stack(points)
        if self.obstacles.polyline_clearance(polyline) < self.margin:
            return False
        return self.sight.leg_refutation(polyline) is None


def _shortcuts(points: FloatArray, free: _Legs) -> FloatArray:
    """From each vertex straight to the farthest in sight, found by doubling, then halving."""
    kept, i, last = [0], 0, len(points) - 1
    while i < last:
        near, step = i + 1, 2
        while i + step <= last and free.clear(points[i], points[i + step]):
            near, step = i + step, 2 * step
        far = min(i + step, last)
        while far > near + 1:
            middle = (near + far) // 2
            if free.clear(points[i], points[middle]):
                near = middle
            else:
                far = middle
        if near < last and far == last and free.clear(points[i], points[last]):
            near = last
        i = near
        kept.append(i)
    return points[kept]


def _moved(points: FloatArray, free: _Legs) -> FloatArray:
    """Vertices dropped, or moved towards the chord of their neighbours."""
    kept = [points[0]]
    for k in range(1, len(points) - 1):
        a, vertex, b = kept[-1], points[k], points[k + 1]
        if free.clear(a, b):
            continue
        chord = b - a
        share = np.clip((vertex - a) @ chord / max(float(chord @ chord), 1e-300), 0, 1)
        foot = a + share * chord
        moves = (vertex + step * (foot - vertex) for step in _STEPS)
        kept.append(next((at for at in moves if free.clear(a, at, b)), vertex))
    return np.array([*kept, points[-1]])


def _cut_corners(points: FloatArray, free: _Legs) -> FloatArray:
    """Bends cut where that is clear."""
    kept = [points[0]]
    for k in range(1, len(points) - 1):
        vertex = points[k]
        back, ahead = points[k - 1] - vertex, points[k + 1] - vertex
        for share in _CUT:
            first, last = vertex + share * back, vertex + share * ahead
            if free.clear(first, last):
                kept += [first, last]
                break
        else:
            kept.append(vertex)
    return np.array([*kept, points[-1]])
