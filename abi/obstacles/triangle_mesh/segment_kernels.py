"""Distance from segments to triangles by a tree of boxes, compiled by numba.

The formulas are Ericson's (Real-Time Collision Detection, 2005, sections 5.1.9 and 5.1.10).
"""

from __future__ import annotations

import math

import numpy as np
from numba.extending import register_jitable

from abi.arrays import FloatArray, IntArray
from abi.compiled import FLOATS, IDS, NEW_FLOATS, PLACES, compiled
from abi.obstacles.vector_kernels import Vector, along, cross, dot, less, point


@register_jitable
def _clamp(t: float) -> float:
    return min(max(t, 0.0), 1.0)


@register_jitable
def _between(p: Vector, d: Vector, a: Vector, e: Vector) -> float:
    """Squared distance of the segments p + s d and a + t e, s and t in [0, 1]."""
    r = less(p, a)
    dd, ee, er = dot(d, d), dot(e, e), dot(e, r)
    s, t = 0.0, 0.0
    if dd > 0.0:
        dr = dot(d, r)
        if ee > 0.0:
            de = dot(d, e)
            turn = dd * ee - de * de
            if turn > 0.0:
                s = _clamp((de * er - dr * ee) / turn)
            t = (de * s + er) / ee
            if t < 0.0:
                t = 0.0
                s = _clamp(-dr / dd)
            elif t > 1.0:
                t = 1.0
                s = _clamp((de - dr) / dd)
        else:
            s = _clamp(-dr / dd)
    elif ee > 0.0:
        t = _clamp(er / ee)
    gap = less(along(p, d, s), along(a, e, t))
    return dot(gap, gap)


@register_jitable
def over(x: Vector, a: Vector, b: Vector, c: Vector, n: Vector) -> bool:
    """Whether x lies over the triangle, seen along its normal n."""
    return (
        dot(cross(less(b, a), less(x, a)), n) >= 0.0
        and dot(cross(less(c, b), less(x, b)), n) >= 0.0
        and dot(cross(less(a, c), less(x, c)), n) >= 0.0
    )


@register_jitable
def _to_triangle(p: Vector, q: Vector, a: Vector, b: Vector, c: Vector) -> float:
    """Squared distance of the segment from p to q and a triangle, which may be degenerate.

    0 where it passes through; else the nearest place is at an end of it or at a side.
    """
    d = less(q, p)
    n = cross(less(b, a), less(c, a))
    nn = dot(n, n)
    best = math.inf
    if nn > 0.0:
        at_p, at_q = dot(n, less(p, a)), dot(n, less(q, a))
        through = at_p * at_q <= 0.0 and at_p != at_q
        if through and over(along(p, d, at_p / (at_p - at_q)), a, b, c, n):
            return 0.0
        if over(p, a, b, c, n):
            best = at_p * at_p / nn
        if over(q, a, b, c, n):
            best = min(best, at_q * at_q / nn)
    best = min(best, _between(p, d, a, less(b, a)))
    best = min(best, _between(p, d, b, less(c, b)))
    return min(best, _between(p, d, c, less(a, c)))


@register_jitable
def _to_box(p: Vector, q: Vector, low: Vector, high: Vector) -> float:
    """A bound from below of the squared distance of the segment from p to q and a box.

    The greater of two: from the box around the segment, and from the ball around the box.
    """
    apart, radius = 0.0, 0.0
    for k in range(3):
        gap = max(low[k] - max(p[k], q[k]), min(p[k], q[k]) - high[k], 0.0)
        apart += gap * gap
        radius += (high[k] - low[k]) * (high[k] - low[k]) / 4
    centre = ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2)
    d, way = less(q, p), less(centre, p)
    dd = dot(d, d)
    gap_to = less(way, along((0.0, 0.0, 0.0), d, _clamp(dot(way, d) / dd) if dd > 0.0 else 0.0))
    ball = max(math.sqrt(dot(gap_to, gap_to)) - math.sqrt(radius), 0.0)
    return max(apart, ball * ball)


@compiled(
    example=(FLOATS, FLOATS, IDS, FLOATS, PLACES, PLACES, NEW_FLOATS, NEW_FLOATS), fallback=False
)
def segment_distances(
    low: FloatArray,
    high: FloatArray,
    leaves: IntArray,
    corners: FloatArray,
    starts: FloatArray,
    ends: FloatArray,
    enough: FloatArray,
    most: FloatArray,
) -> FloatArray:
    """Distance (n,) of segments to the nearest of all triangles in a tree.

    Args:
        low: lowest corners of the boxes, flat, see :mod:`abi.obstacles.triangle_mesh.bvh`.
        high: highest corners.
        leaves: where the triangles of each leaf begin, and the end of the last.
        corners: of the triangles, flat.
        starts: (n, 3) first ends.
        ends: (n, 3) second ends, which may be the same.
        enough: (n,) a distance that ends the search when it is found or less: it is then the
            distance of some triangle, not of the nearest.
        most: (n,) a distance past which the outcome may be any greater one, inf too.
    """
    found = np.empty(len(starts))
    inner = len(leaves) - 2
    stack = np.empty(128, np.int64)
    bounds = np.empty(128)
    for i in range(len(starts)):
        p, q = point(starts[i], 0), point(ends[i], 0)
        best = math.inf
        limit = most[i] * most[i]
        stop = enough[i] * enough[i]
        stack[0] = 0
        bounds[0] = _to_box(p, q, point(low, 0), point(high, 0))
        waiting = 1
        while waiting > 0 and best > stop:
            waiting -= 1
            box = stack[waiting]
            if bounds[waiting] >= best or bounds[waiting] > limit:
                continue
            if box >= inner:
                for t in range(9 * leaves[box - inner], 9 * leaves[box - inner + 1], 9):
                    a, b, c = point(corners, t), point(corners, t + 3), point(corners, t + 6)
                    best = min(best, _to_triangle(p, q, a, b, c))
                continue
            near, far = 2 * box + 1, 2 * box + 2
            to_near = _to_box(p, q, point(low, 3 * near), point(high, 3 * near))
            to_far = _to_box(p, q, point(low, 3 * far), point(high, 3 * far))
            if to_far < to_near:
                near, far = far, near
                to_near, to_far = to_far, to_near
            stack[waiting], bounds[waiting] = far, to_far
            stack[waiting + 1], bounds[waiting + 1] = near, to_near
            waiting += 2
        found[i] = math.sqrt(best)
    return found
