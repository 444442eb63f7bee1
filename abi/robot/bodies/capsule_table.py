"""Capsules of a chain in the format of the kernels."""

from __future__ import annotations

from typing import NamedTuple

from abi.arrays import FloatArray, IntArray
from abi.compiled import FLOATS, IDS


class Bodies(NamedTuple):
    """Capsules of a chain with n coordinates.

    Attributes:
        frames: joint that moves each, -1 where it stands still, (c,).
        ends: of their segments in that frame, or in the world where they stand still, flat
            (6 c,), [m].
        radii: (c,), [unit].
        levers: bound of each one's way for one of each coordinate, flat (c n,), [unit].
        pairs: capsules that are to keep apart, flat (2 p,).
        pair_levers: the same of both ways beside each other, flat (p n,), [unit].
        scale: one metre in [unit].
    """

    frames: IntArray
    ends: FloatArray
    radii: FloatArray
    levers: FloatArray
    pairs: IntArray
    pair_levers: FloatArray
    scale: float


BODIES = Bodies(IDS, FLOATS, FLOATS, FLOATS, IDS, FLOATS, 1.0)
"""Example of capsules."""
