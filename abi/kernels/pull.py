"""A path pulled taut between convex solids, and others that go round these by their edges.

Compiled by numba; ``pull`` runs uncompiled too, by its ``py_func`` on plain lists.
"""

from __future__ import annotations

import math
import threading

import numba
import numpy as np

from abi.arrays import FloatArray, IntArray, read_only
from abi.kernels.tighten import length_of, tighten
from abi.kernels.visibility import places, ways

ready = threading.Event()
"""Set once the kernel is compiled."""


@numba.njit(cache=True, nogil=True)
def pull(
    x: FloatArray,
    y: FloatArray,
    z: FloatArray,
    edges: FloatArray,
    solids: FloatArray,
    margins: FloatArray,
    bounds: FloatArray,
    samples: int,
    slack: float,
    count: int,
    worth: float,
) -> tuple[FloatArray, FloatArray, FloatArray, IntArray]:
    """Tighten a path, and the shortest ways by places on the edges; cut the corners of the best.

    Args:
        x, y, z: (n,) the path, n >= 2, its segments clear, [unit], world.
        edges: (6 e,) both ends of each edge, one after the other, [unit], world.
        solids, margins, bounds, worth: see ``abi.kernels.tighten``.
        samples: places evenly apart on each edge.
        slack: how many times as long as the tightened path a way by places may be.
        count: how many of these are looked at.

    Returns:
        Coordinates of the paths, one after the other, (m,) each; where each ends (p,).
    """
    px, py, pz = tighten(list(x), list(y), list(z), solids, margins, bounds, math.inf)
    ends = [len(px)]
    shortest, begin = length_of(px, py, pz), 0
    last = len(x) - 1
    between = [x[0], y[0], z[0], x[last], y[last], z[last]]
    margin, most = 0.0, slack * shortest
    for k in range(len(margins) // 4):
        margin = max(margin, margins[k])
    qx, qy, qz, labels = places(edges, between, samples, most, margin, bounds, solids)
    nodes = ways(qx, qy, qz, labels, solids, margins, most, count)
    first = 0
    for k in range(len(nodes)):
        if nodes[k] == 1:
            way = nodes[first : k + 1]
            first = k + 1
            wx, wy, wz = tighten(
                [qx[i] for i in way],
                [qy[i] for i in way],
                [qz[i] for i in way],
                solids,
                margins,
                bounds,
                math.inf,
            )
            length = length_of(wx, wy, wz)
            if length < shortest:
                shortest, begin = length, len(px)
            px.extend(wx)
            py.extend(wy)
            pz.extend(wz)
            ends.append(len(px))
    end = begin + 1
    while end not in ends:
        end += 1
    wx, wy, wz = tighten(
        px[begin:end], py[begin:end], pz[begin:end], solids, margins, bounds, worth
    )
    px.extend(wx)
    py.extend(wy)
    pz.extend(wz)
    ends.append(len(px))
    return np.array(px), np.array(py), np.array(pz), np.array(ends)


def warm() -> None:
    """Compile the kernel, or load it from numba's cache."""
    ones, none, box = read_only(np.ones(2)), read_only(np.zeros(0)), read_only(np.zeros(6))
    pull(ones, ones, ones, none, none, none, box, 1, 1.0, 1, 1e-6)
    ready.set()
