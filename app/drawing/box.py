"""Corners and edges of boxes along the axes."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import ArrayLike

from abi.arrays import FloatArray, read_only

_CHOICES = read_only(np.array(list(itertools.product((0, 1), repeat=3))))
_EDGES = [(a, b) for a, b in itertools.combinations(range(8), 2) if (a ^ b).bit_count() == 1]


def box_corners(low: ArrayLike, high: ArrayLike) -> FloatArray:
    """The corners (8, 3) of the box with two opposite corners (3,)."""
    return np.where(_CHOICES, high, low)


def box_edges(low: ArrayLike, high: ArrayLike) -> FloatArray:
    """The edges (12, 2, 3) of the box with two opposite corners (3,)."""
    return box_corners(low, high)[_EDGES]
