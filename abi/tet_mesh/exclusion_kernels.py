"""What obstacles take away from a mesh: nodes, and edges between the nodes that are left.

Compiled by numba; each runs uncompiled too, by its ``py_func``. A solid is a row of numbers, see
``abi.obstacles.primitive_kernels``; a mesh is described in ``abi.tet_mesh.adjacency_kernels``.
"""

from __future__ import annotations

import numpy as np
from numba.extending import register_jitable

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.compiled import FLOATS, IDS, NEW_FLAGS, NEW_IDS, compiled
from abi.obstacles.primitive_kernels import (
    Axes,
    Core,
    axes_of,
    core_of,
    in_body,
    segment_within,
    signed_distance,
    signed_distance_gradient,
)
from abi.tet_mesh.adjacency_kernels import (
    BCC,
    NO_SHAPE,
    ROWS,
    SIDES,
    Shape,
    across,
    cell,
    half_cells,
    node_at,
)
from abi.tet_mesh.face_kernels import LONG, beside, stretch_along, stretch_in

_ROUNDING = 1e-9  # of a step: what is nearer to a limit than this is looked at


@compiled(
    example=(NO_SHAPE, IDS, IDS, FLOATS, IDS, IDS, IDS, FLOATS, 0.0, 1.0), error_model="numpy"
)
def take(
    shape: Shape,
    offsets: IntArray,
    steps: IntArray,
    places: FloatArray,
    indptr: IntArray,
    indices: IntArray,
    exits: IntArray,
    solid: FloatArray,
    margin: float,
    reach: float,
) -> tuple[IntArray, IntArray, IntArray, IntArray]:
    """The nodes nearer to a solid than ``margin``, and the edges of the other nodes that are.

    Only the window around the solid is looked at, line by line along z. The distance changes by no
    more than the way gone, which says how many nodes can be passed over; where the nearest place is
    on the face of a box, it is known how far that remains so.

    Args:
        shape, offsets, steps, places, indptr, indices: the mesh.
        exits: (n,) directions that exist.
        solid: (WIDTH,) row.
        margin: [unit].
        reach: the longest edge, [unit].

    Returns:
        First nodes of the runs that are excluded and how many each has (r,); in a lattice nodes
        that lose edges to others that are not excluded, and the bits of these edges (m,); of rows
        all edges that nodes lose, and 0.
    """
    nodes, cross, directions = shape[5], shape[7], shape[6]
    axes, core = axes_of(solid, 0), core_of(solid, 0)
    cx, cy, cz = solid[0], solid[1], solid[2]
    limit = margin + reach
    pad = _ROUNDING * reach
    if shape[0] == ROWS:
        starts = np.empty(nodes, np.int32)
        gone = np.empty(len(indices), np.int32)
        runs, shut = 0, 0
        for node in range(nodes):
            x, y, z = places[node], places[nodes + node], places[2 * nodes + node]
            away = _level_at(axes, core, cx, cy, cz, x, y, z)
            if away < margin:
                starts[runs] = node
                runs += 1
            elif away < limit:
                for k in range(indptr[node], indptr[node + 1]):
                    head = indices[k]
                    qx, qy, qz = places[head], places[nodes + head], places[2 * nodes + head]
                    if _level_at(axes, core, cx, cy, cz, qx, qy, qz) < margin:
                        gone[shut] = k
                        shut += 1
                        continue
                    # from the same end both times, for rounding
                    if node < head:
                        p = in_body(axes, (x - cx, y - cy, z - cz))
                        d = in_body(axes, (qx - x, qy - y, qz - z))
                    else:
                        p = in_body(axes, (qx - cx, qy - cy, qz - cz))
                        d = in_body(axes, (x - qx, y - qy, z - qz))
                    gone[shut] = k
                    shut += 1 if segment_within(core, margin, p, d) else 0
        lengths = np.ones(runs, np.int32)
        return starts[:runs], lengths, gone[:shut], np.zeros(shut, np.int32)

    y0 = 2 * shape[1] + 1
    z0 = y0 + 2 * shape[2] + 1
    step = places[z0 + 2] - places[z0]
    far = reach + pad
    rx, ry, rz = in_body(axes, (0.0, 0.0, step))
    # in the body, and from the end of the edge that comes first
    turned = np.empty(3 * directions)
    for k in range(directions):
        x = steps[3 * k] * (places[1] - places[0])
        y = steps[3 * k + 1] * (places[y0 + 1] - places[y0])
        z = steps[3 * k + 2] * (places[z0 + 1] - places[z0])
        turned[3 * k], turned[3 * k + 1], turned[3 * k + 2] = in_body(axes, (x, y, z))
    # how far edges that lead towards a face lead along it; of nodes on the box any edge may
    xy, xz, yx, yz, zx, zy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(SIDES):
        x, y, z = abs(turned[3 * k]), abs(turned[3 * k + 1]), abs(turned[3 * k + 2])
        if x > pad:
            xy, xz = max(xy, y), max(xz, z)
        if y > pad:
            yx, yz = max(yx, x), max(yz, z)
        if z > pad:
            zx, zy = max(zx, x), max(zy, y)
    tight = (xy + pad, xz + pad, yx + pad, yz + pad, zx + pad, zy + pad)
    loose = (far, far, far, far, far, far)
    # arrays that grew in the loops would be counted in and out all the time
    odds = 2 if shape[0] == BCC else 1
    window = np.empty(12, np.int64)
    lines = 0
    for odd in range(odds):
        count = 1
        for axis in range(3):
            origin = 0 if axis == 0 else (y0 if axis == 1 else z0)
            low, high = solid[17 + axis] - limit, solid[20 + axis] + limit
            first, last = half_cells(
                places[origin], places[origin + 2], shape[1 + axis], low, high, odd
            )
            window[6 * odd + 2 * axis], window[6 * odd + 2 * axis + 1] = first, last
            lines += count if axis == 2 else 0
            count *= max((last - first) // 2 + 1, 0)
    starts = np.empty(2 * lines, np.int32)
    lengths = np.empty(2 * lines, np.int32)
    most = 2 * directions * (shape[3] + 1)
    losers = np.empty(2 * most, np.int32)
    losses = np.empty(2 * most, np.int32)
    runs, count = 0, 0
    for odd in range(odds):
        at = 6 * odd
        c0, c1 = window[at + 4], window[at + 5]
        for a in range(window[at], window[at + 1] + 1, 2):
            x = places[a] - cx
            for b in range(window[at + 2], window[at + 3] + 1, 2):
                y = places[y0 + b] - cy
                line = node_at(shape, a, b, odd)
                on_box = a == 0 or b == 0 or a == 2 * shape[1] or b == 2 * shape[2]
                c = c0
                fresh = True
                # in the loop along the line the arrays would be counted in and out at each turn
                if count + most > len(losers):
                    losers = np.concatenate((losers, np.empty_like(losers)))
                    losses = np.concatenate((losses, np.empty_like(losses)))
                while c <= c1:
                    px, py, pz = in_body(axes, (x, y, places[z0 + c] - cz))
                    away = signed_distance(core, (px, py, pz))
                    if away < margin:
                        many = (margin - away) / step
                        if core[4] == 0:
                            many = max(many, stretch_in(core, margin, px, py, pz, rx, ry, rz))
                        more = min(max(int(many - _ROUNDING), 0), (c1 - c) >> 1) + 1
                        # the solid is convex: one run a line
                        if fresh:
                            starts[runs] = line + (c >> 1)
                            lengths[runs] = 0
                            runs += 1
                            fresh = False
                        lengths[runs - 1] += more
                        c += 2 * more
                        continue
                    _, (gx, gy, gz) = signed_distance_gradient(core, (px, py, pz))
                    if away >= limit:
                        # convex: along the line at least what its slope here says
                        slope = gx * rx + gy * ry + gz * rz
                        if slope * LONG >= limit - away:
                            break
                        c += 2 * max(int((limit - away) / slope - _ROUNDING), 0) + 2
                        continue
                    if core[4] == 0:
                        aside = loose if on_box or c == 0 or c == 2 * shape[3] else tight
                        many = stretch_along(core, margin, reach, aside, px, py, pz, rx, ry, rz)
                        if many >= 0:
                            more = 2 * max(int(many - _ROUNDING), 0) + 2
                            # the last node of the line may be on the box
                            c = max(c + 2, min(c + more, 2 * shape[3] - odd))
                            continue
                    node = line + (c >> 1)
                    bits = exits[node]
                    # each edge from that end that comes first, for rounding
                    for k in range(
                        cross if odd == 1 else 0, directions if bits >> SIDES else SIDES
                    ):
                        if (bits >> k) & 1 == 0 or (k >= cross and (k & 1) == 1):
                            continue
                        dx, dy, dz = turned[3 * k], turned[3 * k + 1], turned[3 * k + 2]
                        # convex: along the edge at least what its slope here says
                        if away + gx * dx + gy * dy + gz * dz >= margin:
                            continue
                        i, j, h = a + steps[3 * k], b + steps[3 * k + 1], c + steps[3 * k + 2]
                        qx, qy, qz = in_body(
                            axes, (places[i] - cx, places[y0 + j] - cy, places[z0 + h] - cz)
                        )
                        if core[4] == 0 and beside(core, margin, px, py, pz, qx, qy, qz):
                            continue
                        if signed_distance(core, (qx, qy, qz)) < margin:
                            continue
                        if segment_within(core, margin, (px, py, pz), (dx, dy, dz)):
                            losers[count], losses[count] = node, 1 << k
                            losers[count + 1] = node_at(shape, i, j, h)
                            losses[count + 1] = 1 << (k if k < cross else k + 1)
                            count += 2
                    c += 2
    return starts[:runs], lengths[:runs], losers[:count], losses[:count]


@compiled(example=(IDS, IDS, NEW_FLAGS))
def mark(starts: IntArray, lengths: IntArray, excluded: BoolArray) -> int:
    """Mark the nodes of runs; how many were not marked before.

    Args:
        starts: (r,) first nodes.
        lengths: (r,) numbers of nodes.
        excluded: (n,) set True where a node is in a run.
    """
    count = 0
    for run in range(len(starts)):
        for node in range(starts[run], starts[run] + lengths[run]):
            count += 0 if excluded[node] else 1
            excluded[node] = True
    return count


@compiled(example=(NO_SHAPE, IDS, IDS, IDS, IDS, IDS, IDS, NEW_IDS), error_model="numpy")
def shut(
    shape: Shape,
    offsets: IntArray,
    steps: IntArray,
    starts: IntArray,
    lengths: IntArray,
    losers: IntArray,
    losses: IntArray,
    exits: IntArray,
) -> None:
    """Clear the bits of edges that lead to excluded nodes of a lattice, and of those lost.

    Args:
        shape, offsets, steps: the lattice.
        starts, lengths: (r,) runs of excluded nodes, each in one line along z.
        losers: (m,) nodes that lose edges.
        losses: (m,) bits of these.
        exits: (n,) open directions, as bits.
    """
    directions, cross = shape[6], shape[7]
    for run in range(len(starts)):
        first, many = starts[run], lengths[run]
        a, b, c = cell(shape, first)
        odd = a & 1
        other = across(shape, a, b, c)
        end = c + 2 * (many - 1)
        # what is no edge has no bit to clear, but nodes on the box have more edges
        inside = 0 < a < 2 * shape[1] and 0 < b < 2 * shape[2] and c > 0 and end < 2 * shape[3]
        for k in range(SIDES if inside else directions):
            turned = -1 if k < cross and odd == 1 else 1
            i, j, h = turned * steps[3 * k], turned * steps[3 * k + 1], turned * steps[3 * k + 2]
            if not (0 <= a + i <= 2 * shape[1] and 0 <= b + j <= 2 * shape[2]):
                continue
            low = 1 if c + h < 0 else 0
            high = many - 1 if end + h > 2 * shape[3] else many
            others = ~(1 << (k if k < cross else k ^ 1))
            head = (other if k < cross else first) + offsets[odd * directions + k]
            for n in range(head + low, head + high):
                exits[n] &= others
    for k in range(len(losers)):
        exits[losers[k]] &= ~losses[k]


@register_jitable
def _level_at(
    axes: Axes, core: Core, cx: float, cy: float, cz: float, x: float, y: float, z: float
) -> float:
    p = in_body(axes, (x - cx, y - cy, z - cz))
    return signed_distance(core, p)
