"""Nodes and edges of a lattice that one primitive excludes, searched in the window around it.

Above the faces of a box only the distance to one face counts. There positions p and steps r are in
the body's axes; cores are those of ``primitive_kernels``, except a cylinder's. The core of a
capsule or a sphere has no thickness, so nothing lies above its sides.
"""

from __future__ import annotations

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.compilation.jitable import jitable
from abi.obstacles.primitive_kernels import (
    Axes,
    Core,
    axes_of,
    centre_of,
    core_of,
    in_body,
    segment_within,
    signed_distance,
    signed_distance_gradient,
)
from abi.obstacles.vector_kernels import Vec3, dot, sub
from abi.tet_mesh.adjacency_kernels import (
    INTERIOR_DIRECTIONS,
    Adjacency,
    Span,
    node_at,
    y_and_z_origins,
)

Aside = tuple[float, float, float, float, float, float]
"""Reach of edges along y and z that lead along x at all, along x and z, and along x and y."""

LONG = 1e7
"""Steps, more than any line has."""


@jitable
def _stay(p: float, r: float, limit: float) -> float:
    """For how many steps r, from p, a number stays within -limit..limit; -1 if it is not there."""
    if not -limit <= p <= limit:
        return -1.0
    ahead = limit - p if r > 0 else limit + p
    return ahead / abs(r) if ahead < LONG * abs(r) else LONG


@jitable
def stretch_in(core: Core, margin: float, p: Vec3, r: Vec3) -> float:
    """For how many steps r, from p, a line stays in what is over, and under, the faces of a box.

    For the face that p is over; -1 where it is over none.
    """
    over = margin + core.radius
    a, b, c = abs(p[0]) - core.x, abs(p[1]) - core.y, abs(p[2]) - core.z
    x, y, z = core.x, core.y, core.z
    if a >= b and a >= c:
        x += over
    elif b >= c:
        y += over
    else:
        z += over
    return min(_stay(p[0], r[0], x), min(_stay(p[1], r[1], y), _stay(p[2], r[2], z)))


@jitable
def stretch_along(core: Core, margin: float, reach: float, aside: Aside, p: Vec3, r: Vec3) -> float:
    """For how many steps r, from p, a line stays over a face of a box, away from its sides.

    No edge from there that leads to a free node comes too near. p is not excluded; -1 where it is
    not over a face like that, or where the box is so thin that an edge could lead through it.
    ``reach`` is how far edges lead.
    """
    over = margin + core.radius
    a, b, c = abs(p[0]) - core.x, abs(p[1]) - core.y, abs(p[2]) - core.z
    x, y, z = core.x, core.y, core.z
    if a >= b and a >= c:
        u, v, thick = p[0], r[0], x + over
        many = min(_stay(p[1], r[1], y - aside[0]), _stay(p[2], r[2], z - aside[1]))
    elif b >= c:
        u, v, thick = p[1], r[1], y + over
        many = min(_stay(p[0], r[0], x - aside[2]), _stay(p[2], r[2], z - aside[3]))
    else:
        u, v, thick = p[2], r[2], z + over
        many = min(_stay(p[0], r[0], x - aside[4]), _stay(p[1], r[1], y - aside[5]))
    if 2 * thick <= reach or abs(u) < thick:
        return -1.0
    return min(many, (abs(u) - thick) / abs(v)) if u * v < 0 else many


@jitable
def beside(core: Core, margin: float, p: Vec3, q: Vec3) -> bool:
    """Check if p and q are beyond the same face of a box by the margin, and all between them is."""
    over = margin + core.radius
    x, y, z = core.x + over, core.y + over, core.z + over
    return (
        (p[0] >= x and q[0] >= x)
        or (p[0] <= -x and q[0] <= -x)
        or (p[1] >= y and q[1] >= y)
        or (p[1] <= -y and q[1] <= -y)
        or (p[2] >= z and q[2] >= z)
        or (p[2] <= -z and q[2] <= -z)
    )


_ROUNDING = 1e-9  # of a step: what is nearer to a limit than this is looked at

Found = tuple[IntArray, IntArray, IntArray, IntArray]


