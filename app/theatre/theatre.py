"""Searches stopped at a step, and the question "which node next?"."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.search.compare import COMPARED
from abi.search.replay import SearchState
from abi.search.search import SEARCHES
from abi.search.trace import NO_NODES
from app.ui.numbers import format_length, with_minus

_WRITTEN = {"yours": "Your search", "right": "The right one"}
_MOST_DIGITS = 12
_NEAR = 0.04
"""Angle, [rad], from a node within which a click means it."""


@dataclass(frozen=True, eq=False)
class Theatre:
    """Picture of one search, of three that race, or of a student's beside the right one.

    Attributes:
        name: of the search, in :data:`abi.search.compare.COMPARED`.
        state: the search at the step shown.
        race: (name, state) of each search of a race; empty without one.
        asking: whether the next node is to be guessed.
        voted: whether a class votes on it, so that nothing may tell it.
        clicked: node that was clicked before; -1 for none.
        said: of it, as HTML; empty for nothing.
        is_wrong: whether it was a wrong guess.
        widget: name by which the page sets the widget that takes a letter for an answer.
        kept: nodes that had a letter before, in the order of the letters; -1 for none.
    """

    name: str
    state: SearchState
    race: tuple[tuple[str, SearchState], ...] = ()
    asking: bool = False
    voted: bool = False
    clicked: int = -1
    said: str = ""
    is_wrong: bool = False
    widget: str = ""
    kept: tuple[int, ...] = ()

    @property
    def open_question(self) -> bool:
        """Whether nothing may tell the next node: it is asked, and no wrong one was chosen."""
        return self.asking and not self.is_wrong and not self.state.done

    @property
    def ringed(self) -> IntArray:
        """Nodes that may be visited next; none while they are to be guessed."""
        return NO_NODES if self.open_question else self.state.candidates()


def node_at(points: FloatArray, nodes: IntArray, origin: FloatArray, direction: FloatArray) -> int:
    """The node that a ray means, the one that it passes at the least angle; -1 for none near.

    Args:
        points: places (n, 3) of all nodes, [unit], world.
        nodes: (k,) those that may be meant.
        origin: of the ray (3,), [unit], world.
        direction: of the ray (3,), a unit vector.
    """
    if len(nodes) == 0:
        return -1
    to_node = points[nodes] - origin
    ahead = to_node @ direction
    aside = np.linalg.norm(to_node - ahead[:, None] * direction, axis=1)
    angle = np.where(ahead > 0, np.arctan2(aside, ahead), np.inf)
    nearest = angle <= max(2.0 * float(angle.min()), 0.2 * _NEAR)
    # of several behind each other the one in front
    best = int(np.where(nearest, ahead, np.inf).argmin())
    return int(nodes[best]) if angle[best] <= _NEAR else -1


def judge(state: SearchState, node: int, goes_on: bool = False) -> tuple[bool, str]:
    """Check whether a node may be visited next, and why, as HTML with the present numbers.

    Args:
        state: the search at its step.
        node: the one that was chosen.
        goes_on: whether the search goes on with it where several tie.
    """
    if state.following < 0:
        return False, "The search has ended: nothing comes next."
    queue = state.trace.queue
    if state.may_follow(node):
        if queue == "first_in":
            return True, f"no. {order_label(state, node)} has waited longest: first in, first out."
        near = "" if state.is_least(node) else ", up to what the search tells apart,"
        least = f"{_sum(state, node)} is{near} the least of all that wait."
        return True, least + _others(state, node, goes_on)
    if not np.isfinite(state.cost[node]):
        return False, "it has not been reached: no edge leads there from a visited node."
    if node in state.closed:
        return False, "it has been visited, and its cost has not fallen since."
    if queue == "first_in":
        first = order_label(state, state.following)
        own = order_label(state, node)
        return (
            False,
            f"it is no. {own} in the line, and no. {first} still waits: first in, first out.",
        )
    digits = _digits_apart(state, node, state.following)
    least = labels(state, state.following, digits)[2]
    return False, f"{_sum(state, node, digits)}, and one that waits has only {least}."


def priorities(state: SearchState) -> FloatArray:
    """What orders the open nodes (o,), least first: f, or a number in line; 0 in rounds.

    The numbers in line go on from step to step: the node visited last has the step's.
    """
    if state.trace.queue == "best_first":
        return state.promise(state.open)
    places = np.zeros(len(state.cost))
    if state.trace.queue == "first_in":
        line = state.queue(len(state.open))
        places[line] = state.step + np.arange(1, len(line) + 1)
    return places[state.open]


def order_label(state: SearchState, node: int) -> str:
    """What orders one open node, as text; "–" of another in a line."""
    if state.trace.queue == "best_first":
        return labels(state, node)[2]
    places = priorities(state)[state.open == node]
    return f"{places[0]:.0f}" if len(places) else "–"


def decimals(state: SearchState) -> int:
    """Decimals of all costs that are told at a step, as many as its largest has by itself."""
    reached = np.flatnonzero(np.isfinite(state.cost)).astype(np.int32)
    largest = float(np.abs(state.promise(reached)).max(initial=0.0))
    return len(format_length(largest).partition(".")[2])


def rounded(state: SearchState, nodes: IntArray, digits: int) -> FloatArray:
    """g, h and f of nodes (k, 3), rounded so that equal f stay equal and f = g + h adds up.

    For that h may be off by one in its last digit, as g and f are rounded for themselves.
    """
    # the ninth digit is not the search's but the computer's
    exact = np.stack([state.cost[nodes], state.to_go(nodes), state.promise(nodes)], axis=1)
    told = np.round(np.round(exact, max(9, digits)), digits)
    if state.trace.factors == (1.0, 1.0):
        known = np.isfinite(told[:, 0])
        told[known, 1] = np.round(told[known, 2] - told[known, 0], digits)
    return np.asarray(told + 0.0)


def labels(state: SearchState, node: int, digits: int | None = None) -> tuple[str, str, str]:
    """g, h and f of a node, as text; "∞" where it is not reached."""
    digits = decimals(state) if digits is None else digits
    told = rounded(state, np.array([node], np.int32), digits)[0].tolist()
    g, h, f = (with_minus(f"{x:,.{digits}f}") if np.isfinite(x) else "∞" for x in told)
    return g, h, f


def _digits_apart(state: SearchState, node: int, other: int) -> int:
    """Decimals from the usual ones on with which the f of two nodes differ as they are told."""
    usual = decimals(state)
    for digits in range(usual, _MOST_DIGITS):
        if labels(state, node, digits)[2] != labels(state, other, digits)[2]:
            return digits
    return usual


def where(state: SearchState, node: int) -> str:
    """Position of a node, [unit], as text."""
    points = state.trace.arcs.points
    place = (f"{x:.3g}" for x in points[node % len(points)] + 0.0)
    return with_minus(f"({', '.join(place)})")


def one_way_search(name: str) -> str:
    """The search itself where it takes one-way edges, else the nearest one that does."""
    return COMPARED[name].substitute or name


def label_of(name: str) -> str:
    """Name of a search on the page."""
    return _WRITTEN[name] if name in _WRITTEN else COMPARED[name].label


def race_of(name: str) -> tuple[str, ...]:
    """The three searches that race: the chosen one among them."""
    first = tuple(SEARCHES)[:3]
    return first if name in first else (name, *first[:2])


def formula(state: SearchState, g: str = "g", h: str = "h") -> str:
    """The sum f that a best-first search makes least, such as ``g + h``."""
    return " + ".join(
        f"{_factor(k)}{x}" for k, x in zip(state.trace.factors, (g, h), strict=True) if k
    )


def _others(state: SearchState, node: int, goes_on: bool) -> str:
    """What is to be said of the others that tie with a node that is right."""
    tied = len(state.candidates()) - 1
    if not tied:
        return ""
    others = "Another one ties" if tied == 1 else f"{tied} others tie"
    if node == state.following or goes_on:
        return f" {others} with it, and the search goes on with yours."
    taken = where(state, state.following)
    a, b = state.trace.factors
    why = ", the one found last" if b > a else ""
    return f" {others} with it; of these the search takes the one at {taken} first{why}."


def _sum(state: SearchState, node: int, digits: int | None = None) -> str:
    """Priority of one node, as a sum."""
    g, h, f = labels(state, node, digits)
    numbers = formula(state, g, h)
    equals = "=" if all(k in (0.0, 1.0) for k in state.trace.factors) else "≈"
    total = "" if numbers == f else f" {equals} {f}"
    told = formula(state) if formula(state) in ("g", "h") else f"f = {formula(state)}"
    return f"its {told} = {numbers}{total}"


def _factor(k: float) -> str:
    return "" if k == 1 else f"{k:.3g}·"
