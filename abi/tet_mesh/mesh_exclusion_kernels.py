"""Nodes and edges of a tetrahedral mesh that a triangle mesh excludes.

Distances are those of the triangle mesh's body frame. They change by no more than the way gone:
bounds from the grid around the triangle mesh pass over most nodes and decide most of the others,
and the ends of an edge decide most edges. What is left is tested against the triangles, so that
nothing is excluded, or kept, for want of a finer grid.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable

from abi.arrays import FloatArray, IntArray
from abi.compiled import IDS, compiled
from abi.obstacles.primitive_kernels import in_body
from abi.obstacles.triangle_mesh.closest_point_kernels import nearest_triangle
from abi.obstacles.triangle_mesh.distance_grid_kernels import distance_bounds, steepest
from abi.obstacles.triangle_mesh.segment_kernels import comes_near
from abi.obstacles.triangle_mesh.surface_kernels import (
    NO_PLACEMENT,
    NO_TABLES,
    Placement,
    Room,
    SurfaceTables,
    limit_of,
    new_room,
    to_surface,
)
from abi.obstacles.triangle_mesh.winding_kernels import is_inside
from abi.obstacles.vector_kernels import Vec3, add, axpy, norm, sub
from abi.tet_mesh.adjacency_kernels import (
    BCC,
    INTERIOR_DIRECTIONS,
    NO_ADJACENCY,
    ROWS,
    Adjacency,
    Span,
    across,
    cell,
    half_cells_within,
    node_at,
    row_place,
    y_and_z_origins,
)

_EXCLUDED = -math.inf
_FAR = math.inf

Found = tuple[IntArray, IntArray, IntArray, IntArray]
Window = tuple[Span, Span, Span]


class _Limits(NamedTuple):
    """Distances in the body frame.

    Attributes:
        margin: what is nearer than this is excluded.
        reach: margin and longest edge: nodes farther than this lose no edges.
        touching: limit of a point for the triangles, with room for rounding.
    """

    margin: float
    reach: float
    touching: float


@compiled(example=(NO_ADJACENCY, IDS, NO_TABLES, NO_PLACEMENT, 0.0, 1.0), error_model="numpy")
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
    limits = _Limits(near_point, (margin + longest) / placement.factor, near_point + doubt)
    levels = np.full(adjacency.shape.nodes, _FAR)
    room = new_room()
    if adjacency.shape.kind == ROWS:
        starts, lengths, near = _levels_of_rows(adjacency, tables, placement, limits, levels, room)
        cut_nodes, cut_bits = _edges_of_rows(
            adjacency, tables, placement, limits, levels, near, room
        )
    else:
        starts, lengths, near = _levels_of_lattice(
            adjacency, tables, placement, limits, levels, room
        )
        cut_nodes, cut_bits = _edges_of_lattice(
            adjacency, open_directions, tables, placement, limits, levels, near, room
        )
    return starts, lengths, cut_nodes, cut_bits


@register_jitable
def _level(tables: SurfaceTables, limits: _Limits, x: Vec3, last: Vec3, room: Room) -> float:
    """Lower bound of the signed distance of a node that is not excluded; else ``_EXCLUDED``.

    Args:
        tables: the triangle mesh.
        limits: of the distance.
        x: the node, of which the grid does not tell whether it is excluded.
        last: a place outside, if it is near.
        room: for descents.
    """
    tree = tables.tree
    _, found = nearest_triangle(tree, x, limits.touching, math.inf, room.waiting, room.squares)
    if found >= 0:
        return _EXCLUDED
    if not tables.closed:
        return limits.margin
    # what nothing is between is on the same side
    touching = limit_of(tables, 0.0, 0.0)
    if norm(sub(x, last)) < limits.reach and not comes_near(
        tree, last, x, touching, steepest(tables.grid, x), room.waiting
    ):
        return limits.margin
    if is_inside(tree, tables.dipoles, x, room.stack):
        return _EXCLUDED
    return limits.margin


@register_jitable
def _levels_of_lattice(
    adjacency: Adjacency,
    tables: SurfaceTables,
    placement: Placement,
    limits: _Limits,
    levels: FloatArray,
    room: Room,
) -> tuple[IntArray, IntArray, IntArray]:
    """Runs of excluded nodes of a lattice, and the nodes near to those.

    Line by line along z; bounds of the distance say how many nodes can be passed over.

    Args:
        levels: (n,) lower bounds of the distance of near nodes, and ``_EXCLUDED``; written.

    Returns:
        First nodes and lengths of the runs; the near nodes.
    """
    shape, places = adjacency.shape, adjacency.places
    y0, z0 = y_and_z_origins(shape)
    low, high = _reached(tables, placement, limits)
    kinds = 2 if shape.kind == BCC else 1
    step = (places[z0 + 2] - places[z0]) / placement.factor
    windows = (
        half_cells_within(shape, places, low, high, 0),
        half_cells_within(shape, places, low, high, 1),
    )
    most = _nodes_of(windows[0]) + (_nodes_of(windows[1]) if kinds == 2 else 0)
    starts, lengths = np.empty(most, np.int32), np.empty(most, np.int32)
    near = np.empty(most, np.int32)
    runs, count = 0, 0
    nowhere = (math.inf, math.inf, math.inf)
    for odd in range(kinds):
        (a0, a1), (b0, b1), (c0, c1) = windows[odd]
        for a in range(a0, a1 + 1, 2):
            for b in range(b0, b1 + 1, 2):
                line = node_at(shape, a, b, odd)
                last, end = nowhere, -1
                c = c0
                while c <= c1:
                    x = to_surface(placement, (places[a], places[y0 + b], places[z0 + c]))
                    lower, upper = distance_bounds(tables.grid, x)
                    if lower >= limits.reach:
                        c += 2 * max(int((lower - limits.reach) / step), 0) + 2
                        last = x
                        continue
                    many = 1
                    if upper < limits.margin:
                        lower = _EXCLUDED
                        many = min(int((limits.margin - upper) / step), (c1 - c) >> 1) + 1
                    elif lower < limits.margin:
                        lower = _level(tables, limits, x, last, room)
                    node = line + (c >> 1)
                    if lower == _EXCLUDED:
                        if end != node:
                            starts[runs], lengths[runs] = node, 0
                            runs += 1
                        end = node + many
                        lengths[runs - 1] += many
                        for k in range(node, end):
                            levels[k] = _EXCLUDED
                    else:
                        levels[node] = lower
                        near[count] = node
                        count += 1
                        last = x
                    c += 2 * many
    return starts[:runs].copy(), lengths[:runs].copy(), near[:count]


@register_jitable
def _edges_of_lattice(
    adjacency: Adjacency,
    open_directions: IntArray,
    tables: SurfaceTables,
    placement: Placement,
    limits: _Limits,
    levels: FloatArray,
    near: IntArray,
    room: Room,
) -> tuple[IntArray, IntArray]:
    """Edges between near nodes of a lattice that come too near, at both ends.

    Returns:
        Nodes that lose edges, and the bits of these edges.
    """
    shape, places, steps, offsets = (
        adjacency.shape,
        adjacency.places,
        adjacency.steps,
        adjacency.offsets,
    )
    y0, z0 = y_and_z_origins(shape)
    cross, factor = shape.cross, placement.factor
    edges, sizes = np.empty((shape.directions, 3)), np.empty(shape.directions)
    for k in range(shape.directions):
        along = (
            steps[3 * k] * (places[1] - places[0]) / factor,
            steps[3 * k + 1] * (places[y0 + 1] - places[y0]) / factor,
            steps[3 * k + 2] * (places[z0 + 1] - places[z0]) / factor,
        )
        edges[k, 0], edges[k, 1], edges[k, 2] = in_body(placement.axes, along)
        sizes[k] = norm(along)
    cut_nodes, cut_bits = np.empty(256, np.int32), np.empty(256, np.int32)
    count = 0
    for i in range(len(near)):
        node = near[i]
        bits, here = open_directions[node], levels[node]
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
            there = levels[head]
            # an edge in the way has both ends near
            if math.isinf(there):  # far, or excluded
                continue
            if here + there - sizes[k] >= 2.0 * limits.margin:
                continue
            q = add(p, (edges[k, 0], edges[k, 1], edges[k, 2]))
            if _is_lost(tables, limits.margin, p, q, here, there, sizes[k], room):
                cut_nodes[count], cut_nodes[count + 1] = node, head
                cut_bits[count], cut_bits[count + 1] = 1 << k, 1 << (k if k < cross else k + 1)
                count += 2
    return cut_nodes[:count].copy(), cut_bits[:count].copy()


@register_jitable
def _levels_of_rows(
    adjacency: Adjacency,
    tables: SurfaceTables,
    placement: Placement,
    limits: _Limits,
    levels: FloatArray,
    room: Room,
) -> tuple[IntArray, IntArray, IntArray]:
    """The same as ``_levels_of_lattice`` for a mesh of rows; a run is one node."""
    places, nodes = adjacency.places, adjacency.shape.nodes
    low, high = _reached(tables, placement, limits)
    excluded, near = np.empty(nodes, np.int32), np.empty(nodes, np.int32)
    runs, count = 0, 0
    nowhere = (math.inf, math.inf, math.inf)
    for node in range(nodes):
        x, y, z = place = row_place(places, nodes, node)
        if not (low[0] <= x <= high[0] and low[1] <= y <= high[1] and low[2] <= z <= high[2]):
            continue
        here = to_surface(placement, place)
        lower, upper = distance_bounds(tables.grid, here)
        if lower >= limits.reach:
            continue
        if upper < limits.margin:
            lower = _EXCLUDED
        elif lower < limits.margin:
            lower = _level(tables, limits, here, nowhere, room)
        levels[node] = lower
        if lower == _EXCLUDED:
            excluded[runs] = node
            runs += 1
        else:
            near[count] = node
            count += 1
    return excluded[:runs].copy(), np.ones(runs, np.int32), near[:count]


@register_jitable
def _edges_of_rows(
    adjacency: Adjacency,
    tables: SurfaceTables,
    placement: Placement,
    limits: _Limits,
    levels: FloatArray,
    near: IntArray,
    room: Room,
) -> tuple[IntArray, IntArray]:
    """Places in the rows of all edges that near nodes lose, and 0."""
    places, nodes, indptr, indices = (
        adjacency.places,
        adjacency.shape.nodes,
        adjacency.indptr,
        adjacency.indices,
    )
    gone = np.empty(len(indices), np.int32)
    count = 0
    for i in range(len(near)):
        tail = near[i]
        p = to_surface(placement, row_place(places, nodes, tail))
        for k in range(indptr[tail], indptr[tail + 1]):
            head = indices[k]
            here, there = levels[tail], levels[head]
            if there == _FAR:
                continue
            gone[count] = k
            if there == _EXCLUDED:
                count += 1
                continue
            q = to_surface(placement, row_place(places, nodes, head))
            size = norm(sub(q, p))
            # from the same end both times, for rounding
            if tail < head:
                lost = _is_lost(tables, limits.margin, p, q, here, there, size, room)
            else:
                lost = _is_lost(tables, limits.margin, q, p, there, here, size, room)
            count += 1 if lost else 0
    return gone[:count].copy(), np.zeros(count, np.int32)


@register_jitable
def _is_lost(
    tables: SurfaceTables,
    margin: float,
    p: Vec3,
    q: Vec3,
    at_p: float,
    at_q: float,
    size: float,
    room: Room,
) -> bool:
    """Whether an edge between nodes that are not excluded comes nearer than the margin.

    Between places at a distance l whose signed distances are s and t, or more, the signed distance
    is at least (s + t - l) / 2.
    """
    if at_p + at_q - size >= 2.0 * margin:
        return False
    middle = axpy(0.5, sub(q, p), p)
    lower, upper = distance_bounds(tables.grid, middle)
    if upper < margin:
        return True
    if lower + min(at_p, at_q) - size / 2 >= 2.0 * margin:
        return False
    # both ends are outside, so a segment that nothing touches is outside, too
    limit, normal = limit_of(tables, margin, size), steepest(tables.grid, middle)
    return comes_near(tables.tree, p, q, limit, normal, room.waiting)


@register_jitable
def _reached(tables: SurfaceTables, placement: Placement, limits: _Limits) -> tuple[Vec3, Vec3]:
    """Low and high corner of what is nearer to the surface's box than the reach, [unit], world."""
    inner, outer = tables.grid.box
    (ux, uy, uz), (vx, vy, vz), (wx, wy, wz) = placement.axes
    half = (
        (outer[0] - inner[0]) / 2 * placement.factor,
        (outer[1] - inner[1]) / 2 * placement.factor,
        (outer[2] - inner[2]) / 2 * placement.factor,
    )
    # the box's middle is the origin, but for rounding
    reach = limits.reach * placement.factor * (1.0 + 1e-9)
    x, y, z = placement.origin
    dx = abs(ux) * half[0] + abs(vx) * half[1] + abs(wx) * half[2] + reach
    dy = abs(uy) * half[0] + abs(vy) * half[1] + abs(wy) * half[2] + reach
    dz = abs(uz) * half[0] + abs(vz) * half[1] + abs(wz) * half[2] + reach
    return (x - dx, y - dy, z - dz), (x + dx, y + dy, z + dz)


@register_jitable
def _nodes_of(window: Window) -> int:
    """Number of nodes of a lattice in a window."""
    (a0, a1), (b0, b1), (c0, c1) = window
    lines = max((a1 - a0) // 2 + 1, 0) * max((b1 - b0) // 2 + 1, 0)
    return lines * max((c1 - c0) // 2 + 1, 0)
