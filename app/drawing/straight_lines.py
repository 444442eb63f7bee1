"""Merging of collinear edges: the fewest lines that draw the same as a lattice's edges."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from abi.arrays import FloatArray, IntArray
from abi.tet_mesh.stencil import Stencil

_OFF = 2.0**46
"""A number greater than that of any node of a lattice."""
_NEAR = 1e-6  # half cells


def straight_lines(
    points: FloatArray, edges: IntArray, stencil: Stencil
) -> tuple[FloatArray, IntArray]:
    """Points (k, 3) and lines (m, 2) that draw the same as ``edges``.

    Equal edges that follow one another become one line, and the points within it are left out.

    Args:
        points: (n, 3), [unit], world: nodes of the lattice, and a few others.
        edges: (e, 2) indices into ``points``, e > 0, each edge once.
        stencil: the lattice's.
    """
    count, places = len(points), _places(points, stencil)
    tails, heads = edges.T
    steps = places.take(heads) - places.take(tails)
    backwards = steps < 0
    tails, heads = np.where(backwards, heads, tails), np.where(backwards, tails, heads)
    row = count * _ranks(np.abs(steps))
    # by kind of step, the node to which it leads from a node; that node itself where to none
    following = np.tile(np.arange(count), row.max() // count + 1)
    following[row + tails] = heads
    reached = np.zeros(len(following), np.bool_)
    reached[row + following[row + tails]] = True
    first = ~reached[row + tails]
    row, starts = row[first], tails[first]
    ends = following[row + starts]
    while not np.array_equal(ahead := following[row + ends], ends):
        ends = ahead
    kept = np.zeros(count, np.bool_)
    kept[starts] = kept[ends] = True
    index = np.cumsum(kept) - 1
    return points[kept], np.stack([index[starts], index[ends]], axis=1)


def _places(points: FloatArray, stencil: Stencil) -> FloatArray:
    """Integers (n,) of the points, in which equal lattice steps have equal differences."""
    halves = (points - stencil.low) * (2 / np.array(stencil.cell))
    whole = np.rint(halves)
    _, y, z = (4.0 * cells + 2 for cells in stencil.cells)
    places = whole @ np.array([y * z, z, 1.0])
    other = np.flatnonzero((np.abs(halves - whole) > _NEAR).any(axis=1))
    places[other] = _OFF * (1 + np.arange(len(other)))
    return np.asarray(places)


def _ranks(numbers: FloatArray) -> NDArray[np.intp]:
    """Rank of each number (e,) among the distinct ones; fast for runs of equal numbers."""
    begins = np.flatnonzero(np.diff(numbers, prepend=-1.0))
    ranks = np.unique(numbers[begins], return_inverse=True)[1]
    return np.repeat(ranks, np.diff(begins, append=len(numbers)))
