"""Another pose of an arm, in which it leads the tool along the same motion."""

from __future__ import annotations

from typing import NamedTuple

from abi.arrays import FloatArray


class OtherPoses(NamedTuple):
    """Another pose that leads the tool along the motion.

    Attributes:
        time: of the samples, (k,), [s].
        positions: joints, (k, n), [rad] or [unit].
        missed: by how much the tool is beside its place, (k,), [unit].
    """

    time: FloatArray
    positions: FloatArray
    missed: FloatArray
