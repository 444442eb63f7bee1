"""Shortcuts of joint paths: stretches are replaced by straight motions that are proven clear."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from abi import arguments
from abi.arm_planning.joint_search.joint_space import JointSpace
from abi.arrays import FloatArray

_WORTH = 1e-3
"""Part of a path's length that a replacement must save."""


def shortened(
    space: JointSpace, path: FloatArray, random: np.random.Generator, tries: int
) -> Iterator[FloatArray]:
    """A joint path, then each shorter one that is found.

    First vertices are left out, as many at a time as can be; then straight ways are tried between
    random places of the path (Geraerts and Overmars, Creating High-quality Paths for Motion
    Planning, 2007, section 3).

    Args:
        space: the arm and what it keeps clear of.
        path: joint positions (k, n), k >= 2, whose edges are proven clear, [rad] or [unit].
        random: chooses the places.
        tries: number of straight ways to try, at most.
    """
    path = arguments.numbers("path", path, (-1, len(space.weights)))
    yield path
    left = tries
    first = 0
    while first < len(path) - 2 and left > 0:
        for last in range(len(path) - 1, first + 1, -1):
            left -= 1
            if space.clear(path[[first, last]]):
                path = np.concatenate([path[: first + 1], path[last:]])
                yield path
                break
            if left == 0:
                break
        first += 1
    for low, high in random.random((left, 2)):
        if (shorter := _cut(space, path, *sorted((float(low), float(high))))) is not None:
            path = shorter
            yield path


def _cut(space: JointSpace, path: FloatArray, low: float, high: float) -> FloatArray | None:
    """The path with a shortcut between two fractions of its length; None if that is no gain."""
    lengths = np.linalg.norm(np.diff(path, axis=0) * space.weights, axis=1)
    passed = np.concatenate([[0.0], np.cumsum(lengths)])
    total = float(passed[-1])
    places = np.array([low, high]) * total
    edges = np.clip(np.searchsorted(passed, places, side="right") - 1, 0, len(lengths) - 1)
    first, last = edges.tolist()
    if first == last:
        return None
    ends = np.stack([np.interp(places, passed, column) for column in path.T], axis=1)
    straight = float(np.linalg.norm((ends[1] - ends[0]) * space.weights))
    if places[1] - places[0] - straight < _WORTH * total or not space.clear(ends):
        return None
    return np.concatenate([path[: first + 1], ends, path[last + 1 :]])
