"""Tightening of a path among obstacles of any shape, by the signed distance and its gradient."""

from __future__ import annotations

import numpy as np

from abi.arrays import BoolArray, FloatArray
from abi.obstacles.obstacle_set import ObstacleSet

_LOOK_BACK = 32
_CUTS = 6
_SWEEPS = 12
_MOST_POINTS = 64
_SETTLED = 1e-4  # part of the length that a sweep must gain to be followed by another
_STEPS = 0.5 ** np.arange(9)


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
    path = _shortcut(points, obstacles, limits)
    for _ in range(_CUTS):
        for _ in range(_SWEEPS):
            before = _length(path)
            for parity in (1, 0):
                path = _sweep(path, obstacles, limits, parity)
            path = _shortcut(path, obstacles, limits)
            if before - _length(path) <= _SETTLED * before:
                break
        cut_path = _cut_corners(path, obstacles, limits)
        if len(cut_path) == len(path) or len(cut_path) > _MOST_POINTS:
            break
        path = cut_path
    return path


def _shortcut(path: FloatArray, obstacles: ObstacleSet, limits: FloatArray) -> FloatArray:
    """The shortest path from first to last by vertices that see each other."""
    n = len(path)
    i, j = np.triu_indices(n, 1)
    i, j = i[j - i <= _LOOK_BACK], j[j - i <= _LOOK_BACK]
    kind = (i == 0) + 2 * (j == n - 1)
    clear = (j == i + 1) | ~obstacles.blocked(path[i], path[j], limits[kind])
    i, j = i[clear], j[clear]
    length = np.linalg.norm(path[j] - path[i], axis=1)
    cost, parent = np.zeros(n), np.zeros(n, dtype=int)
    for k in range(1, n):
        into = np.flatnonzero(j == k)
        through = cost[i[into]] + length[into]
        cost[k], parent[k] = through.min(), i[into[through.argmin()]]
    kept = [n - 1]
    while kept[-1]:
        kept.append(int(parent[kept[-1]]))
    return path[kept[::-1]]


def _sweep(path: FloatArray, obstacles: ObstacleSet, limits: FloatArray, parity: int) -> FloatArray:
    """Move every other inner vertex to the best point tried; its neighbours stay."""
    inner = np.arange(2 - parity, len(path) - 1, 2)
    if not len(inner):
        return path
    before, here, after = path[inner - 1], path[inner], path[inner + 1]
    legs = _sum_of_legs(before, here, after)
    share = np.linalg.norm(here - before, axis=1, keepdims=True) / np.maximum(legs, 1e-300)[:, None]
    pull = before + share * (after - before) - here
    normal = obstacles.signed_distance_gradient(here)[1]
    across = pull - np.einsum("ni,ni->n", pull, normal)[:, None] * normal
    # vertex, direction, step
    directions = np.stack([pull, across], axis=1)
    trials = here[:, None, None] + directions[:, :, None] * _STEPS[:, None]
    trials = trials.reshape(len(inner), -1, 3)
    count = trials.shape[1]
    first, last = np.repeat(before, count, axis=0), np.repeat(after, count, axis=0)
    middle = trials.reshape(-1, 3)
    length = _sum_of_legs(first, middle, last)
    length[length >= np.repeat(legs, count)] = np.inf
    shorter = np.flatnonzero(np.isfinite(length))
    vertex = np.repeat(inner, count)[shorter]
    from_start, to_goal = (vertex == 1) * 1, (vertex == len(path) - 2) * 2
    blocked = obstacles.blocked(first[shorter], middle[shorter], limits[from_start])
    blocked |= obstacles.blocked(middle[shorter], last[shorter], limits[to_goal])
    length[shorter[blocked]] = np.inf
    length = length.reshape(len(inner), count)
    best = length.argmin(axis=1)
    gained = np.isfinite(length[np.arange(len(inner)), best])
    swept = path.copy()
    swept[inner[gained]] = trials[gained, best[gained]]
    return swept


def _cut_corners(path: FloatArray, obstacles: ObstacleSet, limits: FloatArray) -> FloatArray:
    """Replace each corner that can be cut by two vertices."""
    if len(path) < 3:
        return path
    before, here, after = path[:-2], path[1:-1], path[2:]
    to_a, to_b = before - here, after - here
    a, b = (np.linalg.norm(leg, axis=1) for leg in (to_a, to_b))
    size = np.minimum(a, b) / 2
    steps = size[:, None] * _STEPS
    p = here[:, None] + (to_a / np.maximum(a, 1e-300)[:, None])[:, None] * steps[..., None]
    q = here[:, None] + (to_b / np.maximum(b, 1e-300)[:, None])[:, None] * steps[..., None]
    flat = p.reshape(-1, 3), q.reshape(-1, 3)
    clear = ~obstacles.blocked(*flat, float(limits[0])).reshape(steps.shape)
    gain = 2 * steps - np.linalg.norm(q - p, axis=2)
    kept: BoolArray = clear & (gain > _SETTLED / 4 * _length(path))
    step = kept.argmax(axis=1)  # the first is the largest
    pieces = [path[:1]]
    for k in range(len(here)):
        corner = np.stack([p[k, step[k]], q[k, step[k]]])
        pieces.append(corner if kept[k].any() else here[k : k + 1])
    return np.concatenate([*pieces, path[-1:]])


def _sum_of_legs(a: FloatArray, x: FloatArray, b: FloatArray) -> FloatArray:
    legs = np.linalg.norm(x - a, axis=1) + np.linalg.norm(b - x, axis=1)
    return np.asarray(legs)


def _length(points: FloatArray) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
