"""How near points and segments are to convex solids.

Compiled by numba; each runs uncompiled too, by its ``py_func`` on plain lists. For the rows of
numbers that describe solids see ``abi.kernels.solids``.
"""

from __future__ import annotations

import math
import threading

import numba
import numpy as np
from numba.extending import register_jitable

from abi.arrays import FloatArray, read_only
from abi.kernels.solids import WIDTH, axes_of, core_of, distance, in_body, level

ready = threading.Event()
"""Set once the kernels are compiled."""

_HALVINGS = 60


@register_jitable
def _least(
    solids: FloatArray,
    s: int,
    enough: float,
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
) -> float:
    """Least signed distance of the segment a..b to a solid; any number if not below ``enough``.

    The distance is convex along the segment, so the side of a place on which it falls has the
    least, and what it falls at most, by its slope there, bounds that from below.
    """
    k = WIDTH * s
    axes, core = axes_of(solids, s), core_of(solids, s)
    px, py, pz = in_body(axes, ax - solids[k], ay - solids[k + 1], az - solids[k + 2])
    dx, dy, dz = in_body(axes, bx - ax, by - ay, bz - az)
    least = min(level(core, px, py, pz), level(core, px + dx, py + dy, pz + dz))
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        t = (low + high) / 2
        away, gx, gy, gz = distance(core, px + t * dx, py + t * dy, pz + t * dz)
        slope = gx * dx + gy * dy + gz * dz
        least = min(least, away)
        if away - abs(slope) * (high - low) / 2 >= min(least, enough):
            break
        if slope > 0:
            high = t
        else:
            low = t
    return least


@numba.njit(cache=True, nogil=True)
def clearances(x: FloatArray, y: FloatArray, z: FloatArray, solids: FloatArray) -> FloatArray:
    """Least signed distance of each segment of a polyline to the solids, [unit].

    Exact up to rounding: the place to 2^-60 of the segment.

    Args:
        x, y, z: (n,) vertices, [unit], world.
        solids: (k WIDTH,) rows, one after the other.

    Returns:
        (n - 1,), inf without solids.
    """
    count = len(x) - 1
    found = np.full(count, np.inf)
    for i in range(count):
        ax, ay, az, bx, by, bz = x[i], y[i], z[i], x[i + 1], y[i + 1], z[i + 1]
        least = math.inf
        for s in range(len(solids) // WIDTH):
            k = WIDTH * s + 17
            gap = max(min(ax, bx) - solids[k + 3], solids[k] - max(ax, bx))
            gap = max(gap, max(min(ay, by) - solids[k + 4], solids[k + 1] - max(ay, by)))
            gap = max(gap, max(min(az, bz) - solids[k + 5], solids[k + 2] - max(az, bz)))
            # a solid is no nearer than its bounds
            if gap < least:
                least = min(least, _least(solids, s, least, ax, ay, az, bx, by, bz))
        found[i] = least
    return found


@numba.njit(cache=True, nogil=True)
def levels(x: FloatArray, y: FloatArray, z: FloatArray, solids: FloatArray) -> FloatArray:
    """Signed distance of each point to each solid, [unit].

    Args:
        x, y, z: (n,) points, [unit], world.
        solids: (k WIDTH,) rows, one after the other.

    Returns:
        (n k,), the solids of the first point first.
    """
    count = len(solids) // WIDTH
    found = np.empty(len(x) * count)
    for i in range(len(x)):
        for s in range(count):
            k = WIDTH * s
            px, py, pz = in_body(
                axes_of(solids, s), x[i] - solids[k], y[i] - solids[k + 1], z[i] - solids[k + 2]
            )
            found[i * count + s] = level(core_of(solids, s), px, py, pz)
    return found


def warm() -> None:
    """Compile the kernels, or load them from numba's cache."""
    ones, none = read_only(np.ones(2)), read_only(np.zeros(0))
    clearances(ones, ones, ones, none)
    levels(ones, ones, ones, none)
    ready.set()
