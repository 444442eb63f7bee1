"""The loop of every proof: pieces of a path are halved until each is separated from everything.

A path is a curve or a motion of joints. A proof gives the loop two functions: one that halves a
piece, and one that tries to separate a piece from what its parents were not separated from.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

from abi.arrays import FloatArray
from abi.compilation.jitable import jitable
from abi.curves.clearance.separation_kernels import (
    CERTIFIED,
    NO_PLANE,
    UNDECIDED,
    SeparatingPlane,
    divide,
)

MOST_HALVINGS = 48
"""Largest number of halvings of one polynomial: finer than any distance worth deciding."""
SPENT = 4
"""Outcome of a piece that was not tried, because the budget of tries had ended."""


class Piece(NamedTuple):
    """A part of a path between two parameters.

    Attributes:
        first: point of a curve, or knot of a motion, with which it begins.
        last: point before which it ends, or first knot that is not before its end.
        halvings: of its polynomial; 0 of several.
        start: first parameter.
        end: last parameter.
    """

    first: int
    last: int
    halvings: int
    start: float
    end: float


Halves = tuple[Piece, Piece]
"""Both halves of a piece; the second begins at the parameter at which it is halved."""


class ProofLists(NamedTuple):
    """Lists that a proof fills; a pair is a number that a proof gives to two bodies.

    Attributes:
        planes: what separates pairs.
        candidates: pairs, those of every pending piece, a piece's own together.
        work: pairs of the present piece, the next one last.
    """

    planes: list[SeparatingPlane]
    candidates: list[int]
    work: list[int]


@jitable
def new_lists() -> ProofLists:
    """Empty lists of a proof; that of planes begins with one that means nothing."""
    lists = ProofLists([NO_PLANE], [0], [0])
    lists.candidates.clear()
    return lists


class PairsLeft(NamedTuple):
    """Pairs that a proof does not separate.

    Attributes:
        planes: of each its piece, and the pose as level; there is no direction.
        outcomes: of each UNDECIDED, SPENT, or why it cannot be separated.
    """

    planes: list[SeparatingPlane]
    outcomes: list[int]


@jitable
def none_left() -> PairsLeft:
    """Empty lists of pairs that are not separated; both begin with one that means nothing."""
    return PairsLeft([NO_PLANE], [0])


Ending = tuple[int, float, int, float]
"""Outcome of a proof, and the parameter, the pair and its distance where it is not proven."""


@jitable
def _leave(
    left: PairsLeft, candidates: list[int], known: tuple[int, int], piece: Piece, ending: Ending
) -> None:
    """Note a range of the candidates as left, for the reason with which a piece ends a proof."""
    outcome, at, _, _ = ending
    for i in range(known[0], known[1]):
        pair, none = candidates[i], (0.0, 0.0, 0.0)
        left.planes.append(SeparatingPlane(piece.start, piece.end, pair, none, at))
        left.outcomes.append(outcome)


class Attempt(NamedTuple):
    """Result of the try to separate a piece; what is left of several pairs is among the candidates.

    Attributes:
        outcome: UNDECIDED, or why the piece cannot be separated.
        pair: that cannot be, or one that is left; -1 where it is separated in all.
        distance: of this pair at the pose, or where the piece is halved, [unit].
        tries: pairs that were tried.
        size: how far the piece goes, or what is left of it moves, [unit].
    """

    outcome: int
    pair: int
    distance: float
    tries: int
    size: float


class HalvingLimits(NamedTuple):
    """Conditions under which pieces are not halved any more, and in which order they are tried.

    Attributes:
        width: points of one polynomial of a curve; 1 of a motion.
        finest: pieces of a smaller size are not halved, [unit].
        most_tries: tries after which it ends.
        shortest: length of parameters from which on a piece that cannot be separated is not halved;
            inf ends the proof with the first such piece.
        to_the_end: whether the other pieces are tried once one is left.
        longest_first: whether all pieces of a length are tried before their halves, so that a
            contact shows at one of the first; otherwise one half is done with before the other is
            begun, which takes less room.
    """

    width: int
    finest: float
    most_tries: int
    shortest: float
    to_the_end: bool
    longest_first: bool


_Problem = TypeVar("_Problem")


@jitable(forceinline=True)
def separate_pieces(
    problem: _Problem,
    whole: Piece,
    halves_of: Callable[[_Problem, Piece], Halves],
    attempt: Callable[[_Problem, Piece, Piece, tuple[int, int], ProofLists], Attempt],
    limits: HalvingLimits,
    lists: ProofLists,
    left: PairsLeft,
) -> Ending:
    """Separate every piece of a path from everything, or find one that is not separated.

    A piece carries the pairs that its parents were not separated in; what is left of them is tried
    on both halves. Runs of polynomials are halved between two of them.

    Args:
        problem: given to both functions.
        whole: the path; its pairs are the candidates in ``lists``, or found by the first attempt.
        halves_of: halves of a piece.
        attempt: tries the candidates in a range of ``lists`` on a piece, whose second half it gets.
        limits: where halving ends.
        lists: written.
        left: takes what is not separated.

    Returns:
        Where the last piece is that is left; CERTIFIED if none is.
    """
    candidates = lists.candidates
    pending, first, tries = [(whole, 0, len(candidates))], 0, 0
    ending = CERTIFIED, 0.0, -1, math.inf
    while len(pending) > first:
        if limits.longest_first:
            piece, lowest, highest = pending[first]
            first += 1
        else:
            piece, lowest, highest = pending.pop()
            while len(candidates) > highest:
                candidates.pop()
        known = len(candidates)
        ahead, behind = halves_of(problem, piece)
        at = behind.start
        if limits.to_the_end and tries > limits.most_tries:
            ending = SPENT, at, -1, 0.0
            _leave(left, candidates, (lowest, highest), piece, ending)
            continue
        outcome, pair, distance, tried, size = attempt(
            problem, piece, behind, (lowest, highest), lists
        )
        tries += tried
        if outcome == UNDECIDED and pair < 0:
            continue
        run = piece.last - piece.first > limits.width
        final = piece.halvings == MOST_HALVINGS or size < limits.finest
        final = not run and (final or not piece.start < at < piece.end)
        if outcome != UNDECIDED and piece.end - piece.start <= limits.shortest:
            final = True
        if final or (tries > limits.most_tries and not limits.to_the_end):
            ending = outcome, at, pair, distance
            _leave(left, candidates, (known, len(candidates)), piece, ending)
            if limits.to_the_end:
                continue
            return ending
        pending.append((behind, known, len(candidates)))
        pending.append((ahead, known, len(candidates)))
    return ending


class CurvePoints(NamedTuple):
    """A curve by its Bézier points.

    Attributes:
        points: of its s polynomials, and behind them room for halves, flat
            (3 (s + 2 MOST_HALVINGS + 2) width,).
        breaks: parameters between the polynomials (s + 1,).
        width: points of a polynomial.
    """

    points: FloatArray
    breaks: FloatArray
    width: int


@jitable
def whole_curve(points: FloatArray, breaks: FloatArray, width: int) -> tuple[CurvePoints, Piece]:
    """A curve, see :class:`CurvePoints`, and the piece that is all of it."""
    spans = len(breaks) - 1
    whole = Piece(0, spans * width, 0, breaks[0], breaks[spans])
    return CurvePoints(points, breaks, width), whole


@jitable(forceinline=True)
def halves_of_curve(problem: tuple[CurvePoints, *tuple[Any, ...]], piece: Piece) -> Halves:
    """Halve a piece of the curve that a problem begins with.

    A run of polynomials is divided between two of them, and one polynomial by de Casteljau: there
    is room for its halves behind the points, at each number of halvings for two.
    """
    points, breaks, width = problem[0]
    if piece.last - piece.first > width:
        span = (piece.first + piece.last) // width // 2
        at = breaks[span]
        first, middle, last, halvings = piece.first, span * width, piece.last, 0
    else:
        at = 0.5 * (piece.start + piece.end)
        first = (len(breaks) - 1 + 2 * piece.halvings) * width
        middle, last, halvings = first + width, first + 2 * width, piece.halvings + 1
        share = (at - piece.start) / (piece.end - piece.start)
        divide(points, 3 * piece.first, points, 3 * first, 3 * middle, width, share)
    ahead = Piece(first, middle, halvings, piece.start, at)
    return ahead, Piece(middle, last, halvings, at, piece.end)


@jitable
def whole_motion(knots: int) -> Piece:
    """The piece that is all of a motion from its first knot, number 0, to its last."""
    return Piece(0, knots - 1, 0, 0.0, 1.0 * (knots - 1))


@jitable(forceinline=True)
def halves_of_motion(problem: object, piece: Piece) -> Halves:
    """Halve a piece of a motion whose parameter is k at knot k: one of several knots at a knot."""
    at, middle = 0.5 * (piece.start + piece.end), piece.last
    first, halvings = piece.first, piece.halvings + 1
    if piece.last - piece.first > 1:
        middle = int(at)
        at, first, halvings = 1.0 * middle, middle, 0
    ahead = Piece(piece.first, middle, halvings, piece.start, at)
    return ahead, Piece(first, piece.last, halvings, at, piece.end)
