"""Distances to surfaces that are placed in the world, and segments that come too near to them.

What is asked of all triangle meshes of a scene leaves out those that are far, by a tree over their
bounding boxes (``primitive_tree_kernels``).
"""

from __future__ import annotations

import math
from inspect import unwrap
from typing import NamedTuple

from abi.arrays import FloatArray, IntArray
from abi.compilation.jitable import called_as, jitable
from abi.compilation.plain import kept_lists
from abi.compiled import FLOATS, IDS, NEW_FLOATS, compiled
from abi.obstacles.primitive_kernels import in_world
from abi.obstacles.primitive_tree_kernels import next_near, next_near_segment
from abi.obstacles.triangle_mesh.bvh import Dipoles, TriangleTree
from abi.obstacles.triangle_mesh.segment_kernels import near_triangle
from abi.obstacles.triangle_mesh.surface_distance_kernels import (
    gradient_of,
    is_inside_near,
    least_distance,
    signed_distance_at,
)
from abi.obstacles.triangle_mesh.surface_tables_kernels import (
    NO_PLACEMENT,
    NO_TABLES,
    TOUCHING,
    DescentWorkspace,
    DistanceGrid,
    Placement,
    SurfaceTables,
    distance_bounds,
    new_room,
    steepest,
    to_surface,
)
from abi.obstacles.triangle_mesh.triangle_kernels import segment_to_triangle
from abi.obstacles.vector_kernels import Vec3, axpy, distance, sub, triangle_at, vec3_at

_PARALLEL = 1e-8
"""Part of a segment's length: error of its distance to a nearly parallel edge."""


@jitable
def limit_of(tables: SurfaceTables, margin: float, length: float) -> float:
    """Distance at which a segment of some length counts as nearer than a margin, by rounding."""
    return max(margin, TOUCHING * tables.extent) + _PARALLEL * length


@jitable
def is_blocked(
    tables: SurfaceTables, p: Vec3, q: Vec3, margin: float, room: DescentWorkspace
) -> bool:
    """Check if a segment of the body frame comes nearer to a surface than a margin, or touches it.

    Walks along the segment as far as the grid's bounds allow at each place (Hart, Sphere tracing,
    1996). The stretch in which they allow less than half a step of the grid is tested against the
    triangles.
    """
    tree, _, grid, closed, _, _ = tables
    length = distance(p, q)
    limit = limit_of(tables, margin, length)
    # it may be of another surface, but is a triangle of this one all the same
    latest = room.latest[0]
    if 0 <= latest < len(tree.corners) // 9:
        triangle = triangle_at(tree.corners, latest)
        if segment_to_triangle(p, q, triangle) <= limit * limit:
            return True
    d = sub(q, p)
    inverse = 1.0 / length if length > 0.0 else 0.0
    at, outside = 0.0, not closed
    first, last, nearest, there = length, -1.0, math.inf, 0.0
    while at <= length:
        lower, upper = distance_bounds(grid, axpy(at * inverse, d, p))
        if upper < margin:
            return True
        outside = outside or lower > 0.0
        far = lower - limit
        if far < grid.step / 2:
            if lower < nearest:
                nearest, there = lower, at
            far = min(grid.step, length - at)
            first, last = min(first, at), at + far
        if at + far >= length:
            break
        at += far
    if last >= 0.0:
        normal = steepest(grid, axpy(there * inverse, d, p))
        x, y = axpy(first * inverse, d, p), axpy(last * inverse, d, p)
        found = near_triangle(tree, x, y, limit, normal, room.waiting)
        if found >= 0:
            room.latest[0] = found
            return True
    # a segment that nothing touches is inside or outside as a whole
    return not outside and is_inside_near(tables, p, room)


DISTANCES, GRADIENTS, LEAST, BLOCKED, BOUNDS = range(5)
"""What may be asked of a surface, see :func:`measure`."""


@compiled(
    example=(NO_TABLES, NO_PLACEMENT, 0, (FLOATS, FLOATS), NEW_FLOATS, NEW_FLOATS, new_room())
)
def measure(
    tables: SurfaceTables,
    placement: Placement,
    question: int,
    segments: tuple[FloatArray, FloatArray],
    found: FloatArray,
    more: FloatArray,
    room: DescentWorkspace,
) -> None:
    """Answer a question about points, or about segments, near a surface.

    One kernel answers all of them: they share most of what is compiled.

    Args:
        tables: the surface.
        placement: where it is.
        question: ``DISTANCES`` for signed distances; ``GRADIENTS`` for their gradients, too;
            ``LEAST`` for the least signed distances along segments; ``BLOCKED`` for whether
            segments come nearer than margins; ``BOUNDS`` for bounds of signed distances.
        segments: both ends, flat (3 n,) each, [unit], world; of points the first.
        found: (n,), [unit]; written. Lower bounds for ``BOUNDS``; for ``LEAST`` written where less;
            for ``BLOCKED`` the margins at first, then 1 or 0.
        more: written. Gradients (3 n,), world, for ``GRADIENTS``; upper bounds (n,) for ``BOUNDS``.
        room: for descents.
    """
    starts, ends = segments
    factor = placement.factor
    for i in range(len(found)):
        p = to_surface(placement, vec3_at(starts, 3 * i))
        if question == BOUNDS:
            least, most = distance_bounds(tables.grid, p)
            found[i], more[i] = least * factor, most * factor
        elif question == LEAST:
            limit = found[i] / factor
            away = least_distance(
                tables, p, to_surface(placement, vec3_at(ends, 3 * i)), limit, room
            )
            if away < limit:
                found[i] = away * factor
        elif question == BLOCKED:
            q = to_surface(placement, vec3_at(ends, 3 * i))
            found[i] = 1.0 if is_blocked(tables, p, q, found[i] / factor, room) else 0.0
        else:
            away, number = signed_distance_at(tables, p, room)
            found[i] = away * factor
            if question == GRADIENTS:
                gradient = in_world(placement.axes, gradient_of(tables, p, away, number))
                more[3 * i], more[3 * i + 1], more[3 * i + 2] = gradient


