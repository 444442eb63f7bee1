"""Certificates of a curve's clearance from convex primitives and from surfaces of triangles.

Geometry is in the body frame of one primitive, or in the surface's own coordinates. For pieces and
planes see ``abi.curves.clearance.separation_kernels``, for the rows of numbers that describe
primitives ``abi.obstacles.primitive_kernels``. Nodes of a surface are numbered as the tree's boxes
are, and the triangles after them.
"""

from __future__ import annotations

import math

from abi.arrays import FloatArray
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, NEW_FLOATS, compiled
from abi.curves.clearance.separation_kernels import (
    CERTIFIED,
    FINEST,
    MOST_HALVINGS,
    NO_PLANE,
    REFUTED,
    TINY,
    UNDECIDED,
    Outcome,
    Piece,
    SeparatingPlane,
    allowance_of,
    apart_along_axis,
    extent_of,
    halves_of,
    least_product,
    table_of,
)
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
from abi.obstacles.triangle_mesh.bvh import NO_TREE, TriangleTree, box_of, highest
from abi.obstacles.triangle_mesh.triangle_kernels import closest_point
from abi.obstacles.vector_kernels import Vec3, dot, norm, sub, triangle_at, vec3_at


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


_KEPT = 4  # directions of a piece that are tried again on the next node


@jitable
def _away_from(p: Vec3, closest: Vec3) -> tuple[float, Vec3]:
    """Distance of a point from the closest one of a convex set, and the way from it; zero on it."""
    offset = sub(p, closest)
    distance = norm(offset)
    if distance <= TINY:
        return 0.0, (0.0, 0.0, 0.0)
    return distance, (offset[0] / distance, offset[1] / distance, offset[2] / distance)


@jitable
def _support(direction: Vec3, tree: TriangleTree, node: int) -> float:
    """Support of a box of the tree, or of a triangle, along a direction."""
    nodes = 2 * len(tree.leaves) - 3
    if node < nodes:
        low, high = box_of(tree, node)
        return highest(direction, low, high)
    a, b, c = triangle_at(tree.corners, node - nodes)
    return max(dot(direction, a), dot(direction, b), dot(direction, c))


@jitable
def _from_box(low: Vec3, high: Vec3, extent: tuple[Vec3, Vec3], middle: Vec3, need: float) -> Vec3:
    """Direction in which a box may be separated from a piece.

    Args:
        low, high: corners of the box.
        extent: corners of the box around the piece.
        middle: a point in the middle of the piece.
        need: distance to prove, [unit].
    """
    # along an axis first: that costs next to nothing
    gap, way = apart_along_axis(low, high, extent)
    if gap > need:
        return way
    closest = (
        min(max(middle[0], low[0]), high[0]),
        min(max(middle[1], low[1]), high[1]),
        min(max(middle[2], low[2]), high[2]),
    )
    return _away_from(middle, closest)[1]


@jitable
def _separated_again(
    planes: list[SeparatingPlane], first: int, tree: TriangleTree, node: int, need: float
) -> bool:
    """Check if one of the latest planes of a piece, from ``first`` on, separates a node, too."""
    for i in range(len(planes) - 1, max(first, len(planes) - _KEPT) - 1, -1):
        if planes[i].level - _support(planes[i].direction, tree, node) > need:
            return True
    return False


@jitable
def _open(tree: TriangleTree, node: int, work: list[int]) -> None:
    """Add the contents of a box of the tree: two boxes or some triangles."""
    inner = len(tree.leaves) - 2
    if node < inner:
        work.append(2 * node + 1)
        work.append(2 * node + 2)
        return
    nodes = 2 * inner + 1
    for i in range(tree.leaves[node - inner], tree.leaves[node - inner + 1]):
        work.append(nodes + i)


@compiled(example=(NEW_FLOATS, NEW_FLOATS, 1, NO_TREE, 1.0, 0.0, 9))
def separate_from_mesh(
    points: FloatArray,
    breaks: FloatArray,
    degree: int,
    tree: TriangleTree,
    scale: float,
    margin: float,
    most_tries: int,
) -> Outcome:
    """Separate every piece of a curve from every triangle of a surface.

    The nodes of a tree over the triangles are boxes, convex as any primitive: a piece separated
    from a box is separated from all triangles in it. A piece carries the nodes that its parents
    were not separated from; a node larger than the piece is opened, and the piece is halved when
    smaller nodes or triangles are left.

    Args:
        points: Bézier points of the s polynomials, and room for the halves, body frame, flat as in
            ``abi.curves.clearance.certify_curve_kernels``.
        breaks: parameters between them (s + 1,).
        degree: of each polynomial.
        tree: over the triangles.
        scale: largest coordinate of curve and surface together, [unit].
        margin: distance to prove, at least 0, [unit].
        most_tries: tries it may take.
    """
    width, spans = degree + 1, len(breaks) - 1
    nodes = 2 * len(tree.leaves) - 3
    planes, candidates, work, tries = [NO_PLANE], [0], [0], 0
    whole = Piece(0, spans * width, 0, breaks[0], breaks[spans])
    pending = [(whole, 0, 1)]
    while len(pending) > 0:
        piece, lowest, highest = pending.pop()
        while len(candidates) > highest:
            candidates.pop()
        run = piece.last - piece.first > width
        at, ahead, behind = halves_of(points, piece, breaks, width)
        middle = vec3_at(points, 3 * behind.first)
        extent = extent_of(points, 3 * piece.first, 3 * piece.last)
        size = max(
            extent[1][0] - extent[0][0], extent[1][1] - extent[0][1], extent[1][2] - extent[0][2]
        )
        allowance = allowance_of(scale, degree, piece.halvings, margin)
        need = margin + allowance
        first_plane, nearest = len(planes), math.inf
        work.clear()
        for i in range(lowest, highest):
            work.append(candidates[i])
        while len(work) > 0:
            node = work.pop()
            tries += 1
            if _separated_again(planes, first_plane, tree, node, need):
                continue
            if node < nodes:
                low, high = box_of(tree, node)
                direction = _from_box(low, high, extent, middle, need)
                wide = 2 * max(high[0] - low[0], high[1] - low[1], high[2] - low[2]) > size
            else:
                wide = False
                triangle = triangle_at(tree.corners, node - nodes)
                distance, direction = _away_from(middle, closest_point(middle, triangle))
                if distance < margin - allowance:
                    return REFUTED, at, 0, distance, table_of(planes)
                nearest = min(nearest, distance)
            level = least_product(points, piece.first, piece.last, direction)
            if level - _support(direction, tree, node) > need:
                planes.append(SeparatingPlane(piece.start, piece.end, 0, direction, level))
            elif wide:
                _open(tree, node, work)
            else:
                candidates.append(node)
        if len(candidates) == highest:
            continue
        final = size < FINEST * scale or piece.halvings == MOST_HALVINGS
        if tries > most_tries or (not run and (final or not piece.start < at < piece.end)):
            return UNDECIDED, at, 0, nearest, table_of(planes)
        pending.append((behind, highest, len(candidates)))
        pending.append((ahead, highest, len(candidates)))
    return CERTIFIED, 0.0, -1, math.inf, table_of(planes)
