"""Lines of sight between convex solids, any-angle search and the tightening of a path.

Compiled by numba. ``any_angle`` and ``tighten`` run uncompiled too, by their ``py_func`` on plain
lists; the functions that they call are plain Python that numba compiles with its caller.

A solid is a row of numbers: centre (3), the body's axes in the world (9), half sizes of its core
(3), radius around the core, 1 for a cylinder and 0 otherwise, its bounds low and high (6). A box
is a core alone, a sphere and a capsule are a core with a radius. A cylinder's core is its own
radius, twice, and its half height.
"""

from __future__ import annotations

import heapq
import math
import threading

import numba
import numpy as np
from numba.extending import register_jitable

from abi.arrays import FloatArray, IntArray, read_only

ready = threading.Event()
"""Set once the kernels are compiled."""

WIDTH = 23
"""Numbers that describe a solid."""

_AXES, _HALF, _RADIUS, _CYLINDER, _LOW, _HIGH = 3, 12, 15, 16, 17, 20

_HALVINGS = 60
_STEPS = 14  # halvings when a corner is cut: to 1/16,000 of the leg
_LOOK_BACK = 64
_MOST_POINTS = 256
_SWEEPS = 24
_SETTLING = 10  # sweeps after each round of cuts
_SPLITS = 8
_SETTLED = 1e-6  # part of the length by which a sweep must shorten the path to be followed by one


@register_jitable
def _distance(solid: FloatArray, x: float, y: float, z: float) -> tuple[float, float, float, float]:
    """Signed distance of a body point, and a unit subgradient of it."""
    side = 1.0 if x >= 0 else -1.0
    front = 1.0 if y >= 0 else -1.0
    top = 1.0 if z >= 0 else -1.0
    if solid[_CYLINDER] == 1:
        across = math.sqrt(x * x + y * y)
        u, v = (x / across, y / across) if across > 0 else (1.0, 0.0)
        a, c = across - solid[_HALF], abs(z) - solid[_HALF + 2]
        if a > 0 and c > 0:
            away = math.sqrt(a * a + c * c)
            return away, a / away * u, a / away * v, c / away * top
        if a >= c:
            return a, u, v, 0.0
        return c, 0.0, 0.0, top
    a = abs(x) - solid[_HALF]
    b = abs(y) - solid[_HALF + 1]
    c = abs(z) - solid[_HALF + 2]
    p, q, r = max(a, 0.0), max(b, 0.0), max(c, 0.0)
    away = math.sqrt(p * p + q * q + r * r)
    if away > 0:
        return away - solid[_RADIUS], p / away * side, q / away * front, r / away * top
    if a >= b and a >= c:
        return a - solid[_RADIUS], side, 0.0, 0.0
    if b >= c:
        return b - solid[_RADIUS], 0.0, front, 0.0
    return c - solid[_RADIUS], 0.0, 0.0, top


