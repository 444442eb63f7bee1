"""The few waiting nodes that one compares when asked which is visited next."""

from __future__ import annotations

import numpy as np

from abi.arrays import IntArray, read_only
from abi.search.replay import SearchState
from abi.search.trace import NO_NODES
from app.theatre.theatre import Theatre, decimals, formula, labels, order_label, priorities

LETTERS = "ABCDE"
"""Names of the nodes that are compared."""
_MOST_EQUAL = 2
_TOLD_APART = 4
"""Difference of two f, in their last digit, that is seen although g and h are rounded."""
_EQUAL = 1e-9
_MIX = np.uint64(2654435761)


def lettered(theatre: Theatre) -> dict[str, int]:
    """Nodes that have a letter now, by it; none unless one is asked.

    Each keeps the letter that it had before. While a class votes none has: what is near the next
    one would be told.
    """
    if not theatre.asking or theatre.voted:
        return {}
    answered = theatre.clicked if theatre.open_question else -1
    nodes = compared(theatre.state, answered, theatre.kept).tolist()
    places = dict.fromkeys(LETTERS, -1)
    places.update(zip(LETTERS, (k if k in nodes else -1 for k in theatre.kept), strict=False))
    new = iter([k for k in nodes if k not in theatre.kept])
    named = {letter: next(new, -1) if k < 0 else k for letter, k in places.items()}
    return {letter: k for letter, k in named.items() if k >= 0}


def asks_for_sums(theatre: Theatre) -> bool:
    """Whether who is asked makes f of g and h, which are told: f would be the answer."""
    best_first = theatre.state.trace.queue == "best_first"
    return best_first and theatre.open_question and len(theatre.state.open) > 1


def letter_label(theatre: Theatre, node: int) -> str:
    """What is told at the letter of a node: what orders it, or what that is made of."""
    state = theatre.state
    if not asks_for_sums(theatre):
        return order_label(state, node)
    g, h, _ = labels(state, node)
    if formula(state) == "g":
        return g
    return f"{g} + {h}" if formula(state) == "g + h" else f"g {g}, h {h}"


def compared(state: SearchState, answered: int = -1, before: tuple[int, ...] = ()) -> IntArray:
    """Waiting nodes to compare, at most one for each letter; none where no single node is next.

    One that is right is among them. Of those that tie for the least only two are, where others
    wait, so that there is something to compare. Their order does not tell which is right. A node
    that was ``answered`` before is asked again only where it is the one that is next. Those
    compared ``before`` stay while they wait.
    """
    if state.following < 0:
        return NO_NODES
    n, most = len(state.trace.arcs.points), len(LETTERS)
    turn = (state.open < n) == (state.following < n)
    nodes, order = state.open[turn], priorities(state)[turn]
    tied = np.isin(nodes, state.candidates())
    # those in which no digit differs before those in which the search sees no difference
    same = np.abs(order - order[nodes == state.following]) <= _EQUAL
    left = tied & (nodes != state.following) & (nodes != answered)
    ties = [*nodes[left & same].tolist(), *nodes[left & ~same].tolist()]
    kept = [node for node in ties if node in before]
    first = [state.following, *kept, *(node for node in ties if node not in before)]
    # of sums that a reader cannot tell apart one is right and the other is not
    apart = (
        ~tied & (nodes != answered) & (order > order.min() + _TOLD_APART * 10.0 ** -decimals(state))
    )
    others, order = nodes[apart], order[apart]
    again = np.isin(others, before)
    if len(others) > most:
        least = np.argpartition(order, most)[:most]
        chosen = np.union1d(least, np.flatnonzero(again))
        others, order, again = others[chosen], order[chosen], again[chosen]
    others = others[np.lexsort((others, order, ~again))]
    equal = min(max(_MOST_EQUAL, 1 + len(kept)), most - 1)
    few = [*first[:equal], *others.tolist(), *first[equal:]][:most]
    shuffled = np.array(few, np.int32)
    return read_only(shuffled[np.argsort(lots(shuffled))])


def lots(nodes: IntArray) -> IntArray:
    """Numbers (k,) from 0 to 2^31 that nodes have drawn for good."""
    drawn = (nodes.astype(np.uint64) * _MIX) & np.uint64(0x7FFFFFFF)
    return drawn.astype(np.int32)
