"""Fastest speeds along a path under limits of joint speeds and accelerations.

TOPP-RA (Pham and Pham, A new approach to time-optimal path parameterization based on reachability
analysis, 2018) with x = (ds/dt)² and u = d²s/dt² at the points of a grid:

    abs(q'(s)·u + q''(s)·x) ≤ A,   abs(q'(s))·√x ≤ V,   x + 2·Δ·u within the next point's set.

Each constraint bounds u by two lines in x. The feasible x end where two of the lines meet
(Fourier-Motzkin), so each linear program is a double loop. The constraints must hold at both ends
of a step.
"""

from __future__ import annotations

import math

from abi.arrays import FloatArray
from abi.compilation.jitable import jitable
from abi.compilation.plain import numbers
from abi.compiled import FLOATS, NEW_FLOATS, compiled

_FLAT = 1e-12


@jitable
def _row(
    rates: tuple[FloatArray, FloatArray], i: int, k: int, count: int, step: float
) -> tuple[float, float]:
    """Factors of u = s'' and x = s'² in acceleration ``k`` at the start or end of step ``i``."""
    first, second = rates
    if k < count:
        return first[count * i + k], second[count * i + k]
    # at the end of the step x has become x + 2·Δ·u
    j = count * (i + 1) + k - count
    return first[j] + 2 * step * second[j], second[j]


@jitable
def _feasible(
    rates: tuple[FloatArray, FloatArray],
    i: int,
    accelerations: FloatArray,
    top: float,
    step: float,
    after: tuple[float, float],
) -> tuple[float, float]:
    """Least and largest x from which the next set can be reached; the largest < 0: none."""
    count = len(accelerations)
    low, low_slope = numbers(2 * count + 1), numbers(2 * count + 1)
    high, high_slope = numbers(2 * count + 1), numbers(2 * count + 1)
    lines = 1
    least, largest = 0.0, top
    low[0], high[0] = after[0] / (2 * step), after[1] / (2 * step)
    low_slope[0] = high_slope[0] = -1 / (2 * step)
    for k in range(2 * count):
        a, b = _row(rates, i, k, count, step)
        if abs(a) < _FLAT:
            if abs(b) > _FLAT:
                largest = min(largest, accelerations[k % count] / abs(b))
            continue
        low[lines], high[lines] = (
            -accelerations[k % count] / abs(a),
            accelerations[k % count] / abs(a),
        )
        low_slope[lines] = high_slope[lines] = -b / a
        lines += 1
    for k in range(lines):
        for m in range(lines):
            slope, room = low_slope[k] - high_slope[m], high[m] - low[k]
            if slope > 1e-15:
                largest = min(largest, room / slope)
            elif slope < -1e-15:
                least = max(least, room / slope)
            elif room < 0:
                largest = -1.0
    return least, largest


@compiled(example=(FLOATS, FLOATS, 0.0, FLOATS, FLOATS, NEW_FLOATS, NEW_FLOATS))
def fastest_speeds(
    first: FloatArray,
    second: FloatArray,
    step: float,
    speeds: FloatArray,
    accelerations: FloatArray,
    sets: FloatArray,
    squared: FloatArray,
) -> int:
    """Squares of the speeds of the fastest motion from rest to rest.

    Args:
        first, second: derivatives of n joints by the distance at m points, flat (m n,).
        step: distance between the points.
        speeds: largest of each joint, (n,).
        accelerations: largest of each joint, (n,).
        sets: room for the feasible squares, flat (2 m,).
        squared: written, (m,).

    Returns:
        -1, or the point from which there is no motion.
    """
    count, last = len(speeds), len(squared) - 1
    rates = (first, second)
    sets[2 * last], sets[2 * last + 1] = 0.0, 0.0
    for i in range(last - 1, -1, -1):
        top = 1e18
        for j in range(count):
            if abs(first[count * i + j]) > _FLAT:
                top = min(top, (speeds[j] / first[count * i + j]) ** 2)
        after = (sets[2 * i + 2], sets[2 * i + 3])
        least, largest = _feasible(rates, i, accelerations, top, step, after)
        if largest < 0 or largest < least - 1e-12:
            return i
        sets[2 * i], sets[2 * i + 1] = least, largest
    squared[0] = 0.0
    for i in range(last):
        u = (sets[2 * i + 3] - squared[i]) / (2 * step)
        for k in range(2 * count):
            a, b = _row(rates, i, k, count, step)
            if abs(a) > _FLAT:
                room = accelerations[k % count] - math.copysign(1.0, a) * b * squared[i]
                u = min(u, room / abs(a))
        squared[i + 1] = max(squared[i] + 2 * step * u, 0.0)
    return -1
