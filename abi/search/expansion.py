"""What a search of every plan finds out."""

from __future__ import annotations

from typing import NamedTuple

from abi.arrays import FloatArray, IntArray


class Expansion(NamedTuple):
    """What a search found out about the nodes.

    Attributes:
        costs: (n,) least cost from the start; inf where it was not reached.
        parents: (n,) the node before; -1 where there is none.
        order: (expanded,) node ids in the order of expansion.
        relaxed: number of edges examined.
    """

    costs: FloatArray
    parents: IntArray
    order: IntArray
    relaxed: int
