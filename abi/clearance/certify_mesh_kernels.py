"""Certificates against a surface of triangles.

Compiled by numba; ``surface`` runs uncompiled too, by its ``py_func``, with lists in place of the
small arrays. Geometry is in the surface's own coordinates; for pieces and planes see
``abi.clearance.separation_kernels``.
"""

from __future__ import annotations

import math

from numba.extending import register_jitable

from abi.arrays import FloatArray, IntArray
from abi.clearance.separation_kernels import (
    CERTIFIED,
    MOST_HALVINGS,
    REFUTED,
    TINY,
    UNDECIDED,
    Outcome,
    allowance_of,
    extent_of,
    halve,
    least_product,
    table_of,
)
from abi.compiled import FLOATS, IDS, NEW_FLOATS, compiled

_KEPT = 4  # directions of a piece that are tried again on the next node


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
    if distance <= TINY:
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


@compiled(
    example=(NEW_FLOATS, NEW_FLOATS, 1, FLOATS, FLOATS, IDS, FLOATS, 1.0, 0.0, 1e-9, 9),
    fallback=False,
)
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
            ``abi.clearance.certify_primitives_kernels``.
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
            halve(points, first, left, middle, width, (at - start) / (end - start))
        cx, cy, cz = points[3 * middle], points[3 * middle + 1], points[3 * middle + 2]
        x0, y0, z0, x1, y1, z1 = extent_of(points, first, last)
        size = max(x1 - x0, y1 - y0, z1 - z0)
        allowance = allowance_of(scale, degree, halvings, margin)
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
                    if away > TINY:
                        x, y, z = x / away, y / away, z / away
                level = least_product(points, first, last, x, y, z)
                separated = level - _box_support(x, y, z, low, high, b) > need
            else:
                away, x, y, z = _from_triangle(cx, cy, cz, corners, t)
                if away < margin - allowance:
                    return REFUTED, at, 0, away, table_of(planes)
                nearest = min(nearest, away)
                level = least_product(points, first, last, x, y, z)
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
            return UNDECIDED, at, 0, nearest, table_of(planes)
        if tries > most:
            return UNDECIDED, at, 0, nearest, table_of(planes)
        deeper = 0 if run else halvings + 1
        total = len(candidates)
        pending.append((middle, last if run else middle + width, deeper, at, end, highest, total))
        pending.append((left, middle, deeper, start, at, highest, total))
    return CERTIFIED, 0.0, -1, math.inf, table_of(planes)
