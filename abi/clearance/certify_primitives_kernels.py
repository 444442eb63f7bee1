"""Certificates against convex solids.

Compiled by numba; ``solids`` runs uncompiled too, by its ``py_func`` on plain lists. Geometry is in
the body frame of one obstacle; for pieces and planes see ``abi.clearance.separation_kernels``, for
the rows of numbers that describe solids ``abi.obstacles.primitive_kernels``.
"""

from __future__ import annotations

import math

from numba.extending import register_jitable

from abi.arrays import FloatArray
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
from abi.compiled import FLOATS, NEW_FLOATS, compiled
from abi.obstacles.primitive_kernels import WIDTH, axes_of, centre_of, core_of, in_body, in_world
from abi.obstacles.vector_kernels import sub, vec3_at


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
        ux, uy = (x / across, y / across) if across > TINY else (1.0, 0.0)
        if a > 0 and c > 0:
            distance = math.sqrt(a * a + c * c)
            if distance > TINY:
                a, c = a / distance, c / distance
                return distance - ball, ux * a, uy * a, uz * c
        if a >= c:
            return a - ball, ux, uy, 0.0
        return c - ball, 0.0, 0.0, uz
    ex, ey, ez = max(a, 0.0), max(b, 0.0), max(c, 0.0)
    distance = math.sqrt(ex * ex + ey * ey + ez * ez)
    if distance > TINY:
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


@register_jitable
def _shape_of(solids: FloatArray, o: int) -> tuple[float, float, float, float, float]:
    """Box half sizes, disc radius and ball radius whose Minkowski sum a solid is."""
    a, b, c, radius, is_cylinder = core_of(solids, o)
    if is_cylinder == 1:
        return 0.0, 0.0, c, a, 0.0
    return a, b, c, 0.0, radius


@register_jitable
def _scale_of(solids: FloatArray, o: int, size: float) -> float:
    """Largest coordinate of a solid and of the curve together, [unit]."""
    x, y, z = centre_of(solids, o)
    hx, hy, hz, disc, ball = _shape_of(solids, o)
    away = max(abs(x), abs(y), abs(z))
    scale: float = away + (hx + hy + hz + disc + ball) + size
    return scale


@compiled(example=(FLOATS, FLOATS, 1, NEW_FLOATS, FLOATS, 1.0, 0.0, 1e-9, 9))
def solids(
    world: FloatArray,
    breaks: FloatArray,
    degree: int,
    points: FloatArray,
    obstacles: FloatArray,
    size: float,
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
        obstacles: rows of the solids (m WIDTH,), m >= 1.
        size: largest coordinate of the curve, [unit].
        margin: distance to prove, [unit].
        finest: pieces smaller than this part of the largest coordinate are not halved.
        most: tries that each solid may take.
    """
    width = degree + 1
    spans = len(breaks) - 1
    planes = [(0.0, 0.0, 0, 0.0, 0.0, 0.0, 0.0)]
    count = len(obstacles) // WIDTH
    smallest = 0.0
    for o in range(count):
        smallest = max(smallest, finest * _scale_of(obstacles, o, size))
    for o in range(count):
        centre, axes = centre_of(obstacles, o), axes_of(obstacles, o)
        for i in range(0, 3 * spans * width, 3):
            turned = in_body(axes, sub(vec3_at(world, i), centre))
            points[i], points[i + 1], points[i + 2] = turned
        hx, hy, hz, disc, ball = _shape_of(obstacles, o)
        scale = _scale_of(obstacles, o, size)
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
                halve(points, first, left, middle, width, (at - start) / (end - start))
                ahead = (left, middle, halvings + 1, start, at)
                behind = (middle, middle + width, halvings + 1, at, end)
            x, y, z = points[3 * middle], points[3 * middle + 1], points[3 * middle + 2]
            away, x, y, z = _from_solid(x, y, z, hx, hy, hz, disc, ball)
            allowance = allowance_of(scale, degree, halvings, margin)
            if away < margin - allowance:
                return REFUTED, at, o, away, table_of(planes)
            need = margin + allowance
            level = least_product(points, first, last, x, y, z)
            separated = level - _solid_support(x, y, z, hx, hy, hz, disc, ball) > need
            if not separated:
                x0, y0, z0, x1, y1, z1 = extent_of(points, first, last)
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
                elif not run and max(x1 - x0, y1 - y0, z1 - z0) < smallest:
                    return UNDECIDED, at, o, away, table_of(planes)
            if separated:
                nx, ny, nz = in_world(axes, (x, y, z))
                planes.append((start, end, o, nx, ny, nz, level))
                continue
            tries += 1
            if halvings == MOST_HALVINGS or tries > most or not start < at < end:
                return UNDECIDED, at, o, away, table_of(planes)
            pending.append(behind)
            pending.append(ahead)
    return CERTIFIED, 0.0, -1, math.inf, table_of(planes)
