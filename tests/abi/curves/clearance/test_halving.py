"""Laws of the loop that all proofs share, on a problem whose answer is known.

Pair p is separated on a piece unless the piece holds the place of p; there it touches, or is left
undecided.
"""

from __future__ import annotations

import itertools
import math

from hypothesis import given
from hypothesis import strategies as st

from abi.curves.clearance.separation_kernels import (
    CERTIFIED,
    REFUTED,
    SPENT,
    UNDECIDED,
    Attempt,
    Ending,
    HalvingLimits,
    Piece,
    ProofLists,
    SeparatingPlane,
    halves_of_motion,
    new_lists,
    separate_pieces,
    whole_motion,
)

FINEST = 0.01
PLACES = st.lists(st.floats(0.0, 1.0) | st.just(math.inf), min_size=1, max_size=4)
"""Where each pair touches, as a part of the motion; inf: nowhere."""
Touching = tuple[list[float], bool]
"""Places of all pairs, and whether touching is seen."""


def attempt(
    problem: Touching, piece: Piece, behind: Piece, known: tuple[int, int], lists: ProofLists
) -> Attempt:
    """Separate the pairs that do not touch within a piece, with a try each."""
    places, seen = problem
    touching = -1
    for pair in lists.candidates[known[0] : known[1]]:
        if piece.start <= places[pair] <= piece.end:
            touching = pair
            lists.candidates.append(pair)
        else:
            plane = SeparatingPlane(piece.start, piece.end, pair, (0.0, 0.0, 1.0), behind.start)
            lists.planes.append(plane)
    refuted = seen and touching >= 0
    tries, size = known[1] - known[0], piece.end - piece.start
    return Attempt(REFUTED if refuted else UNDECIDED, touching, 0.0, tries, size)


def prove(problem: Touching, knots: int, limits: HalvingLimits) -> tuple[Ending, ProofLists]:
    """Run the loop on all pairs."""
    lists = new_lists()
    lists.candidates.extend(range(len(problem[0])))
    whole = whole_motion(knots)
    ending = separate_pieces(problem, whole, halves_of_motion, attempt, limits, lists)
    return ending, lists


@given(PLACES, st.integers(2, 9), st.booleans(), st.booleans())
def test_every_pair_is_separated_or_left_on_pieces_that_tile_the_whole(
    shares: list[float], knots: int, seen: bool, longest_first: bool
) -> None:
    places = [share * (knots - 1) for share in shares]
    limits = HalvingLimits(1, FINEST, 10**6, FINEST, True, longest_first)
    ending, lists = prove((places, seen), knots, limits)
    assert (ending[0] == CERTIFIED) == all(map(math.isinf, places))
    for pair, place in enumerate(places):
        kept = [one for one in lists.left[1:] if one.obstacle == pair]
        assert all(one.start <= place <= one.end <= one.start + FINEST for one in kept)
        assert bool(kept) == math.isfinite(place)
        tiles = sorted((one.start, one.end) for one in lists.planes[1:] if one.obstacle == pair)
        tiles = sorted(tiles + [(one.start, one.end) for one in kept])
        assert tiles[0][0] == 0.0
        assert tiles[-1][1] == knots - 1
        assert all(one[1] == other[0] for one, other in itertools.pairwise(tiles))


@given(PLACES, st.integers(2, 9), st.integers(0, 40))
def test_what_a_budget_leaves_untried_is_told(
    shares: list[float], knots: int, most_tries: int
) -> None:
    places = [share * (knots - 1) for share in shares]
    limits = HalvingLimits(1, FINEST, most_tries, math.inf, True, False)
    _, lists = prove((places, False), knots, limits)
    covered = [0.0] * len(places)
    for one in (*lists.planes[1:], *lists.left[1:]):
        covered[one.obstacle] += one.end - one.start
    assert all(math.isclose(length, knots - 1) for length in covered)
    assert set(lists.outcomes[1:]) <= {SPENT, UNDECIDED}


@given(PLACES, st.integers(2, 9), st.booleans())
def test_a_proof_that_is_to_end_does_so_with_the_first_piece_that_touches(
    shares: list[float], knots: int, longest_first: bool
) -> None:
    places = [share * (knots - 1) for share in shares]
    limits = HalvingLimits(1, FINEST, 10**6, math.inf, False, longest_first)
    ending, _ = prove((places, True), knots, limits)
    first = 0.5 * (knots - 1) if knots == 2 else math.floor(0.5 * (knots - 1))
    assert ending[:2] == ((CERTIFIED, 0.0) if all(map(math.isinf, places)) else (REFUTED, first))
