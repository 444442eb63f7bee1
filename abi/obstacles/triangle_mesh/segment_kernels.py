"""Distances of segments to triangles, by a bounding volume hierarchy.

The formulas are Ericson's (Real-Time Collision Detection, 2005, sections 5.1.9 and 5.1.10).
"""

from __future__ import annotations

import math

import numpy as np
from numba.extending import register_jitable

from abi.arrays import FloatArray
from abi.compiled import FLOATS, IDS, NEW_FLOATS, POINTS, compiled
from abi.obstacles.triangle_mesh.bvh import TriangleTree
from abi.obstacles.vector_kernels import Vec3, axpy, cross, dot, norm, sub, vec3_at


@register_jitable
def _clamp(t: float) -> float:
    return min(max(t, 0.0), 1.0)


@register_jitable
def _between_segments(p: Vec3, d: Vec3, a: Vec3, e: Vec3) -> float:
    """Squared distance of the segments p + s d and a + t e, s and t in [0, 1]."""
    r = sub(p, a)
    dd, ee, er = dot(d, d), dot(e, e), dot(e, r)
    s, t = 0.0, 0.0
    if dd > 0.0:
        dr = dot(d, r)
        if ee > 0.0:
            de = dot(d, e)
            determinant = dd * ee - de * de
            if determinant > 0.0:
                s = _clamp((de * er - dr * ee) / determinant)
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
    gap = sub(axpy(s, d, p), axpy(t, e, a))
    return dot(gap, gap)


@register_jitable
def _projects_into(x: Vec3, a: Vec3, b: Vec3, c: Vec3, n: Vec3) -> bool:
    """Whether the projection of x along the normal n lies in the triangle."""
    return (
        dot(cross(sub(b, a), sub(x, a)), n) >= 0.0
        and dot(cross(sub(c, b), sub(x, b)), n) >= 0.0
        and dot(cross(sub(a, c), sub(x, c)), n) >= 0.0
    )


@register_jitable
def _to_triangle(p: Vec3, q: Vec3, a: Vec3, b: Vec3, c: Vec3) -> float:
    """Squared distance of the segment from p to q and a triangle, which may be degenerate.

    0 where it passes through; else the closest point is at an end of it or on a side.
    """
    d = sub(q, p)
    n = cross(sub(b, a), sub(c, a))
    nn = dot(n, n)
    best = math.inf
    if nn > 0.0:
        at_p, at_q = dot(n, sub(p, a)), dot(n, sub(q, a))
        through = at_p * at_q <= 0.0 and at_p != at_q
        if through and _projects_into(axpy(at_p / (at_p - at_q), d, p), a, b, c, n):
            return 0.0
        if _projects_into(p, a, b, c, n):
            best = at_p * at_p / nn
        if _projects_into(q, a, b, c, n):
            best = min(best, at_q * at_q / nn)
    best = min(best, _between_segments(p, d, a, sub(b, a)))
    best = min(best, _between_segments(p, d, b, sub(c, b)))
    return min(best, _between_segments(p, d, c, sub(a, c)))


@register_jitable
def _box_bound(p: Vec3, q: Vec3, low: Vec3, high: Vec3) -> float:
    """Lower bound of the squared distance of the segment from p to q and a box.

    The greater of two: of the box around the segment, and of the ball around the box.
    """
    apart, radius = 0.0, 0.0
    for k in range(3):
        gap = max(low[k] - max(p[k], q[k]), min(p[k], q[k]) - high[k], 0.0)
        apart += gap * gap
        radius += (high[k] - low[k]) * (high[k] - low[k]) / 4
    centre = ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2)
    d, to_centre = sub(q, p), sub(centre, p)
    dd = dot(d, d)
    nearest = axpy(_clamp(dot(to_centre, d) / dd) if dd > 0.0 else 0.0, d, (0.0, 0.0, 0.0))
    ball = max(norm(sub(to_centre, nearest)) - math.sqrt(radius), 0.0)
    return max(apart, ball * ball)


@compiled(
    example=(
        *(TriangleTree(FLOATS, FLOATS, IDS, FLOATS, 1.0), POINTS, POINTS),
        *(NEW_FLOATS, NEW_FLOATS),
    ),
    fallback=False,
)
def segment_distances(
    tree: TriangleTree,
    starts: FloatArray,
    ends: FloatArray,
    enough: FloatArray,
    most: FloatArray,
) -> FloatArray:
    """Distance (n,) of segments to the nearest of all triangles in a tree.

    Args:
        tree: over the triangles.
        starts: (n, 3) first ends.
        ends: (n, 3) second ends, which may be the same.
        enough: (n,) a distance at or below which the search ends: the result is then the distance
            of some triangle, not of the nearest.
        most: (n,) a distance past which the outcome may be any greater one, inf too.
    """
    low, high, leaves, corners, _ = tree
    distances = np.empty(len(starts))
    inner = len(leaves) - 2
    stack = np.empty(128, np.int64)
    bounds = np.empty(128)
    for i in range(len(starts)):
        p, q = vec3_at(starts[i], 0), vec3_at(ends[i], 0)
        best = math.inf
        limit = most[i] * most[i]
        stop = enough[i] * enough[i]
        stack[0] = 0
        bounds[0] = _box_bound(p, q, vec3_at(low, 0), vec3_at(high, 0))
        waiting = 1
        while waiting > 0 and best > stop:
            waiting -= 1
            box = stack[waiting]
            if bounds[waiting] >= best or bounds[waiting] > limit:
                continue
            if box >= inner:
                for t in range(9 * leaves[box - inner], 9 * leaves[box - inner + 1], 9):
                    a, b, c = vec3_at(corners, t), vec3_at(corners, t + 3), vec3_at(corners, t + 6)
                    best = min(best, _to_triangle(p, q, a, b, c))
                continue
            near, far = 2 * box + 1, 2 * box + 2
            to_near = _box_bound(p, q, vec3_at(low, 3 * near), vec3_at(high, 3 * near))
            to_far = _box_bound(p, q, vec3_at(low, 3 * far), vec3_at(high, 3 * far))
            if to_far < to_near:
                near, far = far, near
                to_near, to_far = to_far, to_near
            stack[waiting], bounds[waiting] = far, to_far
            stack[waiting + 1], bounds[waiting + 1] = near, to_near
            waiting += 2
        distances[i] = math.sqrt(best)
    return distances
