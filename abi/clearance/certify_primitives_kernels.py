"""Certificates of a curve's clearance from convex primitives.

Geometry is in the body frame of one primitive; for pieces and planes see
``abi.clearance.separation_kernels``, for the rows of numbers that describe primitives
``abi.obstacles.primitive_kernels``.
"""

from __future__ import annotations

import math

from numba.extending import register_jitable

from abi.arrays import FloatArray
from abi.clearance.bezier_kernels import extent_of
from abi.clearance.separation_kernels import (
    CERTIFIED,
    FINEST,
    MOST_HALVINGS,
    NO_PLANE,
    REFUTED,
    TINY,
    UNDECIDED,
    Outcome,
    Piece,
    Plane,
    allowance_of,
    halves_of,
    least_product,
    table_of,
)
from abi.compiled import FLOATS, NEW_FLOATS, compiled
from abi.obstacles.primitive_kernels import WIDTH, axes_of, centre_of, core_of, in_body, in_world
from abi.obstacles.vector_kernels import Vec3, sub, vec3_at

Summands = tuple[Vec3, float, float]
"""Half sizes of a box, radius of a disc across z, radius of a ball: a primitive is their sum."""


@register_jitable
def _summands_of(primitives: FloatArray, s: int) -> Summands:
    """Summands of primitive s."""
    a, b, c, radius, is_cylinder = core_of(primitives, s)
    if is_cylinder == 1:
        return (0.0, 0.0, c), a, 0.0
    return (a, b, c), 0.0, radius


@register_jitable
def _scale_of(primitives: FloatArray, s: int, size: float) -> float:
    """Largest coordinate of primitive s and of the curve together, [unit]."""
    x, y, z = centre_of(primitives, s)
    (hx, hy, hz), disc, ball = _summands_of(primitives, s)
    scale: float = max(abs(x), abs(y), abs(z)) + (hx + hy + hz + disc + ball) + size
    return scale


@register_jitable
def _from_primitive(p: Vec3, summands: Summands) -> tuple[float, Vec3]:
    """Signed distance of a point to a primitive, and the unit direction away from it."""
    half, disc, ball = summands
    x, y, z = p
    a, b, c = abs(x) - half[0], abs(y) - half[1], abs(z) - half[2]
    ux, uy, uz = math.copysign(1.0, x), math.copysign(1.0, y), math.copysign(1.0, z)
    if disc > 0:
        across = math.sqrt(x * x + y * y)
        a, b = across - disc, -math.inf
        ux, uy = (x / across, y / across) if across > TINY else (1.0, 0.0)
        if a > 0 and c > 0:
            distance = math.sqrt(a * a + c * c)
            if distance > TINY:
                a, c = a / distance, c / distance
                return distance - ball, (ux * a, uy * a, uz * c)
        if a >= c:
            return a - ball, (ux, uy, 0.0)
        return c - ball, (0.0, 0.0, uz)
    ex, ey, ez = max(a, 0.0), max(b, 0.0), max(c, 0.0)
    distance = math.sqrt(ex * ex + ey * ey + ez * ez)
    if distance > TINY:
        return distance - ball, (ux * ex / distance, uy * ey / distance, uz * ez / distance)
    if a >= b and a >= c:
        return a - ball, (ux, 0.0, 0.0)
    if b >= c:
        return b - ball, (0.0, uy, 0.0)
    return c - ball, (0.0, 0.0, uz)


@register_jitable
def _support(direction: Vec3, summands: Summands) -> float:
    """Support of a primitive along a unit direction."""
    (hx, hy, hz), disc, ball = summands
    x, y, z = direction
    box = abs(x) * hx + abs(y) * hy + abs(z) * hz
    return box + disc * math.sqrt(x * x + y * y) + ball


@register_jitable
def _behind_a_face(low: Vec3, high: Vec3, summands: Summands) -> tuple[float, Vec3]:
    """Distance along an axis from a primitive to a box around a piece, and that direction.

    A long run that passes a face obliquely is behind that face all the same.
    """
    half, disc, ball = summands
    gx = max(low[0], -high[0]) - half[0]
    gy = max(low[1], -high[1]) - half[1]
    gz = max(low[2], -high[2]) - half[2]
    gap = max(gx - disc, gy - disc, gz) - ball
    if gz - ball == gap:
        return gap, (0.0, 0.0, math.copysign(1.0, low[2] + high[2]))
    if gx - disc - ball == gap:
        return gap, (math.copysign(1.0, low[0] + high[0]), 0.0, 0.0)
    return gap, (0.0, math.copysign(1.0, low[1] + high[1]), 0.0)


@compiled(example=(FLOATS, FLOATS, NEW_FLOATS, FLOATS, 1.0, 0.0, 9))
def separate_from_primitives(
    world: FloatArray,
    breaks: FloatArray,
    points: FloatArray,
    primitives: FloatArray,
    size: float,
    margin: float,
    most_tries: int,
) -> Outcome:
    """Separate every piece of a curve from every primitive.

    Depth first: a run of polynomials is tried whole, then in halves, then each polynomial is
    halved. Each try takes one direction, away from the primitive at a point in the run's middle.

    Args:
        world: Bézier points of the s polynomials, flat (3 s (degree + 1),), world frame.
        breaks: parameters between them (s + 1,).
        points: room for the same in a body frame and for the halves, flat
            (3 (s + 2 MOST_HALVINGS + 2) (degree + 1),).
        primitives: rows (m WIDTH,), m >= 1.
        size: largest coordinate of the curve, [unit].
        margin: distance to prove, [unit].
        most_tries: tries that each primitive may take.
    """
    spans, count = len(breaks) - 1, len(primitives) // WIDTH
    width = len(world) // (3 * spans)
    planes = [NO_PLANE]
    finest = 0.0
    for s in range(count):
        finest = max(finest, FINEST * _scale_of(primitives, s, size))
    for s in range(count):
        axes, centre = axes_of(primitives, s), centre_of(primitives, s)
        for i in range(0, 3 * spans * width, 3):
            points[i], points[i + 1], points[i + 2] = in_body(axes, sub(vec3_at(world, i), centre))
        summands, scale = _summands_of(primitives, s), _scale_of(primitives, s, size)
        tries = 0
        pending = [Piece(0, spans * width, 0, breaks[0], breaks[spans])]
        while len(pending) > 0:
            piece = pending.pop()
            run = piece.last - piece.first > width
            at, ahead, behind = halves_of(points, piece, breaks, width)
            distance, direction = _from_primitive(vec3_at(points, 3 * behind.first), summands)
            allowance = allowance_of(scale, width - 1, piece.halvings, margin)
            if distance < margin - allowance:
                return REFUTED, at, s, distance, table_of(planes)
            need = margin + allowance
            level = least_product(points, piece.first, piece.last, direction)
            separated = level - _support(direction, summands) > need
            extent = math.inf
            if not separated:
                low, high = extent_of(points, 3 * piece.first, 3 * piece.last)
                extent = max(high[0] - low[0], high[1] - low[1], high[2] - low[2])
                level, direction = _behind_a_face(low, high, summands)
                separated = level > need
            if separated:
                normal = in_world(axes, direction)
                planes.append(Plane(piece.start, piece.end, s, normal, level))
                continue
            tries += 1
            final = piece.halvings == MOST_HALVINGS or (extent < finest and not run)
            if final or tries > most_tries or not piece.start < at < piece.end:
                return UNDECIDED, at, s, distance, table_of(planes)
            pending.append(behind)
            pending.append(ahead)
    return CERTIFIED, 0.0, -1, math.inf, table_of(planes)
