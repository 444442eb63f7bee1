"""Inner loops of the certificates, compiled by numba.

Both run uncompiled too, as ``solids.py_func``, with lists in place of the small arrays. Geometry is
in the body frame of one obstacle. A point is three successive numbers of a flat array; a piece of
the curve is a run of such points that holds the curve's stretch in its convex hull.
"""

from __future__ import annotations

import math
import threading

import numba
import numpy as np
from numba.extending import register_jitable

from abi.arrays import FloatArray, IntArray, read_only

ready = threading.Event()
"""Set once the kernels are compiled."""

CERTIFIED, REFUTED, UNDECIDED = 0, 1, 2
MOST_HALVINGS = 48
"""Of one polynomial: it is then finer than any distance worth deciding."""

_UNIT = 2.0**-53
_KEPT = 4  # directions of a piece that are tried again on the next node
_TINY = 1e-140  # squares of anything smaller lose digits

Plane = tuple[float, float, int, float, float, float, float]
"""First and last parameter, obstacle, direction x, y, z, and its least product with the piece."""

Outcome = tuple[int, float, int, float, FloatArray]
"""What was decided, then the parameter, obstacle and distance of the place where it was not
certified, then the planes found (k, 7)."""


@register_jitable
def _table(planes: list[Plane]) -> FloatArray:
    """The planes as rows, but for the first, which means nothing."""
    table = np.empty((len(planes) - 1, 7))
    for i in range(1, len(planes)):
        start, end, obstacle, x, y, z, level = planes[i]
        row = table[i - 1]
        row[0], row[1], row[2] = start, end, obstacle
        row[3], row[4], row[5], row[6] = x, y, z, level
    return table


@register_jitable
def _allowance(scale: float, degree: int, halvings: int, margin: float) -> float:
    """What rounding can take from a separation, [unit]: see ``abi.proof.certificate``."""
    return _UNIT * ((256 + 16 * degree + 12 * degree * halvings) * scale + 64 * abs(margin))


@register_jitable
def _halve(points: FloatArray, piece: int, left: int, right: int, width: int, ratio: float) -> None:
    """De Casteljau: the two parts, divided at ``ratio``, of the Bézier piece at point ``piece``."""
    for i in range(3 * width):
        points[3 * right + i] = points[3 * piece + i]
    for level in range(width):
        for k in range(3):
            points[3 * (left + level) + k] = points[3 * right + k]
        for i in range(3 * right, 3 * (right + width - 1 - level)):
            points[i] = (1 - ratio) * points[i] + ratio * points[i + 3]


@register_jitable
def _least(points: FloatArray, first: int, last: int, x: float, y: float, z: float) -> float:
    """Least product of a direction with the points from ``first`` up to ``last``."""
    least = math.inf
    for i in range(3 * first, 3 * last, 3):
        level = x * points[i] + y * points[i + 1] + z * points[i + 2]
        if level < least:
            least = level
    return least


@register_jitable
def _extent(
    points: FloatArray, first: int, last: int
) -> tuple[float, float, float, float, float, float]:
    """Low and high corner of the box around the points from ``first`` up to ``last``."""
    x0, y0, z0 = points[3 * first], points[3 * first + 1], points[3 * first + 2]
    x1, y1, z1 = x0, y0, z0
    for i in range(3 * first + 3, 3 * last, 3):
        x0, x1 = min(x0, points[i]), max(x1, points[i])
        y0, y1 = min(y0, points[i + 1]), max(y1, points[i + 1])
        z0, z1 = min(z0, points[i + 2]), max(z1, points[i + 2])
    return x0, y0, z0, x1, y1, z1


