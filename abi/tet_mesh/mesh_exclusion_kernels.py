"""Nodes and edges of a tetrahedral mesh that a triangle mesh excludes.

The distances of the nodes decide most cases (:mod:`abi.tet_mesh.near_node_kernels`), and the ends
of an edge most others. The rest is tested against the triangles, so that nothing is wrongly
excluded or kept because the grid is coarse.
"""

from __future__ import annotations

import math

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.compilation.borrowed import borrowed, held
from abi.compilation.jitable import jitable
from abi.compiled import IDS, compiled
from abi.obstacles.primitive_kernels import in_body
from abi.obstacles.triangle_mesh.gather_kernels import comes_near_gathered, gather, no_triangles
from abi.obstacles.triangle_mesh.segment_kernels import near_triangle
from abi.obstacles.triangle_mesh.surface_kernels import limit_of
from abi.obstacles.triangle_mesh.surface_tables_kernels import (
    NO_PLACEMENT,
    NO_TABLES,
    Placement,
    SurfaceTables,
    distance_bounds,
    new_room,
    steepest,
    to_surface,
)
from abi.obstacles.triangle_mesh.triangle_kernels import segment_to_triangle
from abi.obstacles.vector_kernels import Vec3, add, axpy, norm, sub, triangle_at
from abi.tet_mesh.adjacency_kernels import (
    CSR,
    INTERIOR_DIRECTIONS,
    NO_ADJACENCY,
    Adjacency,
    MeshSizes,
    across,
    cell,
    row_place,
    y_and_z_origins,
)
from abi.tet_mesh.lattice_exclusion_kernels import Found
from abi.tet_mesh.near_node_kernels import (
    EXCLUDED,
    FAR,
    PlacedSurface,
    near_nodes_of_lattice,
    near_nodes_of_rows,
)

_STRETCH = 12
"""Nodes along a line, for whose edges triangles are gathered together."""

_LONGEST_PAUSE = 15
"""Stretches, at most, for which none are gathered after there were too many."""

_OPEN, _TOO_MANY = -2, -1
_ROUNDING = 4.0  # room for that of a plane that is kept


@compiled(example=(NO_ADJACENCY, IDS, NO_TABLES, NO_PLACEMENT, 0.0, 1.0))
def exclusion_near_mesh(
    adjacency: Adjacency,
    open_directions: IntArray,
    tables: SurfaceTables,
    placement: Placement,
    margin: float,
    longest: float,
) -> Found:
    """The nodes nearer to a triangle mesh than ``margin``, and the edges of other nodes that are.

    Args:
        adjacency: the tetrahedral mesh.
        open_directions: (n,) directions that exist.
        tables: the triangle mesh.
        placement: where it is.
        margin: [unit].
        longest: the longest edge, [unit].

    Returns:
        As ``abi.tet_mesh.exclusion_kernels.exclusion`` does.
    """
    near_point = margin / placement.factor
    doubt = tables.error[0] + tables.error[1] * near_point
    reach, touching = (margin + longest) / placement.factor, near_point + doubt
    own, bounds = new_room(), np.full(adjacency.shape.nodes, FAR)
    surface = PlacedSurface(tables, placement, near_point, reach, touching, borrowed(own))
    if adjacency.shape.kind == CSR:
        starts, lengths, near = near_nodes_of_rows(adjacency, surface, bounds)
        cut_nodes, cut_bits = _edges_of_rows(adjacency, surface, bounds, near)
    else:
        starts, lengths, near = near_nodes_of_lattice(adjacency, surface, bounds)
        cut_nodes, cut_bits = _edges_of_lattice(adjacency, open_directions, surface, bounds, near)
    held(own)
    return starts, lengths, cut_nodes, cut_bits


@jitable
def _directions_of(adjacency: Adjacency, placement: Placement) -> tuple[FloatArray, FloatArray]:
    """Edges (d, 3) of a lattice's cell in a surface's frame, and their lengths (d,)."""
    shape, places, steps = adjacency.shape, adjacency.places, adjacency.steps
    y0, z0 = y_and_z_origins(shape)
    factor = placement.factor
    edges, sizes = np.empty((shape.directions, 3)), np.empty(shape.directions)
    for k in range(shape.directions):
        along = (
            steps[3 * k] * (places[1] - places[0]) / factor,
            steps[3 * k + 1] * (places[y0 + 1] - places[y0]) / factor,
            steps[3 * k + 2] * (places[z0 + 1] - places[z0]) / factor,
        )
        edges[k, 0], edges[k, 1], edges[k, 2] = in_body(placement.axes, along)
        sizes[k] = norm(along)
    return edges, sizes


