"""Joint positions that move a chain's tip along a path, by damped least squares."""

from __future__ import annotations

import math
from typing import NamedTuple

from abi.arrays import FloatArray
from abi.compilation.jitable import jitable
from abi.compilation.plain import numbers
from abi.compiled import FLOATS, NEW_FLOATS, compiled
from abi.robot.kinematics.chain_kernels import POSE, TABLE, ChainTable, fill_jacobian, place_chain

_SMALL = 1e-12
_PULL = 3.0
"""Part of the way home that redundant joints go for each reach that the tip travels."""


@jitable
def _error(
    chain: ChainTable, poses: FloatArray, targets: FloatArray, sample: int, error: FloatArray
) -> float:
    """Write the error of the task, over the reach and in [rad], and return its largest part."""
    tip = POSE * len(chain.source)
    size = 0.0
    for r in range(3):
        error[r] = (targets[3 * sample + r] - poses[tip + 9 + r]) / chain.reach
        size += error[r] * error[r]
    size = math.sqrt(size)
    if not chain.aims:
        return size
    x, y, z = poses[tip + 2], poses[tip + 5], poses[tip + 8]
    u, v, w = chain.direction[0], chain.direction[1], chain.direction[2]
    a, b, c = y * w - z * v, z * u - x * w, x * v - y * u
    sine, cosine = math.sqrt(a * a + b * b + c * c), x * u + y * v + z * w
    angle = math.atan2(sine, cosine)
    if sine < 1e-9 and cosine < 0:  # opposite: any way round
        a, b, c = (0.0, z, -y) if abs(x) < 0.9 else (-z, 0.0, x)
        sine = math.sqrt(a * a + b * b + c * c)
    scale = angle / sine if sine > 1e-9 else 1.0
    error[3], error[4], error[5] = a * scale, b * scale, c * scale
    return max(size, angle)


@jitable
def _solve(matrix: FloatArray, right: FloatArray, rows: int) -> None:
    """Replace ``right`` by the solution of a positive definite system (Cholesky), in place."""
    for i in range(rows):
        for j in range(i + 1):
            total = matrix[rows * i + j]
            for k in range(j):
                total -= matrix[rows * i + k] * matrix[rows * j + k]
            if i == j:
                matrix[rows * i + i] = math.sqrt(max(total, 1e-300))
            else:
                matrix[rows * i + j] = total / matrix[rows * j + j]
    for i in range(rows):
        for k in range(i):
            right[i] -= matrix[rows * i + k] * right[k]
        right[i] /= matrix[rows * i + i]
    for back in range(rows):
        i = rows - 1 - back
        for k in range(i + 1, rows):
            right[i] -= matrix[rows * k + i] * right[k]
        right[i] /= matrix[rows * i + i]


class FollowWorkspace(NamedTuple):
    """Arrays that a step of inverse kinematics is computed in.

    Attributes:
        poses: flat (12 (m + 1),).
        jacobian: flat (6 n,).
        drift, step: (n,).
        error, right: (6,).
        matrix: flat (36,).
    """

    poses: FloatArray
    jacobian: FloatArray
    drift: FloatArray
    step: FloatArray
    error: FloatArray
    right: FloatArray
    matrix: FloatArray


@jitable
def room_of(chain: ChainTable, count: int) -> FollowWorkspace:
    """Arrays for the inverse kinematics of a chain with n coordinates."""
    return FollowWorkspace(
        numbers(POSE * (len(chain.source) + 1)),
        numbers(6 * count),
        numbers(count),
        numbers(count),
        numbers(6),
        numbers(6),
        numbers(36),
    )


