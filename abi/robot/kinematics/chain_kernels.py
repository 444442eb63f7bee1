"""Kinematics of a chain: poses of its frames, and derivatives of its tip's task.

A chain is a row of joints, each after a fixed transform, and the joints beside it that follow one
of them; lengths are in [m]. Poses are flat: nine numbers of the rotation by rows, then the origin.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.compilation.jitable import called_as, jitable
from abi.compilation.plain import as_lists
from abi.compiled import FLAGS, FLOATS, IDS, NEW_FLOATS, compiled

POSE = 12
"""Numbers of a pose."""


class ChainTable(NamedTuple):
    """A chain with n coordinates, and the task of its tip; m joints move with these.

    Attributes:
        length: number of joints between base and tip, which come first; the tip is behind the last.
        before: joint behind which each stands, a smaller number, -1 for the world, (m,).
        origins: poses of each joint in the frame before it, then of the tip, flat (12 (m + 1),).
        axes: unit vectors of the joints in their frames, flat (3 m,).
        slides: whether a joint is prismatic, (m,).
        source: coordinate that moves each joint, (m,).
        factor: joint position for one of the coordinate, (m,); 1 but for mimic joints.
        offset: joint position at coordinate 0, (m,).
        limits: lowest and highest of each coordinate, flat (2 n,).
        direction: unit vector that the tip's z axis is to point along, world, (3,).
        aims: whether it is to.
        reach: length that errors of place are compared with, [m].
    """

    length: int
    before: IntArray
    origins: FloatArray
    axes: FloatArray
    slides: BoolArray
    source: IntArray
    factor: FloatArray
    offset: FloatArray
    limits: FloatArray
    direction: FloatArray
    aims: bool
    reach: float


TABLE = ChainTable(1, IDS, FLOATS, FLOATS, FLAGS, IDS, FLOATS, FLOATS, FLOATS, FLOATS, True, 1.0)
"""Example of a chain."""


@jitable
def _append(poses: FloatArray, at: int, before: int, origins: FloatArray, joint: int) -> None:
    """Pose ``at`` = pose ``before`` times an origin; with ``before`` < 0 the origin itself."""
    to, a, b = POSE * at, POSE * before, POSE * joint
    if before < 0:
        for k in range(POSE):
            poses[to + k] = origins[b + k]
        return
    for r in range(3):
        x, y, z = poses[a + 3 * r], poses[a + 3 * r + 1], poses[a + 3 * r + 2]
        # written out: a loop over the columns takes Python twice as long
        k = to + 3 * r
        poses[k] = x * origins[b] + y * origins[b + 3] + z * origins[b + 6]
        poses[k + 1] = x * origins[b + 1] + y * origins[b + 4] + z * origins[b + 7]
        poses[k + 2] = x * origins[b + 2] + y * origins[b + 5] + z * origins[b + 8]
        poses[to + 9 + r] = (
            poses[a + 9 + r] + x * origins[b + 9] + y * origins[b + 10] + z * origins[b + 11]
        )


def _of_each(angle: float) -> tuple[float, float]:
    if not isinstance(angle, np.ndarray):
        return math.sin(angle), math.cos(angle)
    # numpy's own differ from these in the last bit
    angles = angle.tolist()
    return np.array([*map(math.sin, angles)]), np.array([*map(math.cos, angles)])


@jitable
@called_as(_of_each)
def _sine_and_cosine(angle: float) -> tuple[float, float]:
    """Sine and cosine of an angle; as Python of an array of angles, too."""
    return math.sin(angle), math.cos(angle)


@jitable
def _turn(poses: FloatArray, at: int, axis: tuple[float, float, float], angle: float) -> None:
    """Turn pose ``at`` about an axis of its own (Rodrigues' formula)."""
    s, c = _sine_and_cosine(angle)
    x, y, z = axis
    v = 1 - c
    # by rows and columns; written out as above
    xx, xy, xz = c + x * x * v, x * y * v - z * s, x * z * v + y * s
    yx, yy, yz = y * x * v + z * s, c + y * y * v, y * z * v - x * s
    zx, zy, zz = z * x * v - y * s, z * y * v + x * s, c + z * z * v
    for k in range(POSE * at, POSE * at + 9, 3):
        p, q, r = poses[k], poses[k + 1], poses[k + 2]
        poses[k] = p * xx + q * yx + r * zx
        poses[k + 1] = p * xy + q * yy + r * zy
        poses[k + 2] = p * xz + q * yz + r * zz


@jitable
def place_chain(chain: ChainTable, q: FloatArray, first: int, poses: FloatArray) -> None:
    """Write the poses behind each joint and of the tip, flat (12 (m + 1),).

    Args:
        chain: the chain.
        q: coordinates; those of this pose begin at ``first``.
        first: their place.
        poses: written.

    As Python it takes arrays in place of each of these numbers, and places many chains at once.
    """
    count = len(chain.source)
    for joint in range(count):
        _append(poses, joint, chain.before[joint], chain.origins, joint)
        value = chain.factor[joint] * q[first + chain.source[joint]] + chain.offset[joint]
        x, y, z = chain.axes[3 * joint], chain.axes[3 * joint + 1], chain.axes[3 * joint + 2]
        if chain.slides[joint]:
            for r in range(3):
                k = POSE * joint + 3 * r
                along = poses[k] * x + poses[k + 1] * y + poses[k + 2] * z
                poses[POSE * joint + 9 + r] += along * value
        else:
            _turn(poses, joint, (x, y, z), value)
    _append(poses, count, chain.length - 1, chain.origins, count)


@jitable
def fill_jacobian(
    chain: ChainTable, poses: FloatArray, rows: int, count: int, jacobian: FloatArray
) -> None:
    """Write the task's derivatives by the coordinates, flat (rows count,).

    Rows 0 to 2 are the tip's place over the chain's reach, rows 3 to 5 the turn of its z axis; what
    turns it about itself is left out.
    """
    for k in range(rows * count):
        jacobian[k] = 0.0
    tip = POSE * len(chain.source)
    for joint in range(chain.length):
        k, column, factor = POSE * joint, chain.source[joint], chain.factor[joint]
        x, y, z = chain.axes[3 * joint], chain.axes[3 * joint + 1], chain.axes[3 * joint + 2]
        wx = poses[k] * x + poses[k + 1] * y + poses[k + 2] * z
        wy = poses[k + 3] * x + poses[k + 4] * y + poses[k + 5] * z
        wz = poses[k + 6] * x + poses[k + 7] * y + poses[k + 8] * z
        scale = factor / chain.reach
        if chain.slides[joint]:
            jacobian[column] += scale * wx
            jacobian[count + column] += scale * wy
            jacobian[2 * count + column] += scale * wz
            continue
        a = poses[tip + 9] - poses[k + 9]
        b = poses[tip + 10] - poses[k + 10]
        c = poses[tip + 11] - poses[k + 11]
        jacobian[column] += scale * (wy * c - wz * b)
        jacobian[count + column] += scale * (wz * a - wx * c)
        jacobian[2 * count + column] += scale * (wx * b - wy * a)
        if rows == 6:
            zx, zy, zz = poses[tip + 2], poses[tip + 5], poses[tip + 8]
            own = wx * zx + wy * zy + wz * zz
            jacobian[3 * count + column] += factor * (wx - own * zx)
            jacobian[4 * count + column] += factor * (wy - own * zy)
            jacobian[5 * count + column] += factor * (wz - own * zz)


def _chains_at_once(chain: ChainTable, joints: FloatArray, count: int, poses: FloatArray) -> None:
    columns: Any = [0.0] * (POSE * (len(chain.source) + 1))
    values: Any = [*joints.reshape(-1, count).T.copy()]
    place_chain(as_lists(chain), values, 0, columns)
    rows = poses.reshape(-1, len(columns))
    for k, column in enumerate(columns):
        rows[:, k] = column


@compiled(example=(TABLE, FLOATS, 0, NEW_FLOATS), in_numpy=_chains_at_once)
def chain_poses(chain: ChainTable, joints: FloatArray, count: int, poses: FloatArray) -> None:
    """Write the poses of all frames at many joint positions.

    Args:
        chain: the chain.
        joints: coordinates, flat (k count,).
        count: number of coordinates n.
        poses: behind each joint and of the tip, flat (12 k (m + 1),); written.
    """
    size = POSE * (len(chain.source) + 1)
    one = np.empty(size)
    for sample in range(len(poses) // size):
        place_chain(chain, joints, sample * count, one)
        for k in range(size):
            poses[sample * size + k] = one[k]
