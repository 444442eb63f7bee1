"""Check at which configurations a URDF arm touches something.

While the kernel runs as Python, most are decided by numpy, all at once: boxes and capsules show
those that are plainly clear, and corners of hulls those that plainly touch.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from abi import arguments, progress
from abi.arm_planning.certificates.separate_chain_kernels import place_bodies
from abi.arm_planning.exclusion.node_configuration_kernels import (
    NO_BOXES,
    touching_configurations,
)
from abi.arm_planning.world.collision_world_kernels import Obstacles
from abi.arrays import BoolArray, FloatArray, IntArray
from abi.compilation.plain import as_lists
from abi.obstacles.primitive_distances import distances_to_each
from abi.obstacles.primitive_kernels import BOUNDS, WIDTH
from abi.robot.bodies.capsule_table import Bodies
from abi.robot.bodies.chain_capsules import segment_distances
from abi.robot.kinematics.chain_kernels import POSE, ChainTable
from abi.robot.urdf_arm import UrdfArm

_ALLOWANCE = 1e-9
"""For rounding, over the size of arm and obstacles."""
_AT_ONCE = 2000
"""Configurations in one array, at most."""
_FEW = 8
"""Configurations up to which Python is quicker."""


def touching(
    arm: UrdfArm, configurations: FloatArray, around: Obstacles, slack: float, asked: BoolArray
) -> BoolArray:
    """Check at which configurations a capsule is too near to something, or to another, (k,).

    Args:
        arm: the arm.
        configurations: coordinates, flat (k n,), [rad] or [m].
        around: what to keep clear of.
        slack: distance that capsules keep from each other, [unit]; below 0 they are not looked at.
        asked: those to look at, (k,).
    """
    asked = arguments.flags("asked", asked, (len(asked),))
    count = len(asked) * len(arm.scales)
    configurations = arguments.numbers("configurations", configurations, (count,))
    found, open_ = np.zeros(len(asked), dtype=np.bool_), asked
    if not touching_configurations.compiled and np.count_nonzero(asked) > _FEW:
        open_, every = asked.copy(), configurations.reshape(len(asked), -1)
        for some in _parts(asked):
            progress.check()
            table, bodies = arm.chain.table, arm.bodies
            clear, found[some] = _plainly(table, bodies, every[some], around, slack)
            open_[some] = ~clear & ~found[some]
    touching_configurations(
        *(arm.chain.table, arm.bodies, configurations, NO_BOXES, (around, -1)),
        *(slack, open_, found),
    )
    return found


def _parts(asked: BoolArray) -> list[IntArray]:
    """Numbers of the configurations that are asked about, in parts."""
    numbers = np.flatnonzero(asked)
    return np.split(numbers, range(_AT_ONCE, len(numbers), _AT_ONCE))


def _plainly(
    chain: ChainTable, bodies: Bodies, configurations: FloatArray, around: Obstacles, slack: float
) -> tuple[BoolArray, BoolArray]:
    """Where an arm is plainly clear, and where it plainly touches something; the rest is open.

    Args:
        chain: the chain.
        bodies: its capsules.
        configurations: coordinates, (k, n).
        around: what to keep clear of.
        slack: as above.
    """
    poses, ends = _placed(chain, bodies, configurations)
    near = _near_each_other(bodies, ends, slack, around.size)
    found = np.zeros(len(ends), dtype=np.bool_)
    low, high = ends.min(axis=2), ends.max(axis=2)
    asked = around.asked.reshape(len(bodies.frames), -1)
    bounds = around.primitives.reshape(-1, WIDTH)[:, BOUNDS : BOUNDS + 6]
    for s in around.outer.tolist():
        if s == len(bounds):
            gaps = low[..., 2] - around.floor
        else:
            gaps = np.maximum(low - bounds[s, 3:], bounds[s, :3] - high).max(axis=2)
        near_row = (gaps < bodies.radii + around.margins[s]) & asked[:, s]
        near |= near_row.any(axis=1)
        if s < len(bounds) and around.meshes[s] < 0 and around.inside[2 * s + 1] == 0:
            for c in np.flatnonzero(near_row.any(axis=0)).tolist():
                some = np.flatnonzero(near_row[:, c] & ~found)
                found[some] = _has_point_near(bodies, c, poses[some], around, s)
    return ~near, found


def _placed(
    chain: ChainTable, bodies: Bodies, configurations: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Poses of the joints (k, m + 1, 12), [m], and ends of capsules (k, c, 2, 3), [unit]."""
    size, count = POSE * (len(chain.source) + 1), len(bodies.frames)
    # arrays in place of numbers
    poses: Any = [0.0] * size
    ends: Any = [0.0] * (6 * count)
    coordinates: Any = [*configurations.T.copy()]
    place_bodies(as_lists(chain), as_lists(bodies), coordinates, 0, poses, ends)
    placed = np.empty((len(configurations), size + 6 * count))
    for k, column in enumerate(poses + ends):
        placed[:, k] = column
    return (
        placed[:, :size].reshape(len(placed), size // POSE, POSE),
        placed[:, size:].reshape(len(placed), count, 2, 3),
    )


def _has_point_near(
    bodies: Bodies, c: int, poses: FloatArray, around: Obstacles, s: int
) -> BoolArray:
    """Check if a corner of hull c, or its middle, is too near to row s, at poses (k, m + 1, 12)."""
    corners = bodies.points.reshape(-1, 3)[bodies.first[c] : bodies.first[c + 1]]
    points, frame = np.vstack([corners, corners.mean(axis=0)]), int(bodies.frames[c])
    placed = np.broadcast_to(points, (len(poses), *points.shape))
    if frame >= 0:
        turns, origins = poses[:, frame, :9].reshape(-1, 3, 3), poses[:, frame, None, 9:]
        placed = points @ turns.swapaxes(1, 2) + origins
    row = around.primitives[WIDTH * s : WIDTH * (s + 1)]
    away = distances_to_each(bodies.scale * placed.reshape(-1), row)[0]
    # without the rounding of hulls, which capsules need not hold
    need = around.margins[s] - _ALLOWANCE * around.size
    return np.asarray((away < need).reshape(len(poses), len(points)).any(axis=1))


def _near_each_other(bodies: Bodies, ends: FloatArray, slack: float, size: float) -> BoolArray:
    """Check where two capsules that are to keep apart may be too near to each other, (k,)."""
    if slack < 0:
        return np.zeros(len(ends), dtype=np.bool_)
    first, second = bodies.pairs.reshape(-1, 2).T
    away = segment_distances(ends[:, first].reshape(-1, 2, 3), ends[:, second].reshape(-1, 2, 3))
    needs = bodies.radii[first] + bodies.radii[second] + slack + _ALLOWANCE * size
    return np.asarray((away.reshape(len(ends), len(first)) <= needs).any(axis=1))