@register_jitable
def _in_body(solid: FloatArray, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A direction of the world in the body's axes."""
    return (
        solid[_AXES] * x + solid[_AXES + 1] * y + solid[_AXES + 2] * z,
        solid[_AXES + 3] * x + solid[_AXES + 4] * y + solid[_AXES + 5] * z,
        solid[_AXES + 6] * x + solid[_AXES + 7] * y + solid[_AXES + 8] * z,
    )


@register_jitable
def _apart(
    solid: FloatArray,
    margin: float,
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
) -> bool:
    """Whether the bounds of the segment a..b are farther than ``margin`` from those of a solid."""
    apart: bool = (
        min(ax, bx) - solid[_HIGH] >= margin
        or solid[_LOW] - max(ax, bx) >= margin
        or min(ay, by) - solid[_HIGH + 1] >= margin
        or solid[_LOW + 1] - max(ay, by) >= margin
        or min(az, bz) - solid[_HIGH + 2] >= margin
        or solid[_LOW + 2] - max(az, bz) >= margin
    )
    return apart


@register_jitable
def _near(
    solid: FloatArray,
    margin: float,
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
) -> bool:
    """Whether the segment a..b comes nearer than ``margin`` to a solid.

    The distance is convex along the segment, so a tangent at t bounds it from below: on one side
    of t it stays above the margin, on the other it does so for a known stretch. The rest is halved.
    """
    px, py, pz = _in_body(solid, ax - solid[0], ay - solid[1], az - solid[2])
    dx, dy, dz = _in_body(solid, bx - ax, by - ay, bz - az)
    low, high = 0.0, 1.0
    t = 0.0
    for halving in range(_HALVINGS):
        away, gx, gy, gz = _distance(solid, px + t * dx, py + t * dy, pz + t * dz)
        if away < margin:
            return True
        slope = gx * dx + gy * dy + gz * dz
        if slope < 0:
            low = max(low, t - (away - margin) / slope)
        elif slope > 0:
            high = min(high, t - (away - margin) / slope)
        else:
            return False
        if low >= high:
            return False
        t = 1.0 if halving == 0 else (low + high) / 2
    return False


@register_jitable
def blocked(
    solids: FloatArray,
    margins: FloatArray,
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
) -> bool:
    """Whether the segment a..b comes nearer to a solid than that solid's margin.

    Args:
        solids: rows (k, WIDTH).
        margins: (k,) [unit].
        ax, ay, az: one end, [unit], world.
        bx, by, bz: the other end.
    """
    for k in range(len(solids)):
        solid = solids[k]
        if not _apart(solid, margins[k], ax, ay, az, bx, by, bz) and _near(
            solid, margins[k], ax, ay, az, bx, by, bz
        ):
            return True
    return False


@register_jitable
def _touch(
    solids: FloatArray,
    margins: FloatArray,
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
    first, nx, ny, nz = 2.0, 0.0, 0.0, 0.0
    for k in range(len(solids)):
        solid = solids[k]
        if _apart(solid, margins[k] + reach, ax, ay, az, bx, by, bz):
            continue
        px, py, pz = _in_body(solid, ax - solid[0], ay - solid[1], az - solid[2])
        dx, dy, dz = _in_body(solid, bx - ax, by - ay, bz - az)
        low, high = 0.0, 1.0
        for _ in range(40):
            t = (low + high) / 2
            _, gx, gy, gz = _distance(solid, px + t * dx, py + t * dy, pz + t * dz)
            if gx * dx + gy * dy + gz * dz > 0:
                high = t
            else:
                low = t
        away, gx, gy, gz = _distance(solid, px + low * dx, py + low * dy, pz + low * dz)
        if away < margins[k] + reach and low < first:
            first = low
            nx = solid[_AXES] * gx + solid[_AXES + 3] * gy + solid[_AXES + 6] * gz
            ny = solid[_AXES + 1] * gx + solid[_AXES + 4] * gy + solid[_AXES + 7] * gz
            nz = solid[_AXES + 2] * gx + solid[_AXES + 5] * gy + solid[_AXES + 8] * gz
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
    before = margins[1 if i == 1 else 0]
    after = margins[2 if i == len(x) - 2 else 0]
    return not blocked(solids, before, x[i - 1], y[i - 1], z[i - 1], px, py, pz) and not blocked(
        solids, after, px, py, pz, x[i + 1], y[i + 1], z[i + 1]
    )


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
    before = margins[1 if i == 1 else 0]
    after = margins[2 if i == len(x) - 2 else 0]
    ax, ay, az = x[i - 1] - x[i], y[i - 1] - y[i], z[i - 1] - z[i]
    bx, by, bz = x[i + 1] - x[i], y[i + 1] - y[i], z[i + 1] - z[i]
    to_a = math.sqrt(ax * ax + ay * ay + az * az)
    to_b = math.sqrt(bx * bx + by * by + bz * bz)
    if to_a == 0 or to_b == 0:
        return
    mx, my, mz = _touch(solids, before, reach, x[i], y[i], z[i], x[i - 1], y[i - 1], z[i - 1])
    nx, ny, nz = _touch(solids, after, reach, x[i], y[i], z[i], x[i + 1], y[i + 1], z[i + 1])
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
    length = 0.0
    for i in range(1, len(x)):
        length += _gap(x[i - 1], y[i - 1], z[i - 1], x[i], y[i], z[i])
    for _ in range(sweeps):
        i = 1
        while i < len(x) - 1:
            row = (1 if i == 1 else 0) + (2 if i == len(x) - 2 else 0)
            if not blocked(
                solids, margins[row], x[i - 1], y[i - 1], z[i - 1], x[i + 1], y[i + 1], z[i + 1]
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
                    margins[0],
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
    cost = [0.0]
    parent = [0]
    for j in range(1, last + 1):
        best, by = math.inf, j - 1
        for i in range(max(0, j - _LOOK_BACK), j):
            through = cost[i] + _gap(x[i], y[i], z[i], x[j], y[j], z[j])
            row = (1 if i == 0 else 0) + (2 if j == last else 0)
            if through < best and (
                i == j - 1 or not blocked(solids, margins[row], x[i], y[i], z[i], x[j], y[j], z[j])
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
        solids: rows (k, WIDTH).
        margins: (4, k) distance from each solid that a segment keeps, [unit]: in general, from the
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
    indptr: IntArray,
    indices: IntArray,
    lengths: FloatArray,
    x: FloatArray,
    y: FloatArray,
    z: FloatArray,
    start: np.int32,
    goal: np.int32,
    solids: FloatArray,
    margins: FloatArray,
) -> IntArray:
    """Lazy Theta* (Nash, Koenig and Tovey, 2010): a path whose segments need not be edges.

    A node takes over its neighbour's parent unseen; whether they see each other is tested when the
    node is expanded, and if they do not, the best expanded neighbour becomes its parent.

    Args:
        indptr: (n + 1,) where each node's edges begin.
        indices: (2e,) neighbours.
        lengths: (2e,) lengths of the edges, [unit]; edges are taken to be clear.
        x, y, z: (n,) nodes, [unit], world.
        start: node id, of the type of ``indices``.
        goal: node id.
        solids: rows (k, WIDTH).
        margins: (4, k), see ``tighten``.

    Returns:
        Node ids of the path (m,), from start to goal; empty when there is none.
    """
    nodes = len(indptr) - 1
    cost = np.full(nodes, np.inf)
    parent = np.full(nodes, -1, np.int32)
    seen = np.zeros(nodes, np.bool_)
    closed = np.zeros(nodes, np.bool_)
    tx, ty, tz = x[goal], y[goal], z[goal]
    cost[start] = 0.0
    parent[start] = start
    seen[start] = True
    to_go = _gap(x[start], y[start], z[start], tx, ty, tz)
    queue = [(to_go, to_go, start)]
    while len(queue) > 0:
        node = heapq.heappop(queue)[2]
        if closed[node]:
            continue
        px, py, pz = x[node], y[node], z[node]
        origin = parent[node]
        if not seen[node]:
            row = (1 if origin == start else 0) + (2 if node == goal else 0)
            if blocked(solids, margins[row], x[origin], y[origin], z[origin], px, py, pz):
                cost[node] = np.inf
                for k in range(indptr[node], indptr[node + 1]):
                    through = cost[indices[k]] + lengths[k]
                    if closed[indices[k]] and through < cost[node]:
                        cost[node] = through
                        parent[node] = indices[k]
                origin = parent[node]
        closed[node] = True
        if node == goal:
            break
        so_far = cost[origin]
        ox, oy, oz = x[origin], y[origin], z[origin]
        for k in range(indptr[node], indptr[node + 1]):
            neighbour = indices[k]
            if closed[neighbour]:
                continue
            qx, qy, qz = x[neighbour], y[neighbour], z[neighbour]
            through = so_far + _gap(ox, oy, oz, qx, qy, qz)
            if through < cost[neighbour]:
                cost[neighbour] = through
                parent[neighbour] = origin
                seen[neighbour] = origin == node
                to_go = _gap(qx, qy, qz, tx, ty, tz)
                heapq.heappush(queue, (through + to_go, to_go, neighbour))
    if not closed[goal]:
        return np.empty(0, np.int32)
    path = [goal]
    while path[-1] != start:
        path.append(parent[path[-1]])
    return np.array(path[::-1], np.int32)


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
        solids: rows (k, WIDTH).
        margins: (4, k), see ``tighten``.
        most: length that the path must be below, [unit].

    Returns:
        Indices of the path (m,); empty when there is none.
    """
    count = len(x)
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
            row = (1 if node == 0 else 0) + (2 if i == 1 else 0)
            if (
                not closed[i]
                and through < cost[i]
                and through + to_go[i] < most
                and not blocked(solids, margins[row], x[node], y[node], z[node], x[i], y[i], z[i])
            ):
                cost[i] = through
                parent[i] = node
    path = [1]
    while path[-1] != 0:
        path.append(parent[path[-1]])
    return np.array(path[::-1], np.int32)


def warm() -> None:
    """Compile the kernels, or load them from numba's cache, for the arrays of a Graph."""
    indptr = read_only(np.array([0, 1, 2], dtype=np.int32))
    indices = read_only(np.array([1, 0], dtype=np.int32))
    ones = read_only(np.ones(2))
    solids, margins = read_only(np.zeros((0, WIDTH))), read_only(np.zeros((4, 0)))
    ends = (np.int32(0), np.int32(1))
    any_angle(indptr, indices, ones, ones, ones, ones, *ends, solids, margins)
    tighten(ones, ones, ones, solids, margins, read_only(np.zeros(6)), 1e-6)
    through(ones, ones, ones, solids, margins, 1.0)
    ready.set()