@register_jitable
def _from_solid(
    x: float, y: float, z: float, hx: float, hy: float, hz: float, disc: float, ball: float
) -> tuple[float, float, float, float]:
    """Signed distance of a point to a solid, and the unit direction away from it."""
    a, b, c = abs(x) - hx, abs(y) - hy, abs(z) - hz
    ux, uy, uz = math.copysign(1.0, x), math.copysign(1.0, y), math.copysign(1.0, z)
    if disc > 0:
        across = math.sqrt(x * x + y * y)
        a, b = across - disc, -math.inf
        ux, uy = (x / across, y / across) if across > _TINY else (1.0, 0.0)
        if a > 0 and c > 0:
            distance = math.sqrt(a * a + c * c)
            if distance > _TINY:
                a, c = a / distance, c / distance
                return distance - ball, ux * a, uy * a, uz * c
        if a >= c:
            return a - ball, ux, uy, 0.0
        return c - ball, 0.0, 0.0, uz
    ex, ey, ez = max(a, 0.0), max(b, 0.0), max(c, 0.0)
    distance = math.sqrt(ex * ex + ey * ey + ez * ez)
    if distance > _TINY:
        return distance - ball, ux * ex / distance, uy * ey / distance, uz * ez / distance
    if a >= b and a >= c:
        return a - ball, ux, 0.0, 0.0
    if b >= c:
        return b - ball, 0.0, uy, 0.0
    return c - ball, 0.0, 0.0, uz


@register_jitable
def _solid_support(
    x: float, y: float, z: float, hx: float, hy: float, hz: float, disc: float, ball: float
) -> float:
    """Support of a solid along a unit direction."""
    box = abs(x) * hx + abs(y) * hy + abs(z) * hz
    return box + disc * math.sqrt(x * x + y * y) + ball


@numba.njit(cache=True, nogil=True)
def solids(
    world: FloatArray,
    breaks: FloatArray,
    degree: int,
    points: FloatArray,
    frames: FloatArray,
    shapes: FloatArray,
    scales: FloatArray,
    margin: float,
    finest: float,
    most: int,
) -> Outcome:
    """Separate every piece of a curve from every solid.

    Depth first: a run of polynomials is tried whole, then in halves, then each polynomial is
    halved. Each try takes one direction, away from the solid at a point in the run's middle.

    Args:
        world: Bézier points of the s polynomials, flat (3 s (degree + 1),), world frame.
        breaks: parameters between them (s + 1,).
        degree: of each polynomial.
        points: room for the same in a body frame and for the halves, flat
            (3 (s + 2 MOST_HALVINGS + 2) (degree + 1),).
        frames: of each solid the rotation's rows and the position, flat (12 m,).
        shapes: of each solid the half sizes x, y, z of a box, the radius of a disc across z and
            the radius of a ball, flat (5 m,): the solid is the Minkowski sum of the three.
        scales: largest coordinate of the curve and of each solid together (m,), [unit].
        margin: distance to prove, [unit].
        finest: pieces smaller than this are not halved, [unit].
        most: tries that each solid may take.
    """
    width = degree + 1
    spans = len(breaks) - 1
    planes = [(0.0, 0.0, 0, 0.0, 0.0, 0.0, 0.0)]
    for o in range(len(scales)):
        f = 12 * o
        for i in range(0, 3 * spans * width, 3):
            x = world[i] - frames[f + 9]
            y = world[i + 1] - frames[f + 10]
            z = world[i + 2] - frames[f + 11]
            for k in range(3):
                points[i + k] = frames[f + k] * x + frames[f + 3 + k] * y + frames[f + 6 + k] * z
        hx, hy, hz = shapes[5 * o], shapes[5 * o + 1], shapes[5 * o + 2]
        disc, ball = shapes[5 * o + 3], shapes[5 * o + 4]
        tries = 0
        pending = [(0, spans * width, 0, breaks[0], breaks[spans])]
        while len(pending) > 0:
            first, last, halvings, start, end = pending.pop()
            run = last - first > width
            if run:
                span = (first + last) // width // 2
                middle, at = span * width, breaks[span]
                ahead = (first, middle, 0, start, at)
                behind = (middle, last, 0, at, end)
            else:
                left = (spans + 2 * halvings) * width
                middle, at = left + width, 0.5 * (start + end)
                _halve(points, first, left, middle, width, (at - start) / (end - start))
                ahead = (left, middle, halvings + 1, start, at)
                behind = (middle, middle + width, halvings + 1, at, end)
            x, y, z = points[3 * middle], points[3 * middle + 1], points[3 * middle + 2]
            away, x, y, z = _from_solid(x, y, z, hx, hy, hz, disc, ball)
            allowance = _allowance(scales[o], degree, halvings, margin)
            if away < margin - allowance:
                return REFUTED, at, o, away, _table(planes)
            need = margin + allowance
            level = _least(points, first, last, x, y, z)
            separated = level - _solid_support(x, y, z, hx, hy, hz, disc, ball) > need
            if not separated:
                x0, y0, z0, x1, y1, z1 = _extent(points, first, last)
                # A long run that passes a face obliquely is behind that face all the same.
                gx, gy, gz = max(x0, -x1) - hx, max(y0, -y1) - hy, max(z0, -z1) - hz
                gap = max(gx - disc, gy - disc, gz) - ball
                if gap > need:
                    separated = True
                    level = gap
                    x = y = z = 0.0
                    if gz - ball == gap:
                        z = math.copysign(1.0, z0 + z1)
                    elif gx - disc - ball == gap:
                        x = math.copysign(1.0, x0 + x1)
                    else:
                        y = math.copysign(1.0, y0 + y1)
                elif not run and max(x1 - x0, y1 - y0, z1 - z0) < finest:
                    return UNDECIDED, at, o, away, _table(planes)
            if separated:
                nx = frames[f] * x + frames[f + 1] * y + frames[f + 2] * z
                ny = frames[f + 3] * x + frames[f + 4] * y + frames[f + 5] * z
                nz = frames[f + 6] * x + frames[f + 7] * y + frames[f + 8] * z
                planes.append((start, end, o, nx, ny, nz, level))
                continue
            tries += 1
            if halvings == MOST_HALVINGS or tries > most or not start < at < end:
                return UNDECIDED, at, o, away, _table(planes)
            pending.append(behind)
            pending.append(ahead)
    return CERTIFIED, 0.0, -1, math.inf, _table(planes)


