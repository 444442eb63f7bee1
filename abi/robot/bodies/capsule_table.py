"""Bodies of a chain in the format of the kernels: hulls of points, and capsules around them."""

from __future__ import annotations

from typing import NamedTuple

from abi.arrays import FloatArray, IntArray
from abi.compiled import FLOATS, IDS


class Bodies(NamedTuple):
    """Bodies of a chain with m joints and n coordinates: each a hull of points in a capsule.

    Attributes:
        moving: the number of joints, m.
        frames: joint that moves each, -1 where it stands still, (c,).
        ends: of their segments in that frame, or in the world where they stand still, flat
            (6 c,), [m].
        radii: (c,), [unit].
        levers: bound of each one's way for one of each coordinate, flat (c n,), [unit].
        pairs: capsules that are to keep apart, flat (2 p,).
        pair_levers: the same of both ways beside each other, flat (p n,), [unit].
        points: corners of the hulls, in the same frames, flat (3 k,), [m].
        first: number of the first corner of each, last that behind them, (c + 1,).
        roundings: distance from the hull that belongs to each, (c,), [unit].
        point_levers: as ``levers``, of the hulls' corners.
        point_pair_levers: as ``pair_levers``, of the hulls' corners.
        scale: one metre in [unit].
    """

    moving: int
    frames: IntArray
    ends: FloatArray
    radii: FloatArray
    levers: FloatArray
    pairs: IntArray
    pair_levers: FloatArray
    points: FloatArray
    first: IntArray
    roundings: FloatArray
    point_levers: FloatArray
    point_pair_levers: FloatArray
    scale: float


BODIES = Bodies(
    1, IDS, FLOATS, FLOATS, FLOATS, IDS, FLOATS, FLOATS, IDS, FLOATS, FLOATS, FLOATS, 1.0
)
"""Example of bodies."""
