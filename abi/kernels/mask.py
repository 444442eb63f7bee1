"""What obstacles take away from a mesh: nodes, and edges between the nodes that are left.

Compiled by numba; each runs uncompiled too, by its ``py_func``. A solid is a row of numbers, see
``abi.kernels.solids``; a mesh is described in ``abi.kernels.net``.
"""

from __future__ import annotations

import math
import threading

import numba
import numpy as np
from numba.extending import register_jitable

from abi.arrays import BoolArray, FloatArray, IntArray, read_only
from abi.kernels.net import BCC, ROWS, SIDES, Shape, across, cell, node_at
from abi.kernels.solids import WIDTH, axes_of, blocked, core_of, distance, in_body, near

ready = threading.Event()
"""Set once the kernels are compiled."""

_ROUNDING = 1e-9  # of a step: what is nearer to a limit than this is looked at


@numba.njit(cache=True, nogil=True)
def exclude(
    shape: Shape,
    places: FloatArray,
    solids: FloatArray,
    margin: float,
    reach: float,
    excluded: BoolArray,
) -> tuple[IntArray, IntArray, int]:
    """Mark the nodes nearer to a solid than ``margin``, and find those not much farther.

    Only the window around each solid is looked at, line by line along z. The distance changes by no
    more than the way gone, which says how many nodes can be passed over.

    Args:
        shape, places: the mesh.
        solids: (k WIDTH,) rows, one after the other.
        margin: [unit].
        reach: [unit].
        excluded: (n,) False; set True where a node is excluded.

    Returns:
        Nodes whose distance to a solid is at least ``margin`` and less than ``margin + reach``; the
        solids (both (m,), by solid); the number of nodes excluded.
    """
    nodes = shape[5]
    shell = np.empty(256, np.int32)
    whose = np.empty(256, np.int32)
    found, gone = 0, 0
    limit = margin + reach
    y0 = 2 * shape[1] + 1
    z0 = y0 + 2 * shape[2] + 1
    for s in range(len(solids) // WIDTH):
        k = WIDTH * s
        cx, cy, cz = solids[k], solids[k + 1], solids[k + 2]
        axes, core = axes_of(solids, s), core_of(solids, s)
        low = (solids[k + 17] - limit, solids[k + 18] - limit, solids[k + 19] - limit)
        high = (solids[k + 20] + limit, solids[k + 21] + limit, solids[k + 22] + limit)
        if shape[0] == ROWS:
            for node in range(nodes):
                x, y, z = places[node], places[nodes + node], places[2 * nodes + node]
                if low[0] <= x <= high[0] and low[1] <= y <= high[1] and low[2] <= z <= high[2]:
                    px, py, pz = in_body(axes, x - cx, y - cy, z - cz)
                    away = distance(core, px, py, pz)[0]
                    if away >= limit:
                        continue
                    if away < margin:
                        gone += 0 if excluded[node] else 1
                        excluded[node] = True
                        continue
                    if found == len(shell):
                        shell = np.concatenate((shell, np.empty_like(shell)))
                        whose = np.concatenate((whose, np.empty_like(whose)))
                    shell[found] = node
                    whose[found] = s
                    found += 1
            continue
        step = places[z0 + 2] - places[z0]
        for odd in range(2 if shape[0] == BCC else 1):
            a0, a1 = _range(places[0], places[2], shape[1], low[0], high[0], odd)
            b0, b1 = _range(places[y0], places[y0 + 2], shape[2], low[1], high[1], odd)
            c0, c1 = _range(places[z0], places[z0 + 2], shape[3], low[2], high[2], odd)
            for a in range(a0, a1 + 1, 2):
                for b in range(b0, b1 + 1, 2):
                    line = node_at(shape, a, b, odd)
                    c = c0
                    while c <= c1:
                        px, py, pz = in_body(
                            axes, places[a] - cx, places[y0 + b] - cy, places[z0 + c] - cz
                        )
                        away = distance(core, px, py, pz)[0]
                        node = line + (c >> 1)
                        if away < margin:
                            many = max(int((margin - away) / step - _ROUNDING), 0)
                            many = min(many, (c1 - c) >> 1)
                            for k in range(node, node + many + 1):
                                gone += 0 if excluded[k] else 1
                                excluded[k] = True
                            c += 2 * many
                        elif away >= limit:
                            c += 2 * max(int((away - limit) / step - _ROUNDING), 0)
                        else:
                            if found == len(shell):
                                shell = np.concatenate((shell, np.empty_like(shell)))
                                whose = np.concatenate((whose, np.empty_like(whose)))
                            shell[found] = node
                            whose[found] = s
                            found += 1
                        c += 2
    return shell[:found], whose[:found], gone


@numba.njit(cache=True, nogil=True)
def shut(
    shape: Shape,
    offsets: IntArray,
    steps: IntArray,
    places: FloatArray,
    indptr: IntArray,
    indices: IntArray,
    exits: IntArray,
    weights: FloatArray,
    solids: FloatArray,
    margin: float,
    excluded: BoolArray,
    shell: IntArray,
    whose: IntArray,
) -> int:
    """Shut the edges that come nearer to a solid than ``margin``, and those to excluded nodes.

    Args:
        shape, offsets, steps, places, indptr, indices: the mesh.
        exits: (n,) directions that exist; the bits of those that are shut are cleared.
        weights: lengths, [unit]; in rows those that are shut become inf.
        solids: (k WIDTH,) rows, one after the other.
        margin: [unit].
        excluded: (n,).
        shell: (m,) nodes nearer to a solid than ``margin`` and the longest edge.
        whose: (m,) the solids.

    Returns:
        Number of edges shut whose ends are not excluded.
    """
    nodes, directions, cross = shape[5], shape[6], shape[7]
    crossing = 0
    last = -1
    turned = [0.0] * (3 * directions)
    axes = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    core = (0.0, 0.0, 0.0, 0.0, 0.0)
    cx, cy, cz = 0.0, 0.0, 0.0
    y0 = 2 * shape[1] + 1
    z0 = y0 + 2 * shape[2] + 1
    for entry in range(len(shell)):
        node, s = shell[entry], whose[entry]
        if s != last:
            last = s
            k = WIDTH * s
            cx, cy, cz = solids[k], solids[k + 1], solids[k + 2]
            axes, core = axes_of(solids, s), core_of(solids, s)
            for k in range(directions):
                x = steps[3 * k] * (places[1] - places[0])
                y = steps[3 * k + 1] * (places[y0 + 1] - places[y0])
                z = steps[3 * k + 2] * (places[z0 + 1] - places[z0])
                turned[3 * k], turned[3 * k + 1], turned[3 * k + 2] = in_body(axes, x, y, z)
        if excluded[node]:
            continue
        if shape[0] == ROWS:
            x, y, z = places[node], places[nodes + node], places[2 * nodes + node]
            px, py, pz = in_body(axes, x - cx, y - cy, z - cz)
            for k in range(indptr[node], indptr[node + 1]):
                head = indices[k]
                if weights[k] == math.inf:
                    continue
                if excluded[head]:
                    weights[k] = math.inf
                elif node < head:
                    dx, dy, dz = in_body(
                        axes,
                        places[head] - x,
                        places[nodes + head] - y,
                        places[2 * nodes + head] - z,
                    )
                    if near(core, margin, px, py, pz, dx, dy, dz):
                        crossing += 1
                        weights[k] = math.inf
                        for j in range(indptr[head], indptr[head + 1]):
                            if indices[j] == node:
                                weights[j] = math.inf
            continue
        a, b, c = cell(shape, node)
        px, py, pz = in_body(axes, places[a] - cx, places[y0 + b] - cy, places[z0 + c] - cz)
        away = distance(core, px, py, pz)[0]
        bits = exits[node]
        left = bits
        low = node < shape[4]
        row = 0 if low else directions
        other = across(shape, node) if cross > 0 else 0
        for k in range(directions if (bits >> SIDES) & 63 else SIDES):
            if (bits >> k) & 1 == 0:
                continue
            head = (other if k < cross else node) + offsets[row + k]
            if excluded[head]:
                left &= ~(1 << k)
                continue
            back = k if k < cross else k ^ 1
            if (
                (low if k < cross else k < back)
                and away < margin + weights[k]
                and near(
                    core,
                    margin,
                    px,
                    py,
                    pz,
                    turned[3 * k],
                    turned[3 * k + 1],
                    turned[3 * k + 2],
                )
            ):
                crossing += 1
                left &= ~(1 << k)
                exits[head] &= ~(1 << back)
        exits[node] &= left
    return crossing


@register_jitable
def _range(
    origin: float, following: float, cells: int, low: float, high: float, odd: int
) -> tuple[int, int]:
    """First and last half cell, even or odd, that may lie in low..high along an axis."""
    step = following - origin
    first = max(math.floor((low - origin) / step), 0)
    last = min(math.ceil((high - origin) / step), cells)
    return 2 * first + odd, 2 * last - odd


@numba.njit(cache=True, nogil=True)
def seen(
    shape: Shape,
    places: FloatArray,
    solids: FloatArray,
    margins: FloatArray,
    excluded: BoolArray,
    x: float,
    y: float,
    z: float,
    reach: float,
) -> tuple[IntArray, FloatArray]:
    """The nodes that a place sees.

    Args:
        shape, places: the mesh.
        solids: (k WIDTH,) rows, one after the other.
        margins: (k,) distance from the solids that a line of sight keeps, [unit].
        excluded: (n,) nodes that do not count.
        x, y, z: the place, [unit], world.
        reach: how far it looks, [unit].

    Returns:
        Nodes (m,) and the distances to them, [unit].
    """
    found = 0
    nodes = np.empty(128, np.int32)
    distances = np.empty(128, np.float64)
    count = shape[5]
    y0 = 2 * shape[1] + 1
    z0 = y0 + 2 * shape[2] + 1
    rows = shape[0] == ROWS
    for odd in range(2 if shape[0] == BCC else 1):
        a0, a1, b0, b1, c0, c1 = 0, 2 * count - 2, 0, 0, 0, 0
        if not rows:
            a0, a1 = _range(places[0], places[2], shape[1], x - reach, x + reach, odd)
            b0, b1 = _range(places[y0], places[y0 + 2], shape[2], y - reach, y + reach, odd)
            c0, c1 = _range(places[z0], places[z0 + 2], shape[3], z - reach, z + reach, odd)
        for a in range(a0, a1 + 1, 2):
            for b in range(b0, b1 + 1, 2):
                for c in range(c0, c1 + 1, 2):
                    if rows:
                        node = a >> 1
                        px, py, pz = places[node], places[count + node], places[2 * count + node]
                    else:
                        node = node_at(shape, a, b, c)
                        px, py, pz = places[a], places[y0 + b], places[z0 + c]
                    away = math.sqrt((px - x) ** 2 + (py - y) ** 2 + (pz - z) ** 2)
                    if away > reach or excluded[node]:
                        continue
                    if blocked(solids, margins, 0, x, y, z, px, py, pz):
                        continue
                    if found == len(nodes):
                        nodes = np.concatenate((nodes, np.empty_like(nodes)))
                        distances = np.concatenate((distances, np.empty_like(distances)))
                    nodes[found] = node
                    distances[found] = away
                    found += 1
    return nodes[:found], distances[:found]


@numba.njit(cache=True, nogil=True)
def nearest(solids: FloatArray, x: float, y: float, z: float) -> float:
    """Least signed distance of a place to the solids, [unit]; inf without any."""
    least = math.inf
    for s in range(len(solids) // WIDTH):
        k = WIDTH * s
        px, py, pz = in_body(
            axes_of(solids, s), x - solids[k], y - solids[k + 1], z - solids[k + 2]
        )
        least = min(least, distance(core_of(solids, s), px, py, pz)[0])
    return least


def warm() -> None:
    """Compile the kernels, or load them from numba's cache: one version for lattices and rows."""
    shape = (ROWS, 0, 0, 0, 0, 0, 0, 0, 0)
    ids, numbers = read_only(np.zeros(3, np.int32)), read_only(np.zeros(3))
    solids = read_only(np.zeros(0))
    flags = np.zeros(0, np.bool_)
    shell, whose, _ = exclude(shape, numbers, solids, 0.0, 0.0, flags)
    flags, shell, whose = read_only(flags), read_only(shell), read_only(whose)
    exits, weights = np.zeros(0, np.int32), np.zeros(0)
    mesh = (shape, ids, ids, numbers, ids, ids)
    shut(*mesh, exits, weights, solids, 0.0, flags, shell, whose)
    seen(shape, numbers, solids, solids, flags, 0.0, 0.0, 0.0, 0.0)
    nearest(solids, 0.0, 0.0, 0.0)
    ready.set()