@register_jitable
def _from_triangle(
    px: float, py: float, pz: float, corners: FloatArray, t: int
) -> tuple[float, float, float, float]:
    """Distance of a point to a triangle, and the direction away from it; 0, 0, 0 when on it.

    Ericson, Real-Time Collision Detection, section 5.1.5.
    """
    ax, ay, az = corners[t], corners[t + 1], corners[t + 2]
    abx, aby, abz = corners[t + 3] - ax, corners[t + 4] - ay, corners[t + 5] - az
    acx, acy, acz = corners[t + 6] - ax, corners[t + 7] - ay, corners[t + 8] - az
    apx, apy, apz = px - ax, py - ay, pz - az
    bpx, bpy, bpz = apx - abx, apy - aby, apz - abz
    cpx, cpy, cpz = apx - acx, apy - acy, apz - acz
    d1, d2 = abx * apx + aby * apy + abz * apz, acx * apx + acy * apy + acz * apz
    d3, d4 = abx * bpx + aby * bpy + abz * bpz, acx * bpx + acy * bpy + acz * bpz
    d5, d6 = abx * cpx + aby * cpy + abz * cpz, acx * cpx + acy * cpy + acz * cpz
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    v = w = 0.0  # the nearest point is a + v ab + w ac
    if d1 <= 0 and d2 <= 0:
        pass
    elif d3 >= 0 and d4 <= d3:
        v = 1.0
    elif d6 >= 0 and d5 <= d6:
        w = 1.0
    elif vc <= 0 and d1 >= 0 and d3 <= 0 and d1 > d3:
        v = d1 / (d1 - d3)
    elif vb <= 0 and d2 >= 0 and d6 <= 0 and d2 > d6:
        w = d2 / (d2 - d6)
    elif va <= 0 and d4 >= d3 and d5 >= d6 and d4 - d3 + d5 - d6 > 0:
        w = (d4 - d3) / (d4 - d3 + d5 - d6)
        v = 1 - w
    elif va + vb + vc > 0:
        v, w = vb / (va + vb + vc), vc / (va + vb + vc)
    x = apx - v * abx - w * acx
    y = apy - v * aby - w * acy
    z = apz - v * abz - w * acz
    distance = math.sqrt(x * x + y * y + z * z)
    if distance <= _TINY:
        return 0.0, 0.0, 0.0, 0.0
    return distance, x / distance, y / distance, z / distance


