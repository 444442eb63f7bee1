"""A tree of joint positions grown by a search."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from abi import arguments
from abi.arrays import FloatArray, IntArray, ShortRepr, read_only


@dataclass(frozen=True, eq=False, repr=False)
class JointTree(ShortRepr):
    """Joint positions, each but the roots reached from its parent by a proven straight motion.

    Attributes:
        positions: of the joints, (k, n), [rad] or [unit].
        parents: number of each node's parent, a smaller one; -1 of roots, (k,).
    """

    positions: FloatArray
    parents: IntArray

    @classmethod
    def of(cls, roots: FloatArray) -> Self:
        """A tree of nothing but roots (k, n), [rad] or [unit]."""
        return cls(roots, read_only(np.full(len(roots), -1, np.int32)))

    def __post_init__(self) -> None:
        positions = arguments.numbers("positions", self.positions, (-1, -1))
        arguments.keep(self, positions=positions)

    @property
    def edges(self) -> IntArray:
        """Both nodes of each edge, the parent first, (m, 2)."""
        nodes = np.flatnonzero(self.parents >= 0).astype(np.int32)
        return np.stack([self.parents[nodes], nodes], axis=1)

    def nearest(self, joints: FloatArray, weights: FloatArray) -> int:
        """Number of the node nearest to joint positions (n,), given weights of the joints (n,)."""
        away = (self.positions - joints) * weights
        return int((away**2).sum(axis=1).argmin())

    def grown(self, way: FloatArray, parent: int) -> tuple[JointTree, int]:
        """The tree with a way (k, n) from the node ``parent`` added, and the number of its end."""
        if len(way) == 1:
            return self, parent
        count = len(self.positions)
        behind = np.arange(count, count + len(way) - 2, dtype=np.int32)
        positions = np.concatenate([self.positions, way[1:]])
        parents = np.concatenate([self.parents, [np.int32(parent)], behind])
        return JointTree(read_only(positions), read_only(parents)), len(positions) - 1

    def way_to(self, node: int) -> FloatArray:
        """Joint positions (k, n) from a root to a node."""
        numbers = []
        while node >= 0:
            numbers.append(node)
            node = int(self.parents[node])
        return np.asarray(self.positions[numbers[::-1]])
