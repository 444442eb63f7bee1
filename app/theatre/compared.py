"""The few waiting nodes that one compares when asked which is visited next."""

from __future__ import annotations

import numpy as np

from abi.arrays import IntArray, read_only
from abi.search.replay import SearchState
from abi.search.trace import NO_NODES
from app.theatre.theatre import Theatre, formula, labels, order_label, priorities

LETTERS = "ABCDE"
"""Names of the nodes that are compared."""
_MOST_EQUAL = 2
_TOLD_APART = 0.004
"""Difference of two sums g + h that is seen although g and h are rounded as they are told."""
_MIX = np.uint64(2654435761)


def lettered(theatre: Theatre) -> IntArray:
    """Nodes that have a letter now, in the order of their letters; none unless one is asked.

    While a class votes none has: what is near the next one would be told.
    """
    if not theatre.asking or theatre.voted:
        return NO_NODES
    return compared(theatre.state)


def asks_for_sums(theatre: Theatre) -> bool:
    """Whether who is asked adds g and h, which are told, for f, which is not.

    Where f is one of them, or weighs them, it is told: then there is nothing to learn from adding.
    """
    best_first = theatre.state.trace.queue == "best_first"
    return best_first and formula(theatre.state) == "g + h" and len(lettered(theatre)) > 1


def letter_label(theatre: Theatre, node: int) -> str:
    """What is told at the letter of a node: what orders it, or the sum that is to be added."""
    state = theatre.state
    if not asks_for_sums(theatre):
        return order_label(state, node)
    g, h, _ = labels(state, node)
    return f"{g} + {h}"


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
    # of sums that a reader cannot tell apart one is right and the other is not
    others, order = (part[~tied & (order > order.min() + _TOLD_APART)] for part in (nodes, order))
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
