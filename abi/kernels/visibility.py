"""Any-angle search between convex solids and the tightening of a path.

Compiled by numba. ``any_angle``, ``tighten`` and ``through`` run uncompiled too, by their
``py_func`` on plain lists; the functions that they call are plain Python that numba compiles with
its caller. For the rows of numbers that describe solids see ``abi.kernels.solids``.
"""

from __future__ import annotations

import heapq
import math
import threading

import numba
import numpy as np
from numba.extending import register_jitable

from abi.arrays import FloatArray, IntArray, read_only
from abi.kernels.net import LINKED, ROWS, SIDES, Shape, across, cell
from abi.kernels.solids import WIDTH, apart, axes_of, blocked, core_of, distance, in_body, in_world

ready = threading.Event()
"""Set once the kernels are compiled."""

_STEPS = 14  # halvings when a corner is cut: to 1/16,000 of the leg
_LOOK_BACK = 64
_MOST_POINTS = 256
_SWEEPS = 24
_SETTLING = 10  # sweeps after each round of cuts
_SPLITS = 8
_SETTLED = 1e-6  # part of the length by which a sweep must shorten the path to be followed by one


@register_jitable
def _touch(
    solids: FloatArray,
    margins: FloatArray,
    first: int,
    reach: float,
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
) -> tuple[float, float, float]:
    """Unit normal, in the world, of the solid that the segment a..b touches first from a.

    Zero where none is within ``reach`` of its margin.
    """
    earliest, nx, ny, nz = 2.0, 0.0, 0.0, 0.0
    for s in range(len(solids) // WIDTH):
        limit = margins[first + s] + reach
        if apart(solids, s, limit, ax, ay, az, bx, by, bz):
            continue
        k = WIDTH * s
        axes, core = axes_of(solids, s), core_of(solids, s)
        px, py, pz = in_body(axes, ax - solids[k], ay - solids[k + 1], az - solids[k + 2])
        dx, dy, dz = in_body(axes, bx - ax, by - ay, bz - az)
        low, high = 0.0, 1.0
        for _ in range(40):
            t = (low + high) / 2
            _, gx, gy, gz = distance(core, px + t * dx, py + t * dy, pz + t * dz)
            if gx * dx + gy * dy + gz * dz > 0:
                high = t
            else:
                low = t
        away, gx, gy, gz = distance(core, px + low * dx, py + low * dy, pz + low * dz)
        if away < limit and low < earliest:
            earliest = low
            nx, ny, nz = in_world(axes, gx, gy, gz)
    return nx, ny, nz


@register_jitable
def _gap(ax: float, ay: float, az: float, bx: float, by: float, bz: float) -> float:
    return math.sqrt((ax - bx) ** 2 + (ay - by) ** 2 + (az - bz) ** 2)


@register_jitable
def _legs(
    x: list[float], y: list[float], z: list[float], i: int, px: float, py: float, pz: float
) -> float:
    """Length of the path from point i - 1 by p to point i + 1."""
    return _gap(x[i - 1], y[i - 1], z[i - 1], px, py, pz) + _gap(
        px, py, pz, x[i + 1], y[i + 1], z[i + 1]
    )


@register_jitable
def _fits(
    x: list[float],
    y: list[float],
    z: list[float],
    i: int,
    px: float,
    py: float,
    pz: float,
    solids: FloatArray,
    margins: FloatArray,
) -> bool:
    """Whether point i can be p: both its legs are clear."""
    count = len(solids) // WIDTH
    before = count if i == 1 else 0
    after = 2 * count if i == len(x) - 2 else 0
    return not blocked(
        solids, margins, before, x[i - 1], y[i - 1], z[i - 1], px, py, pz
    ) and not blocked(solids, margins, after, px, py, pz, x[i + 1], y[i + 1], z[i + 1])


@register_jitable
def _straightened(
    x: list[float],
    y: list[float],
    z: list[float],
    i: int,
    solids: FloatArray,
    margins: FloatArray,
) -> None:
    """Move point i towards the chord of its neighbours as far as its legs stay clear."""
    before = _gap(x[i - 1], y[i - 1], z[i - 1], x[i], y[i], z[i])
    after = _gap(x[i], y[i], z[i], x[i + 1], y[i + 1], z[i + 1])
    if before + after == 0:
        return
    share = before / (before + after)
    dx = x[i - 1] + share * (x[i + 1] - x[i - 1]) - x[i]
    dy = y[i - 1] + share * (y[i + 1] - y[i - 1]) - y[i]
    dz = z[i - 1] + share * (z[i + 1] - z[i - 1]) - z[i]
    low, high, step = 0.0, 1.0, 0.5**_STEPS
    for _ in range(_STEPS):
        px, py, pz = x[i] + step * dx, y[i] + step * dy, z[i] + step * dz
        if _fits(x, y, z, i, px, py, pz, solids, margins):
            low = step
        elif low == 0:
            break
        else:
            high = step
        step = (low + high) / 2
    if low > 0:
        x[i] += low * dx
        y[i] += low * dy
        z[i] += low * dz


@register_jitable
def _slid(
    x: list[float],
    y: list[float],
    z: list[float],
    i: int,
    solids: FloatArray,
    margins: FloatArray,
    bounds: FloatArray,
    reach: float,
) -> None:
    """Move point i along the surfaces that its legs touch to where the legs are shortest.

    Both legs stay in the planes in which they touch, so the point moves along the line in which
    these meet; where there is only one plane, along the pull of the legs within it.
    """
    count = len(solids) // WIDTH
    before = count if i == 1 else 0
    after = 2 * count if i == len(x) - 2 else 0
    ax, ay, az = x[i - 1] - x[i], y[i - 1] - y[i], z[i - 1] - z[i]
    bx, by, bz = x[i + 1] - x[i], y[i + 1] - y[i], z[i + 1] - z[i]
    to_a = math.sqrt(ax * ax + ay * ay + az * az)
    to_b = math.sqrt(bx * bx + by * by + bz * bz)
    if to_a == 0 or to_b == 0:
        return
    mx, my, mz = _touch(
        solids, margins, before, reach, x[i], y[i], z[i], x[i - 1], y[i - 1], z[i - 1]
    )
    nx, ny, nz = _touch(
        solids, margins, after, reach, x[i], y[i], z[i], x[i + 1], y[i + 1], z[i + 1]
    )
    wx, wy, wz = my * nz - mz * ny, mz * nx - mx * nz, mx * ny - my * nx
    if wx * wx + wy * wy + wz * wz < 1e-8:
        if nx == 0 and ny == 0 and nz == 0:
            nx, ny, nz = mx, my, mz
        wx, wy, wz = ax / to_a + bx / to_b, ay / to_a + by / to_b, az / to_a + bz / to_b
        into = wx * nx + wy * ny + wz * nz
        wx, wy, wz = wx - into * nx, wy - into * ny, wz - into * nz
    size = math.sqrt(wx * wx + wy * wy + wz * wz)
    if size < 1e-9:
        return
    wx, wy, wz = wx / size, wy / size, wz / size
    # On a line the way from a to b is shortest where the mirror image of b about it is in line.
    along_a = ax * wx + ay * wy + az * wz
    along_b = bx * wx + by * wy + bz * wz
    off_a = math.sqrt(max(to_a * to_a - along_a * along_a, 0.0))
    off_b = math.sqrt(max(to_b * to_b - along_b * along_b, 0.0))
    if off_a + off_b == 0:
        return
    step = (along_a * off_b + along_b * off_a) / (off_a + off_b)
    for _ in range(6):
        px, py, pz = x[i] + step * wx, y[i] + step * wy, z[i] + step * wz
        inside = (
            bounds[0] <= px <= bounds[3]
            and bounds[1] <= py <= bounds[4]
            and bounds[2] <= pz <= bounds[5]
        )
        if (
            inside
            and _legs(x, y, z, i, px, py, pz) < to_a + to_b
            and _fits(x, y, z, i, px, py, pz, solids, margins)
        ):
            x[i], y[i], z[i] = px, py, pz
            return
        step /= 4


@register_jitable
def _settled(
    x: list[float],
    y: list[float],
    z: list[float],
    solids: FloatArray,
    margins: FloatArray,
    bounds: FloatArray,
    sweeps: int,
) -> None:
    """Drop, straighten and slide the points in turn until the path gets no shorter."""
    count = len(solids) // WIDTH
    length = 0.0
    for i in range(1, len(x)):
        length += _gap(x[i - 1], y[i - 1], z[i - 1], x[i], y[i], z[i])
    for _ in range(sweeps):
        i = 1
        while i < len(x) - 1:
            first = ((1 if i == 1 else 0) + (2 if i == len(x) - 2 else 0)) * count
            if not blocked(
                solids, margins, first, x[i - 1], y[i - 1], z[i - 1], x[i + 1], y[i + 1], z[i + 1]
            ):
                x.pop(i)
                y.pop(i)
                z.pop(i)
                continue
            _straightened(x, y, z, i, solids, margins)
            _slid(x, y, z, i, solids, margins, bounds, 1e-3 * length)
            i += 1
        before = length
        length = 0.0
        for k in range(1, len(x)):
            length += _gap(x[k - 1], y[k - 1], z[k - 1], x[k], y[k], z[k])
        if before - length < _SETTLED * length:
            break


@register_jitable
def _split(
    x: list[float],
    y: list[float],
    z: list[float],
    solids: FloatArray,
    margins: FloatArray,
    worth: float,
) -> bool:
    """Cut each corner, as far from it on both legs, where that wins ``worth``; whether any was."""
    any_cut = False
    i = 1
    while i < len(x) - 1 and len(x) < _MOST_POINTS:
        before = _gap(x[i - 1], y[i - 1], z[i - 1], x[i], y[i], z[i])
        after = _gap(x[i], y[i], z[i], x[i + 1], y[i + 1], z[i + 1])
        if before == 0 or after == 0:
            i += 1
            continue
        ax, ay, az = (
            (x[i - 1] - x[i]) / before,
            (y[i - 1] - y[i]) / before,
            (z[i - 1] - z[i]) / before,
        )
        bx, by, bz = (x[i + 1] - x[i]) / after, (y[i + 1] - y[i]) / after, (z[i + 1] - z[i]) / after
        # between two bends each takes half of the leg
        high = min(before if i == 1 else before / 2, after if i == len(x) - 2 else after / 2)
        won = 2 - _gap(ax, ay, az, bx, by, bz)
        low, cut = 0.0, worth / max(won, 1e-12)
        if cut < high:
            for _ in range(_STEPS):
                if not blocked(
                    solids,
                    margins,
                    0,
                    x[i] + cut * ax,
                    y[i] + cut * ay,
                    z[i] + cut * az,
                    x[i] + cut * bx,
                    y[i] + cut * by,
                    z[i] + cut * bz,
                ):
                    low = cut
                elif low == 0:
                    break
                else:
                    high = cut
                cut = (low + high) / 2
        if low > 0:
            x.insert(i + 1, x[i] + low * bx)
            y.insert(i + 1, y[i] + low * by)
            z.insert(i + 1, z[i] + low * bz)
            x[i] += low * ax
            y[i] += low * ay
            z[i] += low * az
            any_cut = True
            i += 1
        i += 1
    return any_cut


@register_jitable
def _shortcut(
    x: FloatArray, y: FloatArray, z: FloatArray, solids: FloatArray, margins: FloatArray
) -> list[int]:
    """The shortest way from first to last by points of the path that see each other."""
    last = len(x) - 1
    count = len(solids) // WIDTH
    cost = [0.0]
    parent = [0]
    for j in range(1, last + 1):
        best, by = math.inf, j - 1
        for i in range(max(0, j - _LOOK_BACK), j):
            through = cost[i] + _gap(x[i], y[i], z[i], x[j], y[j], z[j])
            first = ((1 if i == 0 else 0) + (2 if j == last else 0)) * count
            if through < best and (
                i == j - 1
                or not blocked(solids, margins, first, x[i], y[i], z[i], x[j], y[j], z[j])
            ):
                best, by = through, i
        cost.append(best)
        parent.append(by)
    kept = [last]
    while kept[-1] != 0:
        kept.append(parent[kept[-1]])
    return kept[::-1]


@numba.njit(cache=True, nogil=True)
def tighten(
    x: FloatArray,
    y: FloatArray,
    z: FloatArray,
    solids: FloatArray,
    margins: FloatArray,
    bounds: FloatArray,
    worth: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Pull a path taut: never longer, and every new segment clear.

    Skips points that it can do without, then moves each to where its legs are shortest, on the
    planes in which these touch a solid, until the length stops improving. Then cuts the corners:
    around a rounded edge one point becomes several.

    Args:
        x, y, z: (n,) the path, n >= 2, its segments clear, [unit], world.
        solids: (k WIDTH,) rows, one after the other.
        margins: (4k,) distance from each solid that a segment keeps, [unit]: in general, from the
            first point, to the last point, from the first to the last.
        bounds: (6,) low and high corner of the box in which the path stays, [unit].
        worth: part of the length that a cut corner must win.

    Returns:
        The coordinates of the new path, (m,) each.
    """
    kept = _shortcut(x, y, z, solids, margins)
    px = [x[i] for i in kept]
    py = [y[i] for i in kept]
    pz = [z[i] for i in kept]
    _settled(px, py, pz, solids, margins, bounds, _SWEEPS)
    length = 0.0
    for i in range(1, len(px)):
        length += _gap(px[i - 1], py[i - 1], pz[i - 1], px[i], py[i], pz[i])
    for _ in range(_SPLITS):
        if not _split(px, py, pz, solids, margins, worth * length):
            break
        _settled(px, py, pz, solids, margins, bounds, _SETTLING)
    return np.array(px), np.array(py), np.array(pz)


@numba.njit(cache=True, nogil=True)
def any_angle(
    shape: Shape,
    offsets: IntArray,
    steps: IntArray,
    places: FloatArray,
    indptr: IntArray,
    indices: IntArray,
    exits: IntArray,
    weights: FloatArray,
    tails: IntArray,
    heads: IntArray,
    link_weights: FloatArray,
    x: FloatArray,
    y: FloatArray,
    z: FloatArray,
    start: int,
    goal: int,
    solids: FloatArray,
    margins: FloatArray,
) -> IntArray:
    """Lazy Theta* (Nash, Koenig and Tovey, 2010): a path whose segments need not be edges.

    A node takes over its neighbour's parent unseen; whether they see each other is tested when the
    node is expanded, and if they do not, the best expanded neighbour becomes its parent.

    Args:
        shape, offsets, steps, places, indptr, indices: the mesh, see ``abi.kernels.net``.
        exits, weights, tails, heads, link_weights: its open edges, see there; taken to be clear.
        x, y, z: (n,) nodes, [unit], world.
        start: node id.
        goal: node id.
        solids: (k WIDTH,) rows, one after the other.
        margins: (4k,), see ``tighten``.

    Returns:
        Node ids of the path (m,), from start to goal; empty when there is none.
    """
    kind, nodes, directions, cross = shape[0], shape[5], shape[6], shape[7]
    solid_count = len(solids) // WIDTH
    total = len(x)
    cost = np.full(total, np.inf)
    parent = np.full(total, -1, np.int32)
    seen = np.zeros(total, np.uint8)
    closed = np.zeros(total, np.uint8)
    near = np.empty(shape[8] + len(tails), np.int32)
    far = np.empty(shape[8] + len(tails), np.float64)
    tx, ty, tz = x[goal], y[goal], z[goal]
    cost[start] = 0.0
    parent[start] = start
    seen[start] = 1
    to_go = _gap(x[start], y[start], z[start], tx, ty, tz)
    queue = [(to_go, to_go, np.int32(start))]
    while len(queue) > 0:
        node = int(heapq.heappop(queue)[2])
        if closed[node] == 1:
            continue
        count, links = 0, len(tails)
        if node < nodes:
            bits = exits[node]
            if (bits >> LINKED) & 1 == 0:
                links = 0
            if kind == ROWS:
                for k in range(indptr[node], indptr[node + 1]):
                    near[count] = indices[k]
                    far[count] = weights[k]
                    count += 1 if weights[k] < np.inf else 0
            else:
                row = 0 if node < shape[4] else directions
                i, j, h = cell(shape, node)
                other = across(shape, i, j, h)
                for k in range(directions if (bits >> SIDES) & 63 else SIDES):
                    near[count] = (other if k < cross else node) + offsets[row + k]
                    far[count] = weights[k]
                    count += (bits >> k) & 1
        for k in range(links):
            if tails[k] == node or heads[k] == node:
                near[count] = heads[k] if tails[k] == node else tails[k]
                far[count] = link_weights[k]
                count += 1
        px, py, pz = x[node], y[node], z[node]
        origin = parent[node]
        if seen[node] == 0:
            first = ((1 if origin == start else 0) + (2 if node == goal else 0)) * solid_count
            if blocked(solids, margins, first, x[origin], y[origin], z[origin], px, py, pz):
                cost[node] = np.inf
                for k in range(count):
                    through = cost[near[k]] + far[k]
                    if closed[near[k]] == 1 and through < cost[node]:
                        cost[node] = through
                        parent[node] = near[k]
                origin = parent[node]
        closed[node] = 1
        if node == goal:
            break
        so_far = cost[origin]
        ox, oy, oz = x[origin], y[origin], z[origin]
        for k in range(count):
            neighbour = near[k]
            if closed[neighbour] == 1:
                continue
            qx, qy, qz = x[neighbour], y[neighbour], z[neighbour]
            through = so_far + _gap(ox, oy, oz, qx, qy, qz)
            if through < cost[neighbour]:
                cost[neighbour] = through
                parent[neighbour] = origin
                seen[neighbour] = 1 if origin == node else 0
                to_go = _gap(qx, qy, qz, tx, ty, tz)
                heapq.heappush(queue, (through + to_go, to_go, neighbour))
    if closed[goal] == 0:
        return np.empty(0, np.int32)
    length = 1
    place = goal
    while place != start:
        place = int(parent[place])
        length += 1
    path = np.empty(length, np.int32)
    place = goal
    for k in range(length - 1, -1, -1):
        path[k] = place
        place = int(parent[place])
    return path


@numba.njit(cache=True, nogil=True)
def through(
    x: FloatArray,
    y: FloatArray,
    z: FloatArray,
    solids: FloatArray,
    margins: FloatArray,
    most: float,
) -> IntArray:
    """The shortest path from the first place to the second by places that see each other.

    A* on the visibility graph; whether two places see each other is tested only where it matters.

    Args:
        x, y, z: (n,) places, n >= 2, [unit], world.
        solids: (k WIDTH,) rows, one after the other.
        margins: (4k,), see ``tighten``.
        most: length that the path must be below, [unit].

    Returns:
        Indices of the path (m,); empty when there is none.
    """
    count = len(x)
    solid_count = len(solids) // WIDTH
    cost = np.full(count, np.inf)
    parent = np.zeros(count, np.int32)
    closed = np.zeros(count, np.bool_)
    to_go = [_gap(x[i], y[i], z[i], x[1], y[1], z[1]) for i in range(count)]
    cost[0] = 0.0
    while True:
        node, least = -1, most
        for i in range(count):
            if not closed[i] and cost[i] + to_go[i] < least:
                node, least = i, cost[i] + to_go[i]
        if node < 0:
            return np.empty(0, np.int32)
        if node == 1:
            break
        closed[node] = True
        for i in range(1, count):
            through = cost[node] + _gap(x[node], y[node], z[node], x[i], y[i], z[i])
            first = ((1 if node == 0 else 0) + (2 if i == 1 else 0)) * solid_count
            if (
                not closed[i]
                and through < cost[i]
                and through + to_go[i] < most
                and not blocked(solids, margins, first, x[node], y[node], z[node], x[i], y[i], z[i])
            ):
                cost[i] = through
                parent[i] = node
    path = [1]
    while path[-1] != 0:
        path.append(parent[path[-1]])
    return np.array(path[::-1], np.int32)


def warm() -> None:
    """Compile the kernels, or load them from numba's cache: one version for all meshes."""
    shape = (ROWS, 0, 0, 0, 0, 2, 0, 0, 1)
    ids = read_only(np.array([0, 1, 2], dtype=np.int32))
    indices = read_only(np.array([1, 0], dtype=np.int32))
    none, numbers = read_only(np.zeros(0, np.int32)), read_only(np.zeros(0))
    ones = read_only(np.ones(2))
    mesh = (shape, none, none, numbers, ids, indices)
    ways = (read_only(np.zeros(2, np.int32)), ones, none, none, numbers)
    any_angle(*mesh, *ways, ones, ones, ones, 0, 1, numbers, numbers)
    tighten(ones, ones, ones, numbers, numbers, read_only(np.zeros(6)), 1e-6)
    through(ones, ones, ones, numbers, numbers, 1.0)
    ready.set()
