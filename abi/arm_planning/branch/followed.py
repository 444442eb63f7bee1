"""Joints of an arm with its tool led along places."""

from __future__ import annotations

from typing import NamedTuple

from abi.arrays import FloatArray


class Followed(NamedTuple):
    """Joints along a polyline, a curve or a motion.

    Attributes:
        parameters: of its places, vertex k of a polyline being k; of a motion times, (m,), [s].
        joints: joint positions there, (m, n), [rad] or [unit].
        missed: distance by which each place is missed, (m,), [unit].
    """

    parameters: FloatArray
    joints: FloatArray
    missed: FloatArray
