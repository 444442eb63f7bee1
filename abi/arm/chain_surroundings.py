"""Surroundings and capsules of a URDF arm, in the format of the kernels."""

from __future__ import annotations

import numpy as np

from abi.arm.separate_chain_kernels import Bodies
from abi.arm.surroundings import (
    FLOOR,
    Surroundings,
    largest_coordinate,
    mesh_numbers,
    outermost,
    solid_rows,
)
from abi.arm.urdf_arm import UrdfArm
from abi.arrays import flat, read_only
from abi.obstacles.obstacle_set import ObstacleSet


def chain_surroundings(arm: UrdfArm, obstacles: ObstacleSet, lowest: float) -> Surroundings:
    """Surroundings of an arm, without the arm itself.

    The floor is level with the base, or with the bottom of the workspace if that is lower. Links
    that stand still, and the first one that moves, may touch it.

    Args:
        arm: the arm.
        obstacles: the solids.
        lowest: height of the workspace's bottom, [unit].
    """
    solids = solid_rows(obstacles)
    asked = np.tile(outermost(solids.inside), (len(arm.capsules), 1))
    asked[:, -1] = [one.frame >= 1 for one in arm.capsules]
    size = float(np.abs(arm.base).max()) + 2 * arm.reach + largest_coordinate(solids.rows)
    numbers = read_only(np.append(solids.numbers, np.int32(FLOOR)).astype(np.int32))
    return Surroundings(
        rows=read_only(solids.rows),
        inside=read_only(solids.inside.reshape(-1)),
        numbers=numbers,
        meshes=mesh_numbers(obstacles, numbers),
        asked=read_only(asked),
        floor=min(float(arm.base[2]), lowest),
        size=size,
    )


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
