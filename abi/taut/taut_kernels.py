"""A path pulled taut between convex solids, and others that go round these by their edges.

Compiled by numba; ``pull`` runs uncompiled too, by its ``py_func`` on plain lists.
"""

from __future__ import annotations

import math

import numpy as np
from numba.extending import register_jitable

from abi.arrays import FloatArray, IntArray
from abi.compiled import FLOATS, IDS, compiled
from abi.taut.tighten_kernels import length_of, tighten
from abi.taut.visibility_graph_kernels import places, ways

_SAME = 1e-6  # parts of the length: nearer than this two strings are one,
_CLOSE = 2e-4  # and as near as this either may be the shorter one once its corners are cut


@register_jitable
def _shortest(lengths: list[float]) -> list[int]:
    """The shortest path, and of the others that which is close behind, if there is one."""
    best, second = 0, -1
    for k in range(len(lengths)):
        if lengths[k] < lengths[best]:
            best = k
    for k in range(len(lengths)):
        behind = lengths[k] - lengths[best]
        if _SAME * lengths[best] < behind < _CLOSE * lengths[best] and (
            second < 0 or lengths[k] < lengths[second]
        ):
            second = k
    return [best, second] if second >= 0 else [best]


@compiled(example=(FLOATS, FLOATS, FLOATS, IDS, FLOATS, FLOATS, FLOATS, FLOATS, 1, 1.0, 1, 1e-6))
def pull(
    x: FloatArray,
    y: FloatArray,
    z: FloatArray,
    begins: IntArray,
    edges: FloatArray,
    solids: FloatArray,
    margins: FloatArray,
    bounds: FloatArray,
    samples: int,
    slack: float,
    count: int,
    worth: float,
) -> tuple[FloatArray, FloatArray, FloatArray, IntArray, FloatArray]:
    """Tighten paths, and the shortest ways by places on the edges; cut the corners of the best.

    Where two are nearly as short, those of both are cut.

    Args:
        x, y, z: (n,) the paths, one after the other, all between the same ends, of two points or
            more, their segments clear, [unit], world.
        begins: where each begins, and where the last ends (q + 1,), q >= 1.
        edges: (6 e,) both ends of each edge, one after the other, [unit], world.
        solids, margins, bounds, worth: see ``abi.taut.tighten_kernels``.
        samples: places evenly apart on each edge.
        slack: how many times as long as the shortest so far a way by places may be.
        count: how many of these are looked at.

    Returns:
        Coordinates of the new paths, one after the other, (m,) each; where each begins, and where
        the last ends (p + 1,); and their lengths (p,), [unit].
    """
    given, first, last = len(begins) - 1, 0, len(x) - 1
    between = [x[0], y[0], z[0], x[last], y[last], z[last]]
    margin = 0.0
    for k in range(len(margins) // 4):
        margin = max(margin, margins[k])
    xs, ys, zs = [0.0] * 0, [0.0] * 0, [0.0] * 0
    qx, qy, qz = xs[:0], ys[:0], zs[:0]
    nodes, ends, lengths = [0] * 0, [0], [0.0] * 0
    shortest = math.inf
    final, chosen = False, [0] * 0
    while not final or len(chosen) > 0:
        done = len(ends) - 1
        if not final and done >= given and first == len(nodes):
            final, chosen = True, _shortest(lengths)
        if final:
            k = chosen.pop()
            px, py, pz = (
                xs[ends[k] : ends[k + 1]],
                ys[ends[k] : ends[k + 1]],
                zs[ends[k] : ends[k + 1]],
            )
        elif done < given:
            px = list(x[begins[done] : begins[done + 1]])
            py = list(y[begins[done] : begins[done + 1]])
            pz = list(z[begins[done] : begins[done + 1]])
        else:
            end = first + 1
            while nodes[end] != 1:
                end += 1
            px = [qx[i] for i in nodes[first : end + 1]]
            py = [qy[i] for i in nodes[first : end + 1]]
            pz = [qz[i] for i in nodes[first : end + 1]]
            first = end + 1
            if length_of(px, py, pz) > slack * shortest:
                continue
        # called from one place, for what is called is compiled where it is called
        px, py, pz = tighten(px, py, pz, solids, margins, bounds, worth if final else math.inf)
        length = length_of(px, py, pz)
        shortest = min(shortest, length)
        xs.extend(px)
        ys.extend(py)
        zs.extend(pz)
        ends.append(len(xs))
        lengths.append(length)
        if done == given - 1:
            most = slack * shortest
            qx, qy, qz, labels = places(edges, between, samples, most, margin, bounds, solids)
            nodes = ways(qx, qy, qz, labels, solids, margins, most, count)
    return np.array(xs), np.array(ys), np.array(zs), np.array(ends), np.array(lengths)