WIDER = 1e-9
"""Distance, [unit] and part, by which meshes are looked for farther: rounding leaves none out."""


_IDS, _NUMBERS, _POSE = 12, 15, 13


class SurfaceSet(NamedTuple):
    """All surfaces of a scene and their poses, as flat arrays.

    Attributes:
        boxes, leaves, corners, slabs: of the trees, see ``TriangleTree``.
        centres, radii, normals, areas: of their far fields, see ``Dipoles``.
        values: of the grids, see ``DistanceGrid``.
        own_leaves, own_corners: of the layers' trees, where there is more than one layer.
        layers: see ``Dipoles``.
        begins: (s ``_IDS``,) of each surface where its nodes, leaves, triangles, values, own leaves
            and triangles, layers and nodes of these begin; the counts of its grid, and whether it
            is closed. One row more ends the last surface.
        numbers: (s ``_NUMBERS``,) the other fields of its tables, one after the other.
        whose: (m,) surface of each mesh.
        poses: (m ``_POSE``,) origin, axes and factor of its placement.
        bounds: (m ``WIDTH``,) the meshes' bounding boxes as rows of a tree, see
            ``primitive_tree_kernels``.
    """

    boxes: FloatArray
    leaves: IntArray
    corners: FloatArray
    slabs: FloatArray
    centres: FloatArray
    radii: FloatArray
    normals: FloatArray
    areas: FloatArray
    values: FloatArray
    own_leaves: IntArray
    own_corners: FloatArray
    layers: IntArray
    begins: IntArray
    numbers: FloatArray
    whose: IntArray
    poses: FloatArray
    bounds: FloatArray

    def plain(self) -> SurfaceSet:
        """The set with what is of each mesh as lists; :func:`tables_at` has those of a surface."""
        begins, numbers, whose, poses, bounds = (array.tolist() for array in self[12:])
        return self._replace(
            begins=begins, numbers=numbers, whose=whose, poses=poses, bounds=bounds
        )


NO_SURFACES = SurfaceSet(
    *(FLOATS, IDS, *7 * (FLOATS,), IDS, FLOATS, IDS),
    *(IDS, FLOATS, IDS[:0], FLOATS, FLOATS[:0]),
)
"""The empty set: for scenes without meshes, and as an example to compile with."""


def _kept_tables(surfaces: SurfaceSet, number: int) -> SurfaceTables:
    tables: SurfaceTables = unwrap(tables_at)(surfaces, number)
    return kept_lists(surfaces.values, number, tables)


@jitable
@called_as(_kept_tables)
def tables_at(surfaces: SurfaceSet, number: int) -> SurfaceTables:
    """One surface of the set; as Python, of lists that are kept as long as the set's arrays."""
    boxes, leaves, corners, slabs, centres, radii, normals, areas, values = surfaces[:9]
    begins, numbers = surfaces.begins, surfaces.numbers
    k = _IDS * number
    a, b, c, d = begins[k], begins[k + 1], begins[k + 2], begins[k + 3]
    e, f = begins[k + _IDS], begins[k + _IDS + 1]
    g, h = begins[k + _IDS + 2], begins[k + _IDS + 3]
    s, t, u, v = begins[k + 4], begins[k + 5], begins[k + 6], begins[k + 7]
    w, x = begins[k + _IDS + 4], begins[k + _IDS + 5]
    y, z = begins[k + _IDS + 6], begins[k + _IDS + 7]
    n = _NUMBERS * number
    tree = TriangleTree(
        *(boxes[6 * a : 6 * e], leaves[b:f], corners[9 * c : 9 * g], slabs[5 * a : 5 * e]),
        numbers[n],
    )
    own_leaves, own_corners = tree.leaves, tree.corners
    if s < w:
        own_leaves, own_corners = surfaces.own_leaves[s:w], surfaces.own_corners[9 * t : 9 * x]
    far_field = Dipoles(
        *(centres[3 * v : 3 * z], radii[v:z], normals[3 * v : 3 * z], areas[v:z]),
        *(own_leaves, own_corners, surfaces.layers[u:y]),
    )
    counts = (int(begins[k + 8]), int(begins[k + 9]), int(begins[k + 10]))
    box = (vec3_at(numbers, n + 5), vec3_at(numbers, n + 8))
    grid = DistanceGrid(
        values[d:h], counts, vec3_at(numbers, n + 1), numbers[n + 4], box, numbers[n + 11]
    )
    error = (numbers[n + 13], numbers[n + 14])
    closed = begins[k + 11] == 1
    return SurfaceTables(tree, far_field, grid, closed, numbers[n + 12], error)


