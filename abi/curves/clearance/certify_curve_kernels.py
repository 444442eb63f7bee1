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
    REFUTED,
    TINY,
    UNDECIDED,
    Attempt,
    CurvePoints,
    HalvingLimits,
    Outcome,
    Piece,
    ProofLists,
    SeparatingPlane,
    allowance_of,
    apart_along_axis,
    extent_of,
    halves_of_curve,
    least_product,
    new_lists,
    separate_pieces,
    table_of,
    whole_curve,
)
from abi.obstacles.primitive_kernels import (
    WIDTH,
    Axes,
    Core,
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


_BeforePrimitive = tuple[CurvePoints, int, Axes, Core, float, float]
"""A curve in a primitive's body frame, the primitive's number, axes and core, the largest
coordinate of both, and the margin, [unit]."""


@jitable(forceinline=True)
def _before_primitive(
    problem: _BeforePrimitive,
    piece: Piece,
    behind: Piece,
    known: tuple[int, int],
    lists: ProofLists,
) -> Attempt:
    """Try one direction, away from the primitive at a point in the middle of a piece, or an axis.

    The size of what is left is its extent.
    """
    (points, _, width), s, axes, core, scale, margin = problem
    middle = vec3_at(points, 3 * behind.first)
    distance, direction = signed_distance_gradient(core, middle)
    allowance = allowance_of(scale, width - 1, piece.halvings, margin)
    if distance < margin - allowance:
        return Attempt(REFUTED, s, distance, 0, math.inf)
    need = margin + allowance
    level = least_product(points, piece.first, piece.last, direction)
    separated = level - support(core, direction) > need
    size = math.inf
    if not separated:
        low, high = extent_of(points, 3 * piece.first, 3 * piece.last)
        size = max(high[0] - low[0], high[1] - low[1], high[2] - low[2])
        inner, outer = (-core.x, -core.y, -core.z), (core.x, core.y, core.z)
        gap, direction = apart_along_axis(inner, outer, (low, high))
        level = gap - core.radius
        separated = level > need
    if separated:
        normal = in_world(axes, direction)
        lists.planes.append(SeparatingPlane(piece.start, piece.end, s, normal, level))
        return Attempt(UNDECIDED, -1, distance, 0, size)
    return Attempt(UNDECIDED, s, distance, 1, size)


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
    """Separate every piece of a curve from every primitive, one after the other.

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
    lists = new_lists()
    finest = 0.0
    for s in range(count):
        finest = max(finest, FINEST * _scale_of(primitives, s, size))
    limits = HalvingLimits(width, finest, most_tries, math.inf, False, False)
    curve, whole = whole_curve(points, breaks, width)
    for s in range(count):
        axes, centre = axes_of(primitives, s), centre_of(primitives, s)
        for i in range(0, 3 * spans * width, 3):
            points[i], points[i + 1], points[i + 2] = in_body(axes, sub(vec3_at(world, i), centre))
        core, scale = core_of(primitives, s), _scale_of(primitives, s, size)
        problem = curve, s, axes, core, scale, margin
        outcome, at, _, distance = separate_pieces(
            problem, whole, halves_of_curve, _before_primitive, limits, lists
        )
        if outcome != CERTIFIED:
            return outcome, at, s, distance, table_of(lists.planes)
    return CERTIFIED, 0.0, -1, math.inf, table_of(lists.planes)


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


_BeforeSurface = tuple[CurvePoints, TriangleTree, float, float]
"""A curve in a surface's coordinates, the tree over its triangles, the largest coordinate of both,
and the margin, [unit]."""


@jitable(forceinline=True)
def _before_surface(
    problem: _BeforeSurface,
    piece: Piece,
    behind: Piece,
    known: tuple[int, int],
    lists: ProofLists,
) -> Attempt:
    """Separate a piece from nodes of the tree; those larger than the piece are opened.

    The size of what is left is the piece's extent.
    """
    (points, _, width), tree, scale, margin = problem
    planes, candidates, work = lists.planes, lists.candidates, lists.work
    middle = vec3_at(points, 3 * behind.first)
    extent = extent_of(points, 3 * piece.first, 3 * piece.last)
    size = max(
        extent[1][0] - extent[0][0], extent[1][1] - extent[0][1], extent[1][2] - extent[0][2]
    )
    allowance = allowance_of(scale, width - 1, piece.halvings, margin)
    need = margin + allowance
    first_plane, left, nearest, tries = len(planes), -1, math.inf, 0
    nodes = 2 * len(tree.leaves) - 3
    work.clear()
    for i in range(known[0], known[1]):
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
                return Attempt(REFUTED, node, distance, tries, size)
            nearest = min(nearest, distance)
        level = least_product(points, piece.first, piece.last, direction)
        # not as if and else, whose common end LLVM would join: planes would be counted in and out
        if level - _support(direction, tree, node) > need:
            planes.append(SeparatingPlane(piece.start, piece.end, 0, direction, level))
            continue
        if wide:
            _open(tree, node, work)
            continue
        candidates.append(node)
        left = node
    return Attempt(UNDECIDED, left, nearest, tries, size)


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
    were not separated from; it is halved when nodes smaller than it, or triangles, are left.

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
    lists = new_lists()
    lists.candidates.append(0)  # the root of the tree
    curve, whole = whole_curve(points, breaks, degree + 1)
    limits = HalvingLimits(degree + 1, FINEST * scale, most_tries, math.inf, False, False)
    problem = curve, tree, scale, margin
    outcome, at, _, distance = separate_pieces(
        problem, whole, halves_of_curve, _before_surface, limits, lists
    )
    number = 0 if outcome != CERTIFIED else -1
    return outcome, at, number, distance, table_of(lists.planes)