@jitable
def exclusion_of_lattice(
    adjacency: Adjacency,
    open_directions: IntArray,
    solid: FloatArray,
    margin: float,
    reach: float,
    windows: tuple[tuple[Span, Span, Span], tuple[Span, Span, Span]],
) -> Found:
    """Exclusion of the nodes and edges of a lattice in the window around a primitive.

    Line by line along z. The distance changes by no more than the way gone, which says how many
    nodes can be passed over; where the nearest place is on the face of a box, it is known how far
    that remains so.
    """
    shape, places = adjacency.shape, adjacency.places
    axes, core, centre = axes_of(solid, 0), core_of(solid, 0), centre_of(solid, 0)
    y0, z0 = y_and_z_origins(shape)
    nx, ny, nz, directions = 2 * shape.nx, 2 * shape.ny, 2 * shape.nz, shape.directions
    limit = margin + reach
    step = places[z0 + 2] - places[z0]
    r = in_body(axes, (0.0, 0.0, step))
    edges = _edges_in_body(adjacency, axes)
    far = reach + _ROUNDING * reach
    tight, loose = _reach_aside(edges, reach), (far, far, far, far, far, far)
    kinds = 2 if shape.cross else 1
    lines = _lines(windows[0]) + (_lines(windows[1]) if kinds == 2 else 0)
    starts, lengths = np.empty(2 * lines, np.int32), np.empty(2 * lines, np.int32)
    most = 2 * directions * (shape.nz + 1)
    cut_nodes, cut_bits = np.empty(2 * most, np.int32), np.empty(2 * most, np.int32)
    runs, count = 0, 0
    for odd in range(kinds):
        (a0, a1), (b0, b1), (c0, c1) = windows[odd]
        for a in range(a0, a1 + 1, 2):
            x = places[a] - centre[0]
            for b in range(b0, b1 + 1, 2):
                y = places[y0 + b] - centre[1]
                line = node_at(shape, a, b, odd)
                on_box = a == 0 or b == 0 or a == nx or b == ny
                c, fresh = c0, True
                # in the loop along the line the arrays would be counted in and out at each turn
                if count + most > len(cut_nodes):
                    cut_nodes = np.concatenate((cut_nodes, np.empty_like(cut_nodes)))
                    cut_bits = np.concatenate((cut_bits, np.empty_like(cut_bits)))
                while c <= c1:
                    p = in_body(axes, (x, y, places[z0 + c] - centre[2]))
                    away, outward = signed_distance_gradient(core, p)
                    if away < margin:
                        # the primitive is convex: one run a line
                        if fresh:
                            starts[runs], lengths[runs] = line + (c >> 1), 0
                            runs += 1
                            fresh = False
                        more = min(_nodes_inside(core, margin, p, away, r, step), (c1 - c) >> 1) + 1
                        lengths[runs - 1] += more
                        c += 2 * more
                        continue
                    if away >= limit:
                        # convex: along the line at least what its slope here says
                        slope = dot(outward, r)
                        if slope * LONG >= limit - away:
                            break
                        c += 2 * max(int((limit - away) / slope - _ROUNDING), 0) + 2
                        continue
                    if core.is_cylinder == 0:
                        aside = loose if on_box or c == 0 or c == nz else tight
                        many = stretch_along(core, margin, reach, aside, p, r)
                        if many >= 0:
                            more = 2 * max(int(many - _ROUNDING), 0) + 2
                            # the last node of the line may be on the box
                            c = max(c + 2, min(c + more, nz - odd))
                            continue
                    node = line + (c >> 1)
                    near = (node, open_directions[node], (a, b, c), p, away, outward)
                    count = _cut_edges(
                        adjacency, solid, margin, near, edges, cut_nodes, cut_bits, count
                    )
                    c += 2
    return starts[:runs], lengths[:runs], cut_nodes[:count], cut_bits[:count]


