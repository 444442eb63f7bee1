"""Clearance of an arm whose joints go straight from sample to sample: measured, and proven between.

A point of a link moves at most by the joints' steps times its levers, and distances grow no faster
than points move: between two samples with distances d₁ and d₂ and a way w, nothing comes nearer
than (d₁ + d₂ - w) / 2. Where that is not enough the step is halved.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from abi.arm.urdf_arm import UrdfArm, segment_distances
from abi.arrays import FloatArray, IntArray
from abi.obstacles.obstacle_set import ObstacleSet

_ROUNDS = 14
_MOST = 60_000
"""Poses measured for a proof, at most."""
_SHARE = 0.98
"""Part of the least distance found that is to be proven."""

_PAD = 1e-9
"""What rounding may take of a distance, as a part of the arm's reach."""

Distances = Callable[[FloatArray], FloatArray]
"""Distances (k, r) of r pairs of things at joint positions (k, n), [unit]."""


@dataclass(frozen=True, eq=False)
class JointPathProof:
    """A bound of distances, proven by how far links move between samples of the joints.

    Attributes:
        margin: distance that the links keep from every obstacle, [unit]; inf without obstacles.
    """

    margin: float


def obstacle_distances(
    arm: UrdfArm, obstacles: ObstacleSet, positions: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Signed distances of an arm's capsules to the nearest obstacle at joint positions (k, n).

    Returns:
        Distances (k, c), [unit], inf without obstacles; and numbers of the obstacles, -1 without.
    """
    ends = arm.place(positions)
    shape = ends.shape[:2]
    p, q = ends[:, :, 0].reshape(-1, 3), ends[:, :, 1].reshape(-1, 3)
    distance, number = np.full(shape, np.inf), np.full(shape, -1, dtype=np.int32)
    for index, obstacle in enumerate(obstacles):
        gap = obstacle.segment_distance(p, q).reshape(shape) - arm.radii
        nearer = gap < distance
        distance[nearer], number[nearer] = gap[nearer], index
    return distance, number


def own_distances(arm: UrdfArm, positions: FloatArray) -> FloatArray:
    """Signed distances between the links of ``arm.pairs`` at positions (k, n), (k, p), [unit]."""
    ends, pairs = arm.place(positions), arm.pairs
    first, second = (ends[:, pairs[:, side]].reshape(-1, 2, 3) for side in (0, 1))
    gaps = segment_distances(first, second).reshape(len(positions), len(pairs))
    return np.asarray(gaps - arm.radii[pairs].sum(axis=1))


def floor_distances(arm: UrdfArm, floor: float, positions: FloatArray) -> FloatArray:
    """Heights of the capsules above the floor at positions (k, n), (k, c), [unit].

    Inf of what stands still and of the link on it, which may touch it.
    """
    heights = arm.place(positions)[..., 2].min(axis=2) - arm.radii - floor
    resting = [one.frame < 1 for one in arm.capsules]
    heights[:, resting] = np.inf
    return np.asarray(heights)


def least_between(
    distances: Distances, levers: FloatArray, positions: FloatArray, target: float
) -> float | None:
    """Lower bound of distances while the joints go straight from sample to sample.

    Args:
        distances: the distances at joint positions.
        levers: how far things come nearer at most for one of each coordinate, shape (r, n).
        positions: joint positions in their order, shape (k, n).
        target: what is to be proven, [unit]; less is where less is found.

    Returns:
        A proven bound, [unit]; None where that would take too long.
    """
    measured = distances(positions)
    if not measured.size:
        return float("inf")
    pad = _PAD * float(levers.max(initial=0.0))
    start, end = positions[:-1], positions[1:]
    at_start, at_end = measured[:-1], measured[1:]
    least, count = float(measured.min()), len(positions)
    proven = min(target, _SHARE * least)
    for _ in range(_ROUNDS):
        way = np.abs(end - start) @ levers.T
        open_ones = (((at_start + at_end - way) / 2) < proven).any(axis=1)
        start, end = start[open_ones], end[open_ones]
        at_start, at_end = at_start[open_ones], at_end[open_ones]
        count += len(start)
        if not len(start):
            return proven - pad
        if count > _MOST or proven <= 0:
            return None
        middle = (start + end) / 2
        at_middle = distances(middle)
        proven = min(proven, _SHARE * float(at_middle.min()))
        start, end = np.concatenate([start, middle]), np.concatenate([middle, end])
        at_start = np.concatenate([at_start, at_middle])
        at_end = np.concatenate([at_middle, at_end])
    return None
