"""A tree of joint positions grown by a search."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from abi import arguments
from abi.arrays import FloatArray, IntArray, ShortRepr


@dataclass(frozen=True, eq=False, repr=False)
class JointTree(ShortRepr):
    """Joint positions, each but the roots reached from its parent by a proven straight motion.

    Attributes:
        positions: of the joints, (k, n), [rad] or [unit].
        parents: number of each node's parent, a smaller one; -1 of roots, (k,).
    """

    positions: FloatArray
    parents: IntArray

    def __post_init__(self) -> None:
        positions = arguments.numbers("positions", self.positions, (-1, -1))
        arguments.keep(self, positions=positions)

    @property
    def edges(self) -> IntArray:
        """Both nodes of each edge, the parent first, (m, 2)."""
        nodes = np.flatnonzero(self.parents >= 0).astype(np.int32)
        return np.stack([self.parents[nodes], nodes], axis=1)

    def way_to(self, node: int) -> FloatArray:
        """Joint positions (k, n) from a root to a node."""
        numbers = []
        while node >= 0:
            numbers.append(node)
            node = int(self.parents[node])
        return np.asarray(self.positions[numbers[::-1]])
