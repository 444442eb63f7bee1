"""Joint paths on which the tool keeps a direction for a part of the path.

A path that is free throughout shows the way. Near its joints at the begin and the end of the part
others are taken that hold the direction; between these the path is sought on the direction's
manifold, and before and after it freely.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from abi.arm_planning.joint_search.held_search import HeldSearch
from abi.arm_planning.joint_search.joint_space import JointSpace
from abi.arm_planning.joint_search.search_joints import (
    JointSearch,
    JointSearchEffort,
    search_joints,
)
from abi.arrays import FloatArray, read_only

_TRIED = (0.0, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3)
"""Fractions of the path by which an end of the part may be moved outwards."""
_SPREADS = (0.0, 0.2, 0.4, 0.7, 1.0)
"""Distances from the path, in each joint, within which clear positions are sought, [rad]."""
_GUIDED = 4
"""Points of the unconstrained path towards which the search grows first."""


def path_holding(
    held: HeldSearch,
    part: tuple[float, float],
    starts: FloatArray,
    goals: FloatArray,
    effort: JointSearchEffort,
) -> tuple[JointSearch, FloatArray] | None:
    """Find a joint path that holds a direction about between two fractions of its length.

    Args:
        held: the arm, what it keeps clear of, and the direction.
        part: shares of the way, the first below the second; from 0 all starts hold the direction,
            and to 1 all goals do.
        starts: joint positions (k, n), clear and within the limits, [rad] or [unit].
        goals: the same of the goals.
        effort: how long to search.

    Returns:
        The path with what was searched for it, and the joints where the part of it begins and ends,
        (2, n); None if none was found.
    """
    space, (begin, end) = held.space, part
    if begin <= 0 and end >= 1:
        found = held.search(starts, goals, effort)
        return None if found.path is None else (found, found.path[[0, -1]])
    guide = search_joints(space, starts, goals, effort)
    if guide.path is None:
        return None
    random = np.random.default_rng(effort.seed)
    firsts = [begin - away for away in _TRIED] if begin > 0 else None
    lasts = [end + away for away in _TRIED] if end < 1 else None
    near_first = guide.path[:1] if firsts is None else _near(held, guide.path, firsts, random)
    near_last = guide.path[-1:] if lasts is None else _near(held, guide.path, lasts, random)
    if not len(near_first) or not len(near_last):
        return None
    towards = _at(space, guide.path, np.linspace(begin, end, _GUIDED + 2)[1:-1])
    middle = held.search(near_first, near_last, effort, towards)
    if middle.path is None:
        return None
    before = _free(space, guide.path[0], middle.path[0], effort)
    after = _free(space, middle.path[-1], guide.path[-1], effort)
    if before is None or after is None:
        return None
    path = read_only(np.concatenate([before[:-1], middle.path, after[1:]]))
    found = replace(
        middle,
        path=path,
        length=space.distance(path),
        samples=guide.samples + middle.samples,
        proofs=guide.proofs + middle.proofs,
        refused=guide.refused + middle.refused,
    )
    return found, middle.path[[0, -1]]


def _near(
    held: HeldSearch, path: FloatArray, shares: Sequence[float], random: np.random.Generator
) -> FloatArray:
    """Clear joint positions (k, n) that hold the direction, near a path at fractions of its length.

    Where those nearest to the path are not clear, random ones around it are tried.
    """
    space, found = held.space, []
    places = _at(space, path, np.array([one for one in shares if 0 < one < 1]))
    for spread in _SPREADS:
        for joints in places + spread / space.weights * random.normal(size=places.shape):
            near = held.hold.brought_near(joints)
            if near is not None and space.clear(np.stack([near, near])):
                found.append(near)
        if found:
            break
    return np.array(found)


def _at(space: JointSpace, path: FloatArray, shares: FloatArray) -> FloatArray:
    """Joint positions (k, n) at fractions (k,) of a path's length."""
    lengths = np.linalg.norm(np.diff(path, axis=0) * space.weights, axis=1)
    passed = np.concatenate([[0.0], np.cumsum(lengths)]) / lengths.sum()
    return np.stack([np.interp(shares, passed, column) for column in path.T], axis=1)


def _free(
    space: JointSpace, start: FloatArray, end: FloatArray, effort: JointSearchEffort
) -> FloatArray | None:
    """A path between joint positions (n,) that need not hold a direction; None if none was
    found."""
    if (start == end).all():
        return start[None]
    return search_joints(space, start[None], end[None], effort).path
