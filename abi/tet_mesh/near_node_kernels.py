"""Bounds of the distance from nodes to a triangle mesh near them.

Distances are those of the triangle mesh's body frame. Between two points they differ by no more
than the distance of the points, so bounds from the grid around the triangle mesh skip most nodes
and decide most of the others.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.compilation.jitable import jitable
from abi.obstacles.triangle_mesh.segment_kernels import near_triangle
from abi.obstacles.triangle_mesh.surface_kernels import limit_of
from abi.obstacles.triangle_mesh.surface_tables_kernels import (
    DescentWorkspace,
    Placement,
    SurfaceTables,
    distance_bounds,
    steepest,
    to_surface,
)
from abi.obstacles.triangle_mesh.triangle_kernels import (
    is_inside,
    nearest_triangle,
    point_to_triangle,
)
from abi.obstacles.vector_kernels import Vec3, norm, sub, triangle_at
from abi.tet_mesh.adjacency_kernels import (
    Adjacency,
    Span,
    half_cells_within,
    node_at,
    row_place,
    y_and_z_origins,
)

EXCLUDED = -math.inf
FAR = math.inf

_OVERLAPPING = 2.0 * (1.0 - 1e-9)
"""Distance of places, in margins that both keep, below which nothing is between them."""

Window = tuple[Span, Span, Span]


class PlacedSurface(NamedTuple):
    """A triangle mesh where it is, and what nodes near to it are asked.

    Attributes:
        tables: the triangle mesh.
        placement: where it is.
        margin: what is nearer than this is excluded, body frame.
        reach: margin and longest edge: nodes farther than this lose no edges, body frame.
        touching: limit of a point for the triangles, with room for rounding, body frame.
        room: for descents.
    """

    tables: SurfaceTables
    placement: Placement
    margin: float
    reach: float
    touching: float
    room: DescentWorkspace


@jitable
def _bound(surface: PlacedSurface, x: Vec3, last: Vec3, hint: int) -> tuple[float, int]:
    """Lower bound of the signed distance of a node that is not excluded; else ``EXCLUDED``.

    Args:
        surface: the triangle mesh.
        x: the node, of which the grid does not tell whether it is excluded.
        last: a place that keeps the margin, if it is near.
        hint: a triangle that may be near, or -1.

    Returns:
        The bound, and a triangle that may be near to the next node, or -1.
    """
    tables, _, margin, reach, touching, room = surface
    tree, near = tables.tree, touching * touching
    if hint >= 0 and point_to_triangle(x, triangle_at(tree.corners, hint), near) < near:
        return EXCLUDED, hint
    _, found = nearest_triangle(tree, x, touching, math.inf, room.waiting, room.squares)
    if found >= 0:
        return EXCLUDED, found
    if not tables.closed:
        return margin, hint
    # what nothing is between is on the same side: where balls that nothing is in overlap
    apart = norm(sub(x, last))
    if apart < _OVERLAPPING * margin:
        return margin, hint
    limit = limit_of(tables, 0.0, 0.0)
    if (
        apart < reach
        and near_triangle(tree, last, x, limit, steepest(tables.grid, x), room.waiting) < 0
    ):
        return margin, hint
    if is_inside(tree, tables.dipoles, x, room.stack):
        return EXCLUDED, hint
    return margin, hint


@jitable
def near_nodes_of_lattice(
    adjacency: Adjacency,
    surface: PlacedSurface,
    bounds: FloatArray,
) -> tuple[IntArray, IntArray, IntArray]:
    """Runs of excluded nodes of a lattice, and the nodes near to those.

    Line by line along z; bounds of the distance say how many nodes can be passed over.

    Args:
        adjacency: the lattice.
        surface: the triangle mesh.
        bounds: (n,) lower bounds of the signed distance of near nodes, and ``EXCLUDED``; written.

    Returns:
        First nodes and lengths of the runs; the near nodes.
    """
    shape, places = adjacency.shape, adjacency.places
    tables, placement, margin, reach, _, _ = surface
    y0, z0 = y_and_z_origins(shape)
    low, high = _reached(surface)
    kinds = 2 if shape.cross else 1
    step = (places[z0 + 2] - places[z0]) / placement.factor
    windows = (
        half_cells_within(shape, places, low, high, 0),
        half_cells_within(shape, places, low, high, 1),
    )
    most = _nodes_of(windows[0]) + (_nodes_of(windows[1]) if kinds == 2 else 0)
    starts, lengths = np.empty(most, np.int32), np.empty(most, np.int32)
    near = np.empty(most, np.int32)
    runs, count, hint = 0, 0, -1
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
                    if lower >= reach:
                        c += 2 * max(int((lower - reach) / step), 0) + 2
                        last = x
                        continue
                    many = 1
                    if upper < margin:
                        lower = EXCLUDED
                        many = min(int((margin - upper) / step), (c1 - c) >> 1) + 1
                    elif lower < margin:
                        lower, hint = _bound(surface, x, last, hint)
                    node = line + (c >> 1)
                    if lower == EXCLUDED:
                        if end != node:
                            starts[runs], lengths[runs] = node, 0
                            runs += 1
                        end = node + many
                        lengths[runs - 1] += many
                        for k in range(node, end):
                            bounds[k] = EXCLUDED
                    else:
                        bounds[node] = lower
                        near[count] = node
                        count += 1
                        last = x
                    c += 2 * many
    return starts[:runs].copy(), lengths[:runs].copy(), near[:count]


@jitable
def near_nodes_of_rows(
    adjacency: Adjacency,
    surface: PlacedSurface,
    bounds: FloatArray,
) -> tuple[IntArray, IntArray, IntArray]:
    """Nodes of a mesh of rows that a surface excludes or is near to; a run is one node."""
    places, nodes = adjacency.places, adjacency.shape.nodes
    tables, placement, margin, reach, _, _ = surface
    low, high = _reached(surface)
    excluded, near = np.empty(nodes, np.int32), np.empty(nodes, np.int32)
    runs, count, hint = 0, 0, -1
    nowhere = (math.inf, math.inf, math.inf)
    for node in range(nodes):
        x, y, z = place = row_place(places, nodes, node)
        if not (low[0] <= x <= high[0] and low[1] <= y <= high[1] and low[2] <= z <= high[2]):
            continue
        here = to_surface(placement, place)
        lower, upper = distance_bounds(tables.grid, here)
        if lower >= reach:
            continue
        if upper < margin:
            lower = EXCLUDED
        elif lower < margin:
            lower, hint = _bound(surface, here, nowhere, hint)
        bounds[node] = lower
        if lower == EXCLUDED:
            excluded[runs] = node
            runs += 1
        else:
            near[count] = node
            count += 1
    return excluded[:runs].copy(), np.ones(runs, np.int32), near[:count]


@jitable
def _reached(surface: PlacedSurface) -> tuple[Vec3, Vec3]:
    """Low and high corner of what is nearer to the surface's box than the reach, [unit], world."""
    tables, placement, _, reach, _, _ = surface
    inner, outer = tables.grid.box
    (ux, uy, uz), (vx, vy, vz), (wx, wy, wz) = placement.axes
    half = (
        (outer[0] - inner[0]) / 2 * placement.factor,
        (outer[1] - inner[1]) / 2 * placement.factor,
        (outer[2] - inner[2]) / 2 * placement.factor,
    )
    # the box's middle is the origin, but for rounding
    reach = reach * placement.factor * (1.0 + 1e-9)
    x, y, z = placement.origin
    dx = abs(ux) * half[0] + abs(vx) * half[1] + abs(wx) * half[2] + reach
    dy = abs(uy) * half[0] + abs(vy) * half[1] + abs(wy) * half[2] + reach
    dz = abs(uz) * half[0] + abs(vz) * half[1] + abs(wz) * half[2] + reach
    return (x - dx, y - dy, z - dz), (x + dx, y + dy, z + dz)


@jitable
def _nodes_of(window: Window) -> int:
    """Number of nodes of a lattice in a window."""
    (a0, a1), (b0, b1), (c0, c1) = window
    lines = max((a1 - a0) // 2 + 1, 0) * max((b1 - b0) // 2 + 1, 0)
    return lines * max((c1 - c0) // 2 + 1, 0)
