"""Squared distances of points and segments to a triangle.

The formulas are Ericson's (Real-Time Collision Detection, 2005, sections 5.1.3, 5.1.9 and 5.1.10).
Plain Python that numba compiles with its caller.
"""

from __future__ import annotations

import math

from abi.arrays import FloatArray
from abi.compilation.jitable import jitable
from abi.obstacles.vector_kernels import Vec3, axpy, cross, dot, sub, vec3_at

THIN = 3e-8
"""A triangle whose height is below this part of its longest side counts as its sides."""

Triangle = tuple[Vec3, Vec3, Vec3]


@jitable
def triangle_at(corners: FloatArray, number: int) -> Triangle:
    """A triangle of a tree."""
    k = 9 * number
    return vec3_at(corners, k), vec3_at(corners, k + 3), vec3_at(corners, k + 6)


@jitable
def clamp(t: float) -> float:
    """The number in [0, 1] nearest to t."""
    return min(max(t, 0.0), 1.0)


@jitable
def on_side(x: Vec3, a: Vec3, e: Vec3) -> float:
    """Parameter of the point a + t e, t in [0, 1], nearest to x."""
    ee = dot(e, e)
    return clamp(dot(e, sub(x, a)) / ee) if ee > 0.0 else 0.0


@jitable
def point_to_triangle(x: Vec3, triangle: Triangle, most: float) -> float:
    """Squared distance of a point and a triangle; ``most`` where it is not below that.

    The plane counts where x is over the triangle, but for one that is too thin to have a plane; the
    sides count otherwise.
    """
    a, b, c = triangle
    ab, ac, bc = sub(b, a), sub(c, a), sub(c, b)
    to_a = sub(x, a)
    n = cross(ab, ac)
    nn = dot(n, n)
    longest = max(dot(ab, ab), dot(ac, ac), dot(bc, bc))
    if nn > THIN * THIN * longest * longest:
        height = dot(n, to_a)
        square = height * height / nn
        if square >= most:
            return most
        if (
            dot(cross(ab, to_a), n) >= 0.0
            and dot(cross(bc, sub(x, b)), n) >= 0.0
            and dot(cross(ac, to_a), n) <= 0.0
        ):
            return square
    for start, side in ((a, ab), (a, ac), (b, bc)):
        gap = sub(axpy(on_side(x, start, side), side, start), x)
        most = min(most, dot(gap, gap))
    return most


@jitable
def closest_point(x: Vec3, triangle: Triangle) -> Vec3:
    """The point of a triangle nearest to x."""
    a, b, c = triangle
    ab, ac, bc = sub(b, a), sub(c, a), sub(c, b)
    n = cross(ab, ac)
    nn = dot(n, n)
    longest = max(dot(ab, ab), dot(ac, ac), dot(bc, bc))
    if nn > THIN * THIN * longest * longest and over_triangle(x, a, b, c, n):
        return axpy(-dot(n, sub(x, a)) / nn, n, x)
    best, closest = math.inf, a
    for start, side in ((a, ab), (a, ac), (b, bc)):
        there = axpy(on_side(x, start, side), side, start)
        gap = sub(there, x)
        if dot(gap, gap) < best:
            best, closest = dot(gap, gap), there
    return closest


@jitable
def over_triangle(x: Vec3, a: Vec3, b: Vec3, c: Vec3, n: Vec3) -> bool:
    """Check whether the projection of x along the normal n lies in the triangle."""
    return (
        dot(cross(sub(b, a), sub(x, a)), n) >= 0.0
        and dot(cross(sub(c, b), sub(x, b)), n) >= 0.0
        and dot(cross(sub(a, c), sub(x, c)), n) >= 0.0
    )


@jitable
def segment_to_triangle(p: Vec3, q: Vec3, triangle: Triangle) -> float:
    """Squared distance of the segment from p to q and a triangle, which may be degenerate.

    0 where it passes through; else the closest point is at an end of it or on a side.
    """
    a, b, c = triangle
    d = sub(q, p)
    n = cross(sub(b, a), sub(c, a))
    nn = dot(n, n)
    best: float = math.inf
    if nn > 0.0:
        at_p, at_q = dot(n, sub(p, a)), dot(n, sub(q, a))
        through = at_p * at_q <= 0.0 and at_p != at_q
        if through and over_triangle(axpy(at_p / (at_p - at_q), d, p), a, b, c, n):
            return 0.0
        if over_triangle(p, a, b, c, n):
            best = at_p * at_p / nn
        if over_triangle(q, a, b, c, n):
            best = min(best, at_q * at_q / nn)
    for start, side in ((a, sub(b, a)), (b, sub(c, b)), (c, sub(a, c))):
        gap = between_segments(p, d, start, side)
        best = min(best, dot(gap, gap))
    return best


@jitable
def between_segments(p: Vec3, d: Vec3, a: Vec3, e: Vec3) -> Vec3:
    """Way to the segment p + s d, s in [0, 1], from a + t e, t in [0, 1], where it is shortest."""
    r = sub(p, a)
    dd, ee, er = dot(d, d), dot(e, e), dot(e, r)
    s, t = 0.0, 0.0
    if dd > 0.0:
        dr = dot(d, r)
        if ee > 0.0:
            de = dot(d, e)
            determinant = dd * ee - de * de
            if determinant > 0.0:
                s = clamp((de * er - dr * ee) / determinant)
            t = (de * s + er) / ee
            if t < 0.0:
                t = 0.0
                s = clamp(-dr / dd)
            elif t > 1.0:
                t = 1.0
                s = clamp((de - dr) / dd)
        else:
            s = clamp(-dr / dd)
    elif ee > 0.0:
        t = clamp(er / ee)
    return sub(axpy(s, d, p), axpy(t, e, a))
