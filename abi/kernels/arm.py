"""The elbow and the shoulder of the arm along a path, compiled by numba; runs uncompiled too."""

from __future__ import annotations

import math
import threading

import numba
import numpy as np

from abi.arrays import FloatArray, read_only

ready = threading.Event()
"""Set once the kernel is compiled."""


@numba.njit(cache=True, nogil=True)
def bend(
    across: FloatArray,
    height: FloatArray,
    forearm: FloatArray,
    upper: float,
    side: float,
    rounding: float,
    q2: FloatArray,
    q3: FloatArray,
    shortfall: FloatArray,
) -> None:
    """Elbow and shoulder that put the tool at places of the arm's plane; see ``abi.ik``.

    Args:
        across: the tool's signed distance from the base axis (n,), [unit].
        height: of the tool above the shoulder (n,), [unit].
        forearm: a6 (n,), [unit].
        upper: a3, [unit].
        side: the sign of q3.
        rounding: shortfalls up to this are none, [unit].
        q2: unwrapped along the path (n,), [rad]; written.
        q3: (n,), [rad]; written.
        shortfall: (n,), [unit]; written.
    """
    turned, last = 0.0, 0.0
    for i in range(len(across)):
        a6 = forearm[i]
        distance = math.hypot(across[i], height[i])
        short = max(distance - (upper + abs(a6)), 0.0) - max(abs(upper - abs(a6)) - distance, 0.0)
        shortfall[i] = short if abs(short) > rounding else 0.0
        stretch, fold = upper + a6, upper - a6
        # A force that pulls can make a6 negative: the tool is then behind the elbow.
        sign = 1.0 if a6 > 0 else -1.0 if a6 < 0 else 0.0
        folded = sign * (stretch - distance) * (stretch + distance)
        stretched = sign * (distance - fold) * (distance + fold)
        half = math.atan2(math.sqrt(max(folded, 0.0)), math.sqrt(max(stretched, 0.0)))
        q3[i] = 2 * side * half
        angle = math.atan2(across[i], height[i])
        if i > 0 and abs(angle - last) > math.pi:
            turned += -2 * math.pi if angle > last else 2 * math.pi
        last = angle
        lead = math.atan2(a6 * math.sin(q3[i]), upper + a6 * math.cos(q3[i]))
        q2[i] = angle + turned - lead


def warm() -> None:
    """Compile the kernel, or load what was compiled before."""
    one = read_only(np.ones(1))
    bend(one, one, one, 1.0, 1.0, 0.0, np.zeros(1), np.zeros(1), np.zeros(1))
    ready.set()