@register_jitable
def _box_support(x: float, y: float, z: float, low: FloatArray, high: FloatArray, b: int) -> float:
    """Support along a direction of the box with its corners at ``low[b:]`` and ``high[b:]``."""
    sx = x * high[b] if x > 0 else x * low[b]
    sy = y * high[b + 1] if y > 0 else y * low[b + 1]
    sz = z * high[b + 2] if z > 0 else z * low[b + 2]
    return float(sx + sy + sz)


@register_jitable
def _triangle_support(x: float, y: float, z: float, corners: FloatArray, t: int) -> float:
    """Support along a direction of the triangle at ``corners[t:]``."""
    a = x * corners[t] + y * corners[t + 1] + z * corners[t + 2]
    b = x * corners[t + 3] + y * corners[t + 4] + z * corners[t + 5]
    c = x * corners[t + 6] + y * corners[t + 7] + z * corners[t + 8]
    return float(max(a, b, c))


@numba.njit(cache=True, nogil=True)
def surface(
    points: FloatArray,
    breaks: FloatArray,
    degree: int,
    low: FloatArray,
    high: FloatArray,
    leaves: IntArray,
    corners: FloatArray,
    scale: float,
    margin: float,
    finest: float,
    most: int,
) -> Outcome:
    """Separate every piece of a curve from every triangle of a surface.

    The nodes of a tree over the triangles are boxes, hence solids as any other: what is separated
    from a box is separated from all triangles in it. A piece carries the nodes that its parents
    were not separated from; a node larger than the piece is opened, and the piece is halved when
    smaller nodes or triangles are left.

    Args:
        points: Bézier points of the s polynomials, and room for the halves, body frame, flat as in
            :func:`solids`.
        breaks: parameters between them (s + 1,).
        degree: of each polynomial.
        low: corners of the tree's boxes, flat (3 n,); node k has the children 2 k + 1 and 2 k + 2.
        high: the opposite corners, flat (3 n,).
        leaves: leaf i holds the triangles from ``leaves[i]`` up to ``leaves[i + 1]``; the leaves
            are the last nodes.
        corners: of the triangles, flat (9 m,).
        scale: largest coordinate of curve and surface together, [unit].
        margin: distance to prove, at least 0, [unit].
        finest: pieces smaller than this are not halved, [unit].
        most: tries it may take.
    """
    width = degree + 1
    spans = len(breaks) - 1
    inner = len(leaves) - 2
    nodes = inner + len(leaves) - 1
    planes = [(0.0, 0.0, 0, 0.0, 0.0, 0.0, 0.0)]
    candidates = [0]
    work = [0]
    tries = 0
    pending = [(0, spans * width, 0, breaks[0], breaks[spans], 0, 1)]
    while len(pending) > 0:
        first, last, halvings, start, end, lowest, highest = pending.pop()
        while len(candidates) > highest:
            candidates.pop()
        run = last - first > width
        if run:
            span = (first + last) // width // 2
            left, middle, at = first, span * width, breaks[span]
        else:
            left = (spans + 2 * halvings) * width
            middle, at = left + width, 0.5 * (start + end)
            _halve(points, first, left, middle, width, (at - start) / (end - start))
        cx, cy, cz = points[3 * middle], points[3 * middle + 1], points[3 * middle + 2]
        x0, y0, z0, x1, y1, z1 = _extent(points, first, last)
        size = max(x1 - x0, y1 - y0, z1 - z0)
        allowance = _allowance(scale, degree, halvings, margin)
        need = margin + allowance
        made = len(planes)
        nearest = math.inf
        work.clear()
        for i in range(lowest, highest):
            work.append(candidates[i])
        while len(work) > 0:
            node = work.pop()
            tries += 1
            b, t = 3 * node, 9 * (node - nodes)
            separated = False
            for i in range(len(planes) - 1, max(made, len(planes) - _KEPT) - 1, -1):
                x, y, z, level = planes[i][3], planes[i][4], planes[i][5], planes[i][6]
                if node < nodes:
                    separated = level - _box_support(x, y, z, low, high, b) > need
                else:
                    separated = level - _triangle_support(x, y, z, corners, t) > need
                if separated:
                    break
            if separated:
                continue
            if node < nodes:
                # along an axis first: that costs next to nothing
                gx, gy, gz = max(x0 - high[b], low[b] - x1), 0.0, 0.0
                gy = max(y0 - high[b + 1], low[b + 1] - y1)
                gz = max(z0 - high[b + 2], low[b + 2] - z1)
                if max(gx, gy, gz) > need:
                    x = y = z = 0.0
                    if gx >= gy and gx >= gz:
                        x = 1.0 if x0 - high[b] == gx else -1.0
                    elif gy >= gz:
                        y = 1.0 if y0 - high[b + 1] == gy else -1.0
                    else:
                        z = 1.0 if z0 - high[b + 2] == gz else -1.0
                else:
                    x = cx - min(max(cx, low[b]), high[b])
                    y = cy - min(max(cy, low[b + 1]), high[b + 1])
                    z = cz - min(max(cz, low[b + 2]), high[b + 2])
                    away = math.sqrt(x * x + y * y + z * z)
                    if away > _TINY:
                        x, y, z = x / away, y / away, z / away
                level = _least(points, first, last, x, y, z)
                separated = level - _box_support(x, y, z, low, high, b) > need
            else:
                away, x, y, z = _from_triangle(cx, cy, cz, corners, t)
                if away < margin - allowance:
                    return REFUTED, at, 0, away, _table(planes)
                nearest = min(nearest, away)
                level = _least(points, first, last, x, y, z)
                separated = level - _triangle_support(x, y, z, corners, t) > need
            if separated:
                planes.append((start, end, 0, x, y, z, level))
                continue
            if node < nodes:
                dx, dy = high[b] - low[b], high[b + 1] - low[b + 1]
                if 2 * max(dx, dy, high[b + 2] - low[b + 2]) > size:
                    if node < inner:
                        work.append(2 * node + 1)
                        work.append(2 * node + 2)
                    else:
                        for i in range(leaves[node - inner], leaves[node - inner + 1]):
                            work.append(nodes + i)
                    continue
            candidates.append(node)
        if len(candidates) == highest:
            continue
        if not run and (size < finest or halvings == MOST_HALVINGS or not start < at < end):
            return UNDECIDED, at, 0, nearest, _table(planes)
        if tries > most:
            return UNDECIDED, at, 0, nearest, _table(planes)
        deeper = 0 if run else halvings + 1
        total = len(candidates)
        pending.append((middle, last if run else middle + width, deeper, at, end, highest, total))
        pending.append((left, middle, deeper, start, at, highest, total))
    return CERTIFIED, 0.0, -1, math.inf, _table(planes)


def warm() -> None:
    """Compile both kernels, or load them from numba's cache."""
    world, breaks = read_only(np.zeros(6)), np.array([0.0, 1.0])
    room = np.zeros(3 * (1 + 2 * MOST_HALVINGS + 2) * 2)
    frames = read_only(np.array([1.0, 0, 0, 0, 1, 0, 0, 0, 1, 5, 5, 5]))
    shapes, scales = read_only(np.array([1.0, 1, 1, 0, 0])), read_only(np.array([6.0]))
    solids(world, read_only(breaks.copy()), 1, room, frames, shapes, scales, 0.0, 1e-9, 9)
    low, high = read_only(np.ones(3)), read_only(np.full(3, 2.0))
    leaves, corners = read_only(np.array([0, 1], dtype=np.int32)), read_only(np.ones(9))
    surface(room, breaks, 1, low, high, leaves, corners, 6.0, 0.0, 1e-9, 9)
    ready.set()