@jitable
def surface_at(surfaces: SurfaceSet, mesh: int) -> tuple[SurfaceTables, Placement]:
    """One mesh of the set, and its pose."""
    poses, p = surfaces.poses, _POSE * mesh
    axes = (vec3_at(poses, p + 3), vec3_at(poses, p + 6), vec3_at(poses, p + 9))
    placement = Placement(vec3_at(poses, p), axes, poses[p + 12])
    return tables_at(surfaces, surfaces.whose[mesh]), placement


@jitable
def widened(limit: float) -> float:
    """Distance to a mesh's bounding box up to which the mesh may be nearer than a limit, [unit]."""
    return limit + WIDER * (1.0 + abs(limit))


@jitable
def nearest_mesh(
    surfaces: SurfaceSet, enough: float, sought: float, x: Vec3, room: DescentWorkspace
) -> tuple[float, int, int, float]:
    """Least signed distance of a point, whose it is, the triangle, and a lower bound of it.

    Args:
        surfaces: the meshes.
        enough: where it is not below, [unit], it may be left out: then it is inf and the others -1.
        sought: the bound need not be above this, [unit].
        x: a point, [unit], world.
        room: for descents.
    """
    bounds = surfaces.bounds
    best, whose, triangle, least = math.inf, -1, -1, sought
    s = next_near(bounds, -1, widened(least), x, x)
    while s >= 0:
        tables, placement = surface_at(surfaces, s)
        p = to_surface(placement, x)
        lower = distance_bounds(tables.grid, p)[0] * placement.factor
        if lower < min(enough, least):
            away, number = signed_distance_at(tables, p, room)
            lower = away * placement.factor
            if lower < best:
                best, whose, triangle = lower, s, number
        least = min(least, lower)
        s = next_near(bounds, s, widened(least), x, x)
    return best, whose, triangle, least


@jitable
def most_to_mesh(surfaces: SurfaceSet, most: float, x: Vec3) -> float:
    """Upper bound of a point's signed distance to the nearest mesh; ``most`` if that is less."""
    bounds = surfaces.bounds
    s = next_near(bounds, -1, most, x, x)
    while s >= 0:
        tables, placement = surface_at(surfaces, s)
        upper = distance_bounds(tables.grid, to_surface(placement, x))[1]
        most = min(most, upper * placement.factor)
        s = next_near(bounds, s, most, x, x)
    return most


@jitable
def nearest_mesh_to_segment(
    surfaces: SurfaceSet, enough: float, a: Vec3, b: Vec3, room: DescentWorkspace
) -> tuple[float, int]:
    """Least signed distance of a segment and whose it is; ``enough`` and -1 if it is not below.

    Args:
        surfaces: the meshes.
        enough: [unit].
        a: one end, [unit], world; it may be the other one, too.
        b: the other end.
        room: for descents.
    """
    bounds = surfaces.bounds
    best, whose = enough, -1
    half = distance(a, b) / 2
    # how deep a segment is inside is a bound from below: each that may be inside counts
    wide = widened(max(best, 0.0))
    s = next_near_segment(bounds, -1, wide, a, b)
    while s >= 0:
        tables, placement = surface_at(surfaces, s)
        p, q = to_surface(placement, a), to_surface(placement, b)
        lower = distance_bounds(tables.grid, axpy(0.5, sub(q, p), p))[0]
        if lower * placement.factor - half < wide:
            # in the surface's lengths: back in the world's, rounding would make it nearer
            limit = best / placement.factor
            away = least_distance(tables, p, q, limit, room)
            if away < limit:
                best, whose = away * placement.factor, s
                wide = widened(max(best, 0.0))
        s = next_near_segment(bounds, s, wide, a, b)
    return best, whose


@jitable
def meshes_met(
    surfaces: SurfaceSet, margin: float, a: Vec3, b: Vec3, most: int, room: DescentWorkspace
) -> tuple[int, int]:
    """Number of meshes that the segment a..b, world, meets, up to ``most``; the last one, or -1.

    It meets those that it comes nearer to than ``margin``, and those that it touches.
    """
    bounds, met, whose = surfaces.bounds, 0, -1
    wide = widened(max(margin, 0.0))
    s = next_near_segment(bounds, -1, wide, a, b)
    while s >= 0 and met < most:
        tables, placement = surface_at(surfaces, s)
        p, q = to_surface(placement, a), to_surface(placement, b)
        if is_blocked(tables, p, q, margin / placement.factor, room):
            met, whose = met + 1, s
        s = next_near_segment(bounds, s, wide, a, b)
    return met, whose
