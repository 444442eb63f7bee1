"""Search for a joint path on which the tool keeps a direction: two trees on its manifold.

Berenson et al., Manipulation Planning on Constraint Manifolds, 2009 (CBiRRT): trees grow as without
the constraint, but each step is brought back near the direction before its edge is proven.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from abi import progress
from abi.arm_planning.joint_search.held_direction import HeldDirection
from abi.arm_planning.joint_search.joint_space import JointSpace
from abi.arm_planning.joint_search.joint_tree import JointTree
from abi.arm_planning.joint_search.search_joints import JointSearch, JointSearchEffort
from abi.arrays import FloatArray, read_only

_STEP = 0.3
"""Largest length of an edge, [rad]."""
_PROGRESS = 0.1
"""Part of an edge's length by which the edge must approach its target."""
_SHARE = 10
"""Random samples of a search effort for each one of this search, whose steps are slower."""


@dataclass(eq=False)
class HeldSearch:
    """Joint motions that are proven clear and hold a direction.

    Attributes:
        space: the arm and what it keeps clear of.
        hold: the direction.
        proofs: number of edges whose proof was tried.
        refused: number of those that were not proven.
    """

    space: JointSpace
    hold: HeldDirection
    proofs: int = field(default=0, init=False)
    refused: int = field(default=0, init=False)

    def way(self, start: FloatArray, end: FloatArray, most: int = 1_000) -> FloatArray:
        """Joint positions (k, n) from ``start`` towards ``end``, while steps come nearer to it.

        Both hold the direction, the end unless it is only to be gone towards; (n,) each.
        """
        weights = self.space.weights
        longest = min(_STEP, float(np.sqrt(2 * self.hold.tolerance)))
        rows, away = [start], self._distance(start, end)
        ends_there = bool(self.hold.angles(end[None])[0] <= self.hold.tolerance)
        while away > 0 and len(rows) <= most:
            here, direct = rows[-1], away <= longest and ends_there
            share = min(1.0, longest / away)
            there = end if direct else self.hold.brought_near(here + share * (end - here))
            if there is None:
                break
            moved = float(np.linalg.norm((there - here) * weights))
            left = self._distance(there, end)
            if left > away - _PROGRESS * moved or moved < 1e-9 or moved > 3 * longest:
                break
            if not self._is_clear(here, there):
                break
            rows.append(there)
            away = left
        return np.array(rows)

    def search(
        self,
        starts: FloatArray,
        goals: FloatArray,
        effort: JointSearchEffort,
        guide: FloatArray | None = None,
    ) -> JointSearch:
        """Find a path from one of some joint positions (k, n) to one of others.

        Args:
            starts: positions that are clear and hold the direction, [rad] or [unit].
            goals: the same of the goals.
            effort: how long to search.
            guide: positions (k, n) to grow towards before random ones.
        """
        random = np.random.default_rng(effort.seed)
        trees = [JointTree.of(starts), JointTree.of(goals)]
        low, high = self.space.arm.chain.usual_range().T * self.space.arm.scales
        samples, path = 0, None
        first = [goals[0], *([] if guide is None else guide)]
        while path is None and samples < max(effort.samples // _SHARE, 2):
            progress.check()
            grown = samples % 2
            target = first[samples] if samples < len(first) else random.uniform(low, high)
            path = self._grow(trees, grown, target, most=1 if samples else 1_000)
            samples += 1
        if path is not None:
            path = self._shortened(path, random, effort.shortcuts)
        return JointSearch(
            None if path is None else read_only(path),
            np.inf if path is None else self.space.distance(path),
            (trees[0], trees[1]),
            samples,
            self.proofs,
            self.refused,
        )

    def _grow(
        self, trees: list[JointTree], grown: int, target: FloatArray, most: int
    ) -> FloatArray | None:
        """Grow one of two trees towards a target, and the other to it; a path if they meet."""
        weights, (tree, other) = self.space.weights, (trees[grown], trees[1 - grown])
        near = tree.nearest(target, weights)
        way = self.way(tree.positions[near], target, most)
        if len(way) == 1 and most == 1:
            return None
        trees[grown], node = tree.grown(way, near)
        reached = way[-1]
        joint = other.nearest(reached, weights)
        way = self.way(other.positions[joint], reached)
        trees[1 - grown], met = other.grown(way, joint)
        if (way[-1] != reached).any():
            return None
        halves = trees[grown].way_to(node), trees[1 - grown].way_to(met)
        first, last = halves if grown == 0 else halves[::-1]
        return np.concatenate([first, last[-2::-1]])

    def _shortened(self, path: FloatArray, random: np.random.Generator, tries: int) -> FloatArray:
        """The path with shortcuts between random nodes."""
        for _ in range(tries):
            progress.check()
            if len(path) < 3:
                break
            first, last = sorted(random.choice(len(path), 2, replace=False).tolist())
            if last - first < 2:
                continue
            way = self.way(path[first], path[last])
            reached = not (way[-1] != path[last]).any()
            if reached and self.space.distance(way) < self.space.distance(path[first : last + 1]):
                path = np.concatenate([path[:first], way, path[last + 1 :]])
        return path

    def _distance(self, start: FloatArray, end: FloatArray) -> float:
        return float(np.linalg.norm((end - start) * self.space.weights))

    def _is_clear(self, start: FloatArray, end: FloatArray) -> bool:
        """Check whether a straight joint motion is proven clear and holds the direction."""
        if not self.hold.holds_way(start, end):
            return False
        self.proofs += 1
        clear = self.space.clear(np.stack([start, end]))
        self.refused += not clear
        return clear
