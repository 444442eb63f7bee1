"""Nearest free point to a blocked one."""

from __future__ import annotations

import math

import numpy as np

from abi.arrays import FloatArray, read_only
from abi.obstacles.obstacle_set import ObstacleSet
from abi.scene.scene import Workspace

_PUSHES = 12
_ROUNDS = 60
_SHORTEST = 1e-4  # step of a slide, as a part of the distance to go


def nearest_free(
    obstacles: ObstacleSet, workspace: Workspace, point: FloatArray, margin: float, free: FloatArray
) -> FloatArray | None:
    """The nearest point found that keeps ``margin`` from every obstacle, in the workspace.

    Each known free point slides towards ``point``: a step straight on, then out of the obstacles
    along the gradient of the distance; a step that does not end free and nearer is halved. The
    point itself, pushed out, slides with them. Next to one obstacle that gives the nearest point,
    for the pushed point moves by what the distance lacks and no point moves by less.

    Args:
        obstacles: the solids and meshes.
        workspace: where the point must be.
        point: shape (3,), [unit], world.
        margin: distance to keep, [unit].
        free: known free points to start from, shape (k, 3), [unit], world.

    Returns:
        Shape (3,), [unit], world, or None when no free point is known or found.
    """
    low, high = np.array(workspace.min), np.array(workspace.max)
    pushed = _pushed_out(obstacles, np.clip(point, low, high)[None], margin, low, high)
    places: FloatArray = np.concatenate([free, pushed])
    kept = obstacles.nearest(places)[0] >= margin
    places = places[kept]
    if not len(places):
        return None
    step = np.ones(len(places))
    away = np.linalg.norm(places - point, axis=1)
    for _ in range(_ROUNDS):
        trial = places + step[:, None] * (point - places)
        trial = _pushed_out(obstacles, trial, margin, low, high)
        distance = np.linalg.norm(trial - point, axis=1)
        nearer = (obstacles.nearest(trial)[0] >= margin) & (distance < away * (1 - 1e-9))
        places[nearer], away[nearer] = trial[nearer], distance[nearer]
        step = np.where(nearer, np.minimum(2 * step, 1.0), step / 2)
        if (step < _SHORTEST).all():
            break
    best: FloatArray = places[away.argmin()].copy()
    return read_only(best)


def rounded(point: FloatArray, workspace: Workspace, error: float) -> FloatArray:
    """The point with as few decimals as move it by no more than ``error``, [unit]; in the box."""
    decimals = max(0, math.ceil(-math.log10(2 * error / math.sqrt(3))))
    return np.asarray(np.clip(np.round(point, decimals), workspace.min, workspace.max))


def _pushed_out(
    obstacles: ObstacleSet, places: FloatArray, margin: float, low: FloatArray, high: FloatArray
) -> FloatArray:
    """Push places (n, 3) out of the obstacle they are nearest to, and so on, within the box."""
    places = places.copy()
    for _ in range(_PUSHES):
        distance, index = obstacles.nearest(places)
        lacking = margin - distance
        if (lacking <= 0).all():
            break
        for k in np.unique(index[lacking > 0]):
            rows = (index == k) & (lacking > 0)
            outward = obstacles[k].gradient(places[rows])
            # a little further, for rounding must not leave it inside
            push = lacking[rows] * (1 + 1e-9) + 1e-12
            places[rows] += outward * push[:, None]
        places = np.clip(places, low, high)
    return places
