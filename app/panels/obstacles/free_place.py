"""The next free place for a new obstacle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from abi.arrays import FloatArray
from abi.scene.scene import Scene

_PLACES = 13  # along each side of the workspace
_GAP = 0.2  # of the new one's half size, between it and others

Bounds = tuple[FloatArray, FloatArray]
"""Low and high corner (3,) of a box, [unit], world."""


def free_place(
    half: FloatArray, wanted: FloatArray, scene: Scene, occupied: Sequence[Bounds]
) -> FloatArray:
    """Centre (3,) of a box that meets no other, as near as possible to where it is wanted, [unit].

    Where none is free, the place that overlaps the others least.

    Args:
        half: half sizes (3,) of the box, [unit].
        wanted: (3,), [unit].
        scene: whose start, goal and workspace count.
        occupied: bounds of the obstacles there are.
    """
    low, high = np.array(scene.workspace.min), np.array(scene.workspace.max)
    inner = np.minimum(half, (high - low) / 2)
    axes = [np.linspace(low[k] + inner[k], high[k] - inner[k], _PLACES) for k in range(3)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    places = np.concatenate([wanted[None], grid])
    room = half * (1 + _GAP)
    ends = map(np.array, (scene.start, scene.goal))
    overlap = np.zeros(len(places))
    for below, above in [*occupied, *((end - _GAP * half, end + _GAP * half) for end in ends)]:
        shared = np.minimum(places + room, above) - np.maximum(places - room, below)
        overlap += np.maximum(shared, 0).prod(axis=1)
    distance = np.linalg.norm(places - wanted, axis=1)
    return np.asarray(places[np.lexsort((distance, overlap.round(12)))[0]])
