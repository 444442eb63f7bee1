"""Surroundings and capsules of a URDF arm, in the format of the kernels."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from abi.arm.separate_chain_kernels import Bodies
from abi.arm.solid_rows import FLOOR, Own, RowTable
from abi.arm.surroundings import Surroundings, surroundings_from
from abi.arm.urdf_arm import UrdfArm
from abi.arrays import flat, read_only
from abi.obstacles.obstacle_set import ObstacleSet


def chain_surroundings(
    arm: UrdfArm, obstacles: ObstacleSet, lowest: float, table: RowTable | None = None
) -> Surroundings:
    """Surroundings of an arm, without the arm itself.

    The floor is level with the base, or with the bottom of the workspace if that is lower. Links
    that stand still, and the first one that moves, may touch it.

    Args:
        arm: the arm.
        obstacles: the solids.
        lowest: height of the workspace's bottom, [unit].
        table: with the rows of obstacles as they were; None to make all anew.
    """
    moves = np.array([one.frame >= 1 for one in arm.capsules])[:, None]
    own = Own(np.zeros(0), np.array([FLOOR], dtype=np.int32), moves)
    solids = (table or RowTable())(obstacles, own)
    size = float(np.abs(arm.base).max()) + 2 * arm.reach
    return surroundings_from(solids, own, size, min(float(arm.base[2]), lowest))


@lru_cache(maxsize=16)
def bodies_of(arm: UrdfArm) -> Bodies:
    """Capsules of an arm in the format of the kernels, for coordinates in [rad] and [m]."""
    frames = np.array([one.frame for one in arm.capsules], dtype=np.int32)
    return Bodies(
        frames=read_only(frames),
        ends=flat(np.stack([one.ends for one in arm.capsules])),
        radii=arm.radii,
        levers=flat(arm.levers * arm.scales),
        pairs=read_only(np.ascontiguousarray(arm.pairs).reshape(-1)),
        pair_levers=flat(arm.pair_levers * arm.scales),
        scale=1 / arm.metres,
    )
