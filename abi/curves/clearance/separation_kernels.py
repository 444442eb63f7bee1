"""Separation of pieces of a path from everything by planes: what all proofs of clearance share.

A path is a curve or a motion of joints, whose pieces are halved in one loop until each is
separated (:func:`separate_pieces`). A proof gives the loop two functions: one that halves a piece,
and one that tries to separate a piece from what its parents were not separated from.

Plain Python that numba compiles with its caller; uncompiled it runs on lists. A point is three
successive numbers of a flat array; a piece of a curve is a run of such points, whose convex hull
contains that stretch of the curve. De Casteljau's algorithm divides it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import numpy as np

from abi.arrays import FloatArray
from abi.compilation.jitable import jitable
from abi.obstacles.vector_kernels import Vec3, dot, vec3_at

# inlined: calls for each piece of a curve, in which lists and arrays would be counted in and out
_inlined = jitable(forceinline=True)

Numbers = FloatArray | list[float]


@_inlined
def divide(
    points: Numbers, piece: int, into: Numbers, left: int, right: int, width: int, share: float
) -> None:
    """De Casteljau: both parts of a curve, divided at a share of it.

    Args:
        points: the curve's are the ``width`` ones from ``points[piece]`` on.
        piece: index.
        into: takes the parts, from ``into[left]`` and ``into[right]`` on; written.
        left, right: indices.
        width: points of the curve.
        share: in (0, 1).
    """
    for i in range(3 * width):
        into[right + i] = points[piece + i]
    for order in range(width):
        for k in range(3):
            into[left + 3 * order + k] = into[right + k]
        for i in range(right, right + 3 * (width - 1 - order)):
            into[i] = (1 - share) * into[i] + share * into[i + 3]


@_inlined
def extent_of(points: Numbers, start: int, stop: int) -> tuple[Vec3, Vec3]:
    """Low and high corner of the box around the points in ``points[start:stop]``."""
    x0, y0, z0 = vec3_at(points, start)
    x1, y1, z1 = x0, y0, z0
    for i in range(start + 3, stop, 3):
        x0, x1 = min(x0, points[i]), max(x1, points[i])
        y0, y1 = min(y0, points[i + 1]), max(y1, points[i + 1])
        z0, z1 = min(z0, points[i + 2]), max(z1, points[i + 2])
    return (x0, y0, z0), (x1, y1, z1)


CERTIFIED, REFUTED, UNDECIDED = 0, 1, 2
FINEST = 2.0**-36
"""Pieces smaller than this part of the largest coordinate are not halved."""

UNIT = 2.0**-53
"""Largest rounding error of one operation, as a part of its result."""
PER_SIZE = 128
"""Rounding of a separation, in units of ``UNIT`` times the coordinates: what is always there."""
PER_DEGREE = 16
"""The same for each degree: of the Bézier points."""
PER_HALVING = 12
"""The same for each degree and halving."""
PER_MARGIN = 64
"""The same in units of ``UNIT`` times the margin: normals are nearly of length 1."""
TINY = 2.0**-510
"""Length from which on a direction can be trusted: squares of shorter ones lose digits."""


class SeparatingPlane(NamedTuple):
    """A plane between a piece of the curve and an obstacle.

    Attributes:
        start: first parameter of the piece.
        end: last parameter.
        obstacle: index.
        direction: unit normal, from the obstacle to the curve.
        level: its least product with the piece, [unit].
    """

    start: float
    end: float
    obstacle: int
    direction: Vec3
    level: float


NO_PLANE = SeparatingPlane(0.0, 0.0, 0, (0.0, 0.0, 0.0), 0.0)
"""First of every list of planes, so that its type is known."""

Outcome = tuple[int, float, int, float, FloatArray]
"""The decision; parameter, obstacle and distance of the place that is not certified; the planes
(k, 7)."""


@jitable
def table_of(planes: list[SeparatingPlane]) -> FloatArray:
    """The planes as rows (k, 7), without the first, which means nothing."""
    table = np.empty((len(planes) - 1, 7))
    for i in range(1, len(planes)):
        plane, row = planes[i], table[i - 1]
        row[0], row[1], row[2] = plane.start, plane.end, plane.obstacle
        row[3], row[4], row[5] = plane.direction
        row[6] = plane.level
    return table


@jitable
def allowance_of(scale: float, degree: int, halvings: int, margin: float) -> float:
    """Rounding error of a separation, [unit]: see ``abi.curves.clearance.certificate``."""
    per_scale = PER_SIZE + (PER_DEGREE + PER_HALVING * halvings) * degree
    return UNIT * (per_scale * scale + PER_MARGIN * abs(margin))


@jitable
def apart_along_axis(low: Vec3, high: Vec3, extent: tuple[Vec3, Vec3]) -> tuple[float, Vec3]:
    """Distance along an axis from a box low..high to that around a piece, and the direction.

    A long piece that passes a face obliquely is behind that face all the same.
    """
    (x0, y0, z0), (x1, y1, z1) = extent
    gx = max(x0 - high[0], low[0] - x1)
    gy = max(y0 - high[1], low[1] - y1)
    gz = max(z0 - high[2], low[2] - z1)
    gap = max(gx, gy, gz)
    if gz == gap:
        return gap, (0.0, 0.0, 1.0 if z0 - high[2] == gap else -1.0)
    if gx == gap:
        return gap, (1.0 if x0 - high[0] == gap else -1.0, 0.0, 0.0)
    return gap, (0.0, 1.0 if y0 - high[1] == gap else -1.0, 0.0)


@jitable
def least_product(points: FloatArray, first: int, last: int, direction: Vec3) -> float:
    """Least product of a direction with the points from ``first`` up to ``last``."""
    least = math.inf
    for i in range(3 * first, 3 * last, 3):
        level = dot(direction, vec3_at(points, i))
        if level < least:
            least = level
    return least


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
        left: pairs that are not separated: of each its piece, and the pose as level; there is no
            direction.
        outcomes: of each of these UNDECIDED, SPENT, or why it cannot be separated.
    """

    planes: list[SeparatingPlane]
    candidates: list[int]
    work: list[int]
    left: list[SeparatingPlane]
    outcomes: list[int]


@jitable
def new_lists() -> ProofLists:
    """Empty lists of a proof; those of planes and of outcomes begin with what means nothing."""
    lists = ProofLists([NO_PLANE], [0], [0], [NO_PLANE], [0])
    lists.candidates.clear()
    return lists


Ending = tuple[int, float, int, float]
"""Outcome of a proof, and the parameter, the pair and its distance where it is not proven."""


@jitable
def _leave(lists: ProofLists, known: tuple[int, int], piece: Piece, ending: Ending) -> None:
    """Note a range of the candidates as left, for the reason with which a piece ends a proof."""
    outcome, at, _, _ = ending
    for i in range(known[0], known[1]):
        pair, none = lists.candidates[i], (0.0, 0.0, 0.0)
        lists.left.append(SeparatingPlane(piece.start, piece.end, pair, none, at))
        lists.outcomes.append(outcome)


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
            _leave(lists, (lowest, highest), piece, ending)
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
            _leave(lists, (known, len(candidates)), piece, ending)
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