@jitable
def _lines(window: tuple[Span, Span, Span]) -> int:
    """Number of lines along z in a window."""
    (a0, a1), (b0, b1), _ = window
    return max((a1 - a0) // 2 + 1, 0) * max((b1 - b0) // 2 + 1, 0)


@jitable
def _edges_in_body(adjacency: Adjacency, axes: Axes) -> FloatArray:
    """Edges in the directions of a lattice (3 d,), in the body's axes, [unit].

    Those of nodes with an even place; of each edge that is the end that comes first.
    """
    steps, places = adjacency.steps, adjacency.places
    y0, z0 = y_and_z_origins(adjacency.shape)
    dx, dy, dz = places[1] - places[0], places[y0 + 1] - places[y0], places[z0 + 1] - places[z0]
    edges = np.empty(len(steps))
    for k in range(0, len(steps), 3):
        edge = in_body(axes, (steps[k] * dx, steps[k + 1] * dy, steps[k + 2] * dz))
        edges[k], edges[k + 1], edges[k + 2] = edge
    return edges


@jitable
def _reach_aside(edges: FloatArray, reach: float) -> Aside:
    """Length along a face of edges that lead towards it; of nodes on the box any edge may."""
    pad = _ROUNDING * reach
    xy, xz, yx, yz, zx, zy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(0, 3 * INTERIOR_DIRECTIONS, 3):
        x, y, z = abs(edges[k]), abs(edges[k + 1]), abs(edges[k + 2])
        if x > pad:
            xy, xz = max(xy, y), max(xz, z)
        if y > pad:
            yx, yz = max(yx, x), max(yz, z)
        if z > pad:
            zx, zy = max(zx, x), max(zy, y)
    return (xy + pad, xz + pad, yx + pad, yz + pad, zx + pad, zy + pad)


@jitable
def _nodes_inside(core: Core, margin: float, p: Vec3, away: float, r: Vec3, step: float) -> int:
    """Number of nodes after an excluded one along z that are certain to be excluded, too."""
    many = (margin - away) / step
    if core.is_cylinder == 0:
        many = max(many, stretch_in(core, margin, p, r))
    return max(int(many - _ROUNDING), 0)


@jitable(forceinline=True)
def _cut_edges(
    adjacency: Adjacency,
    solid: FloatArray,
    margin: float,
    near: tuple[int, int, tuple[int, int, int], Vec3, float, Vec3],
    edges: FloatArray,
    cut_nodes: IntArray,
    cut_bits: IntArray,
    count: int,
) -> int:
    """Note the edges of a free node of a lattice that come too near between free ends.

    Each edge is looked at from that end that comes first, so that rounding decides it once.

    Args:
        adjacency: the lattice.
        solid: (TREE,) row of the primitive.
        margin: what is nearer than this is excluded, [unit].
        near: the node, its directions that exist as bits, and its place in half cells; the place in
            the body's axes, [unit]; and its signed distance, [unit], with the gradient of that.
        edges: (3 d,) see ``_edges_in_body``.
        cut_nodes: the ends of the edges; written.
        cut_bits: the edge at each of these ends, as a bit; written.
        count: how many there are.

    Returns:
        How many there are then.
    """
    shape, _, steps, places, _, _ = adjacency
    axes, core, centre = axes_of(solid, 0), core_of(solid, 0), centre_of(solid, 0)
    node, bits, (a, b, c), p, away, outward = near
    y0, z0 = y_and_z_origins(shape)
    cross = shape.cross
    for k in range(
        cross if c & 1 == 1 else 0,
        shape.directions if bits >> INTERIOR_DIRECTIONS else INTERIOR_DIRECTIONS,
    ):
        if (bits >> k) & 1 == 0 or (k >= cross and (k & 1) == 1):
            continue
        d = (edges[3 * k], edges[3 * k + 1], edges[3 * k + 2])
        # convex: along the edge at least what its slope here says
        if away + outward[0] * d[0] + outward[1] * d[1] + outward[2] * d[2] >= margin:
            continue
        i, j, h = a + steps[3 * k], b + steps[3 * k + 1], c + steps[3 * k + 2]
        q = in_body(axes, sub((places[i], places[y0 + j], places[z0 + h]), centre))
        if core.is_cylinder == 0 and beside(core, margin, p, q):
            continue
        if signed_distance(core, q) < margin:
            continue
        if segment_within(core, margin, p, d):
            cut_nodes[count], cut_nodes[count + 1] = node, node_at(shape, i, j, h)
            cut_bits[count], cut_bits[count + 1] = 1 << k, 1 << (k if k < cross else k + 1)
            count += 2
    return count
