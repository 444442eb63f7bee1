"""Nearest free point to a blocked one."""

from __future__ import annotations

import math

import numpy as np

from abi import arguments
from abi.arrays import FloatArray, read_only
from abi.obstacles.obstacle_set import ObstacleSet
from abi.scene.settings import Workspace

_PUSHES = 12
_ROUNDS = 60
_SHORTEST = 1e-4  # step of a slide, as a part of the distance to go


def nearest_free_point(
    obstacles: ObstacleSet, workspace: Workspace, point: FloatArray, margin: float, free: FloatArray
) -> FloatArray | None:
    """Find a near point that keeps ``margin`` from every obstacle, in the workspace.

    Each known free point slides towards ``point``: a step straight on, then out of the obstacles
    along the gradient of the distance; a step that does not end free and nearer is halved. So does
    the point itself, pushed out. Next to a single obstacle that gives the nearest point, because
    the pushed point moves by exactly what the distance lacks.

    Args:
        obstacles: the solids and meshes.
        workspace: the box that the point must be in.
        point: shape (3,), [unit], world.
        margin: distance to keep, [unit].
        free: known free points to start from, shape (k, 3), [unit], world.

    Returns:
        Shape (3,), [unit], world, or None when no free point is known or found.
    """
    point = arguments.numbers("point", point, (3,))
    margin = arguments.number("margin", margin)
    free = arguments.points("free", free)
    low, high = np.array(workspace.min), np.array(workspace.max)
    pushed = _pushed_out(obstacles, np.clip(point, low, high)[None], margin, low, high)
    points: FloatArray = np.concatenate([free, pushed])
    points = points[obstacles.nearest(points)[0] >= margin]
    if not len(points):
        return None
    step = np.ones(len(points))
    remaining = np.linalg.norm(points - point, axis=1)
    for _ in range(_ROUNDS):
        trial = points + step[:, None] * (point - points)
        trial = _pushed_out(obstacles, trial, margin, low, high)
        distance = np.linalg.norm(trial - point, axis=1)
        nearer = (obstacles.nearest(trial)[0] >= margin) & (distance < remaining * (1 - 1e-9))
        points[nearer], remaining[nearer] = trial[nearer], distance[nearer]
        step = np.where(nearer, np.minimum(2 * step, 1.0), step / 2)
        if (step < _SHORTEST).all():
            break
    best: FloatArray = points[remaining.argmin()].copy()
    return read_only(best)


def rounded(point: FloatArray, workspace: Workspace, error: float) -> FloatArray:
    """Round the point, which stays in the box, to few decimals, by at most ``error``, [unit]."""
    decimals = max(0, math.ceil(-math.log10(2 * error / math.sqrt(3))))
    return np.asarray(np.clip(np.round(point, decimals), workspace.min, workspace.max))


def _pushed_out(
    obstacles: ObstacleSet, points: FloatArray, margin: float, low: FloatArray, high: FloatArray
) -> FloatArray:
    """Push points (n, 3) out of the nearest obstacle, repeatedly, within the box."""
    points = points.copy()
    for _ in range(_PUSHES):
        distance, index = obstacles.nearest(points)
        lacking = margin - distance
        if (lacking <= 0).all():
            break
        for k in np.unique(index[lacking > 0]):
            inside = (index == k) & (lacking > 0)
            _, outward = obstacles[k].signed_distance_gradient(points[inside])
            # a little further, for rounding must not leave it inside
            push = lacking[inside] * (1 + 1e-9) + 1e-12
            points[inside] += outward * push[:, None]
        points = np.clip(points, low, high)
    return points