@jitable
def _edges_of_lattice(
    adjacency: Adjacency,
    open_directions: IntArray,
    surface: PlacedSurface,
    bounds: FloatArray,
    near: IntArray,
) -> tuple[IntArray, IntArray]:
    """Edges between near nodes of a lattice that come too near, at both ends.

    Returns:
        Nodes that lose edges, and the bits of these edges.
    """
    shape, places, offsets = adjacency.shape, adjacency.places, adjacency.offsets
    placement = surface.placement
    y0, z0 = y_and_z_origins(shape)
    cross = shape.cross
    edges, sizes = _directions_of(adjacency, placement)
    cut_nodes, cut_bits = np.empty(256, np.int32), np.empty(256, np.int32)
    tables, _, _, _, _, room = surface
    tree, own = tables.tree, no_triangles()
    gathered = borrowed(own)
    longest = (surface.reach - surface.margin) * (1.0 + 1e-9)
    around = longest + limit_of(tables, surface.margin, longest)
    doubt = _ROUNDING * (tables.error[0] + tables.error[1] * around)
    count, hint, until, triangles = 0, -1, 0, _OPEN
    skip, pause = 0, 0
    for i in range(len(near)):
        node = near[i]
        if i == until:
            until, triangles = _end_of_stretch(shape, near, i), _OPEN if skip == 0 else _TOO_MANY
            skip = max(skip - 1, 0)
        bits, here = open_directions[node], bounds[node]
        a, b, c = cell(shape, node)
        p = to_surface(placement, (places[a], places[y0 + b], places[z0 + c]))
        other = across(shape, a, b, c)
        if count + 2 * shape.directions > len(cut_nodes):
            cut_nodes = np.concatenate((cut_nodes, np.empty_like(cut_nodes)))
            cut_bits = np.concatenate((cut_bits, np.empty_like(cut_bits)))
        # each edge once, from the end that comes first
        for k in range(
            cross if c & 1 == 1 else 0,
            shape.directions if bits >> INTERIOR_DIRECTIONS else INTERIOR_DIRECTIONS,
        ):
            if (bits >> k) & 1 == 0 or (k >= cross and (k & 1) == 1):
                continue
            head = (other if k < cross else node) + offsets[(c & 1) * shape.directions + k]
            there = bounds[head]
            # an edge in the way has both ends near
            if math.isinf(there):  # far, or excluded
                continue
            if here + there - sizes[k] >= 2.0 * surface.margin:
                continue
            q = add(p, (edges[k, 0], edges[k, 1], edges[k, 2]))
            if triangles == _OPEN:
                last = cell(shape, near[until - 1])
                end = (places[last[0]], places[y0 + last[1]], places[z0 + last[2]])
                end = to_surface(placement, end)
                triangles = gather(tree, (p, end), around, doubt, gathered, room.waiting)
                pause = 0 if triangles >= 0 else min(2 * pause + 1, _LONGEST_PAUSE)
                skip = pause
            if triangles >= 0:
                limit = limit_of(tables, surface.margin, sizes[k])
                lost = comes_near_gathered(tree, gathered, triangles, (p, q), limit, doubt)
            else:
                lost, hint = _is_lost(surface, p, q, (here, there), sizes[k], hint)
            if lost:
                cut_nodes[count], cut_nodes[count + 1] = node, head
                cut_bits[count], cut_bits[count + 1] = 1 << k, 1 << (k if k < cross else k + 1)
                count += 2
    held(own)
    return cut_nodes[:count].copy(), cut_bits[:count].copy()


@jitable
def _end_of_stretch(shape: MeshSizes, near: IntArray, first: int) -> int:
    """End in ``near`` of the stretch of near nodes that begins at a place and is in one line."""
    a, b, _ = cell(shape, near[first])
    end = first + 1
    while end < len(near) and near[end] - near[first] < _STRETCH:
        i, j, _ = cell(shape, near[end])
        if (i, j) != (a, b):
            break
        end += 1
    return end


@jitable
def _edges_of_rows(
    adjacency: Adjacency,
    surface: PlacedSurface,
    bounds: FloatArray,
    near: IntArray,
) -> tuple[IntArray, IntArray]:
    """Places in the rows of all edges that near nodes lose, and 0."""
    places, nodes, indptr, indices = (
        adjacency.places,
        adjacency.shape.nodes,
        adjacency.indptr,
        adjacency.indices,
    )
    placement, margin = surface.placement, surface.margin
    gone = np.empty(len(indices), np.int32)
    count = 0
    for i in range(len(near)):
        tail = near[i]
        p = to_surface(placement, row_place(places, nodes, tail))
        for k in range(indptr[tail], indptr[tail + 1]):
            head = indices[k]
            here, there = bounds[tail], bounds[head]
            if there == FAR:
                continue
            gone[count] = k
            if there == EXCLUDED:
                count += 1
                continue
            q = to_surface(placement, row_place(places, nodes, head))
            size = norm(sub(q, p))
            if here + there - size >= 2.0 * margin:
                continue
            # from the same end both times, for rounding
            if tail < head:
                lost, _ = _is_lost(surface, p, q, (here, there), size, -1)
            else:
                lost, _ = _is_lost(surface, q, p, (there, here), size, -1)
            count += 1 if lost else 0
    return gone[:count].copy(), np.zeros(count, np.int32)


@jitable
def _is_lost(
    surface: PlacedSurface,
    p: Vec3,
    q: Vec3,
    bounds: tuple[float, float],
    size: float,
    hint: int,
) -> tuple[bool, int]:
    """Check whether an edge that the bounds at its ends do not clear comes nearer than the margin.

    Between places at a distance l whose signed distances are s and t, or more, the signed distance
    is at least (s + t - l) / 2.

    Args:
        surface: the triangle mesh.
        p, q: the ends, body frame.
        bounds: of the signed distances there.
        size: length of the edge.
        hint: a triangle that may be near, or -1.

    Returns:
        Whether it does, and a triangle that may be near to the next edge, or -1.
    """
    tables, _, margin, _, _, room = surface
    tree, (at_p, at_q) = tables.tree, bounds
    middle = axpy(0.5, sub(q, p), p)
    lower, upper = distance_bounds(tables.grid, middle)
    if upper < margin:
        return True, hint
    if lower + min(at_p, at_q) - size / 2 >= 2.0 * margin:
        return False, hint
    # both ends are outside, so a segment that nothing touches is outside, too
    limit = limit_of(tables, margin, size)
    if hint >= 0 and segment_to_triangle(p, q, triangle_at(tree.corners, hint)) <= limit * limit:
        return True, hint
    found = near_triangle(tree, p, q, limit, steepest(tables.grid, middle), room.waiting)
    return found >= 0, found if found >= 0 else hint