@jitable
def _step(chain: ChainTable, q: FloatArray, room: FollowWorkspace, damping: float) -> None:
    """Write the damped least-squares step with what of the drift the task leaves free.

    A joint that would leave its limits is held, and the others are asked again.
    """
    rows, count = (6 if chain.aims else 3), len(q)
    jacobian, error, drift, step = room.jacobian, room.error, room.drift, room.step
    matrix, right = room.matrix, room.right
    for attempt in range(3):
        scale = 0.0
        for i in range(rows):
            right[i] = error[i]
            for j in range(count):
                right[i] -= jacobian[count * i + j] * drift[j]
            for k in range(i + 1):  # of the other half, which is the same, nothing is read
                total = 0.0
                for j in range(count):
                    total += jacobian[count * i + j] * jacobian[count * k + j]
                matrix[rows * i + k] = total
            scale += matrix[rows * i + i]
        for i in range(rows):
            # the turn of the z axis has two directions in three rows
            matrix[rows * i + i] += (damping + (1e-9 if rows == 6 else 1e-12)) * scale + 1e-14
        _solve(matrix, right, rows)
        held = False
        for j in range(count):
            step[j] = drift[j]
            for i in range(rows):
                step[j] += jacobian[count * i + j] * right[i]
            low, high = chain.limits[2 * j], chain.limits[2 * j + 1]
            if (q[j] <= low and step[j] < 0) or (q[j] >= high and step[j] > 0):
                step[j], drift[j] = 0.0, 0.0
                for i in range(rows):
                    held = held or jacobian[count * i + j] != 0
                    jacobian[count * i + j] = 0.0
        if not held or attempt == 2:
            break


@jitable
def _move(chain: ChainTable, q: FloatArray, step: FloatArray, longest: float) -> None:
    """Add the step, made shorter where a joint would move more than ``longest``, within limits."""
    most = _SMALL
    for j in range(len(q)):
        most = max(most, abs(step[j]))
    share = min(1.0, longest / most)
    for j in range(len(q)):
        moved = q[j] + share * step[j]
        q[j] = min(max(moved, chain.limits[2 * j]), chain.limits[2 * j + 1])


@jitable
def reach_point(
    chain: ChainTable,
    q: FloatArray,
    home: FloatArray,
    drifts: bool,
    targets: FloatArray,
    sample: int,
    most: int,
    room: FollowWorkspace,
) -> float:
    """Move coordinates until the tip is at a point, by damped least squares; what it lacks.

    Where the chain has joints to spare, they drift home as the tip goes on: in the first step
    alone, so that a motion stays smooth.

    Args:
        chain: the chain and its task.
        q: coordinates to begin with, (n,); written.
        home: coordinates that joints to spare drift to, (n,).
        drifts: whether they do; if not, there is no step where the point is reached.
        targets: points, flat, [m], world.
        sample: which of them.
        most: iterations, at most.
        room: for the steps.
    """
    count, rows = len(q), 6 if chain.aims else 3
    damping, last = 1e-12, 1e9
    for attempt in range(most):
        place_chain(chain, q, 0, room.poses)
        lacks = _error(chain, room.poses, targets, sample, room.error)
        predicts = attempt == 0 and drifts
        if lacks < 1e-11 and not predicts:
            return lacks
        error = room.error
        way = math.sqrt(error[0] ** 2 + error[1] ** 2 + error[2] ** 2)
        for j in range(count):
            room.drift[j] = min(1.0, _PULL * way) * (home[j] - q[j]) if predicts else 0.0
        if attempt > 0:
            falls = lacks < last
            damping = max(damping * 0.1, 1e-12) if falls else min(max(damping, 1e-8) * 100, 0.1)
        last = lacks
        fill_jacobian(chain, room.poses, rows, count, room.jacobian)
        _step(chain, q, room, damping)
        _move(chain, q, room.step, 0.5)
    place_chain(chain, q, 0, room.poses)
    return _error(chain, room.poses, targets, sample, room.error)


@compiled(example=(TABLE, FLOATS, FLOATS, FLOATS, (0, 0), 0, NEW_FLOATS, NEW_FLOATS))
def follow_path(
    chain: ChainTable,
    start: FloatArray,
    home: FloatArray,
    targets: FloatArray,
    part: tuple[int, int],
    most: int,
    joints: FloatArray,
    errors: FloatArray,
) -> None:
    """Lead the tip along points, each from the one before; see :func:`reach_point`.

    Args:
        chain: the chain and its task.
        start: coordinates to begin with, (n,).
        home: coordinates that joints to spare drift to, (n,).
        targets: k points, flat (3 k,), [m], world.
        part: the first point to lead it to, and the one after the last; it is led to those before
            already.
        most: iterations for a point, at most.
        joints: coordinates at each point, flat (k n,); written.
        errors: what each lacks, over the reach or in [rad], (k,); written.
    """
    count = len(start)
    room, q = room_of(chain, count), start.copy()
    first, end = part
    if first > 0:
        for j in range(count):
            q[j] = joints[(first - 1) * count + j]
    for sample in range(first, end):
        errors[sample] = reach_point(chain, q, home, sample > 0, targets, sample, most, room)
        for j in range(count):
            joints[sample * count + j] = q[j]
