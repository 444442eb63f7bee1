"""The few waiting nodes that one compares when asked which is visited next."""

from __future__ import annotations

import numpy as np

from abi.arrays import IntArray, read_only
from abi.search.replay import SearchState
from abi.search.trace import NO_NODES
from app.theatre.theatre import Theatre, priorities

LETTERS = "ABCDE"
"""Names of the nodes that are compared."""
_MOST_EQUAL = 2
_MIX = np.uint64(2654435761)


def lettered(theatre: Theatre) -> IntArray:
    """Nodes that have a letter now, in the order of their letters; none unless one is asked.

    While a class votes none has: what is near the next one would be told.
    """
    if not theatre.asking or theatre.voted:
        return NO_NODES
    return compared(theatre.state)


def compared(state: SearchState) -> IntArray:
    """Waiting nodes to compare, at most one for each letter; none where no single node is next.

    One that is right is among them. Of those that tie for the least only two are, where others
    wait, so that there is something to compare. Their order does not tell which is right.
    """
    if state.following < 0:
        return NO_NODES
    n, most = len(state.trace.arcs.points), len(LETTERS)
    turn = (state.open < n) == (state.following < n)
    nodes, order = state.open[turn], priorities(state)[turn]
    tied = np.isin(nodes, state.candidates())
    first = [state.following, *nodes[tied & (nodes != state.following)].tolist()]
    others, order = nodes[~tied], order[~tied]
    if len(others) > most:
        least = np.argpartition(order, most)[:most]
        others, order = others[least], order[least]
    others = others[np.lexsort((others, order))]
    few = [*first[:_MOST_EQUAL], *others.tolist(), *first[_MOST_EQUAL:]][:most]
    shuffled = np.array(few, np.int32)
    return read_only(shuffled[np.argsort(lots(shuffled))])


def lots(nodes: IntArray) -> IntArray:
    """Numbers (k,) from 0 to 2^31 that nodes have drawn for good."""
    drawn = (nodes.astype(np.uint64) * _MIX) & np.uint64(0x7FFFFFFF)
    return drawn.astype(np.int32)
