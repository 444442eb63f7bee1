"""Certificates of a curve's clearance from convex primitives.

Geometry is in the body frame of one primitive; for pieces and planes see
``abi.clearance.separation_kernels``, for the rows of numbers that describe primitives
``abi.obstacles.primitive_kernels``.
"""

from __future__ import annotations

import math

from abi.arrays import FloatArray
from abi.clearance.bezier_kernels import extent_of
from abi.clearance.separation_kernels import (
    CERTIFIED,
    FINEST,
    MOST_HALVINGS,
    NO_PLANE,
    REFUTED,
    UNDECIDED,
    Outcome,
    Piece,
    SeparatingPlane,
    allowance_of,
    apart_along_axis,
    halves_of,
    least_product,
    table_of,
)
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, NEW_FLOATS, compiled
from abi.obstacles.primitive_kernels import (
    WIDTH,
    axes_of,
    centre_of,
    core_of,
    in_body,
    in_world,
    signed_distance_gradient,
    support,
)
from abi.obstacles.vector_kernels import sub, vec3_at


@jitable
def _scale_of(primitives: FloatArray, s: int, size: float) -> float:
    """Largest coordinate of primitive s and of the curve together, [unit]."""
    x, y, z = centre_of(primitives, s)
    core = core_of(primitives, s)
    scale: float = max(abs(x), abs(y), abs(z)) + core.x + core.y + core.z + core.radius + size
    return scale


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
        core, scale = core_of(primitives, s), _scale_of(primitives, s, size)
        tries = 0
        pending = [Piece(0, spans * width, 0, breaks[0], breaks[spans])]
        while len(pending) > 0:
            piece = pending.pop()
            run = piece.last - piece.first > width
            at, ahead, behind = halves_of(points, piece, breaks, width)
            middle = vec3_at(points, 3 * behind.first)
            distance, direction = signed_distance_gradient(core, middle)
            allowance = allowance_of(scale, width - 1, piece.halvings, margin)
            if distance < margin - allowance:
                return REFUTED, at, s, distance, table_of(planes)
            need = margin + allowance
            level = least_product(points, piece.first, piece.last, direction)
            separated = level - support(core, direction) > need
            extent = math.inf
            if not separated:
                low, high = extent_of(points, 3 * piece.first, 3 * piece.last)
                extent = max(high[0] - low[0], high[1] - low[1], high[2] - low[2])
                inner, outer = (-core.x, -core.y, -core.z), (core.x, core.y, core.z)
                gap, direction = apart_along_axis(inner, outer, (low, high))
                level = gap - core.radius
                separated = level > need
            if separated:
                normal = in_world(axes, direction)
                planes.append(SeparatingPlane(piece.start, piece.end, s, normal, level))
                continue
            tries += 1
            final = piece.halvings == MOST_HALVINGS or (extent < finest and not run)
            if final or tries > most_tries or not piece.start < at < piece.end:
                return UNDECIDED, at, s, distance, table_of(planes)
            pending.append(behind)
            pending.append(ahead)
    return CERTIFIED, 0.0, -1, math.inf, table_of(planes)
