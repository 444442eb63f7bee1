"""Short paths by places that see each other, between convex solids.

Plain Python that numba compiles with its caller; uncompiled it runs on lists. For the rows of
numbers that describe solids see ``abi.obstacles.primitive_kernels``.
"""

from __future__ import annotations

import math

from numba.extending import register_jitable

from abi.arrays import FloatArray
from abi.obstacles.primitive_kernels import WIDTH, any_within, blocked, blocker
from abi.obstacles.vector_kernels import distance


@register_jitable
def places(
    edges: FloatArray,
    ends: list[float],
    samples: int,
    most: float,
    margin: float,
    bounds: FloatArray,
    solids: FloatArray,
) -> tuple[list[float], list[float], list[float], list[int]]:
    """Start, goal, and places on edges by which a path between them may be short.

    On each edge: ``samples`` places evenly apart, and the one by which the way between the ends is
    shortest; those that keep the margin, lie in the box and are not too far off.

    Args:
        edges: (6 e,) both ends of each, [unit], world.
        ends: (6,) start and goal, [unit], world.
        samples: number on each edge.
        most: length that a way from start to goal by a place must be below, [unit].
        margin: distance to keep from the solids, [unit].
        bounds: (6,) low and high corner of the box, [unit].
        solids: (k WIDTH,) rows, one after the other.

    Returns:
        Their coordinates (n,) each, and numbers of the edges (n,).
    """
    ax, ay, az, bx, by, bz = ends[0], ends[1], ends[2], ends[3], ends[4], ends[5]
    x, y, z, labels = [ax, bx], [ay, by], [az, bz], [-1, -1]
    for e in range(0, len(edges), 6):
        px, py, pz = edges[e], edges[e + 1], edges[e + 2]
        dx, dy, dz = edges[e + 3] - px, edges[e + 4] - py, edges[e + 5] - pz
        square = dx * dx + dy * dy + dz * dz
        # the way by a line is shortest where the mirror image of one end about it is in line
        best = 0.0
        if square > 0:
            foot_a = ((ax - px) * dx + (ay - py) * dy + (az - pz) * dz) / square
            foot_b = ((bx - px) * dx + (by - py) * dy + (bz - pz) * dz) / square
            off_a = distance((ax, ay, az), (px + foot_a * dx, py + foot_a * dy, pz + foot_a * dz))
            off_b = distance((bx, by, bz), (px + foot_b * dx, py + foot_b * dy, pz + foot_b * dz))
            if off_a + off_b > 0:
                best = (foot_a * off_b + foot_b * off_a) / (off_a + off_b)
                best = min(max(best, 0.0), 1.0)
        qx, qy, qz = px + best * dx, py + best * dy, pz + best * dz
        if distance((qx, qy, qz), (ax, ay, az)) + distance((qx, qy, qz), (bx, by, bz)) >= most:
            continue
        for k in range(samples + 1 if square > 0 else 1):
            share = best if k == 0 else k / (samples + 1)
            qx, qy, qz = px + share * dx, py + share * dy, pz + share * dz
            if (
                bounds[0] <= qx <= bounds[3]
                and bounds[1] <= qy <= bounds[4]
                and bounds[2] <= qz <= bounds[5]
                and distance((qx, qy, qz), (ax, ay, az)) + distance((qx, qy, qz), (bx, by, bz))
                < most
                and not any_within(solids, margin, (qx, qy, qz))
            ):
                x.append(qx)
                y.append(qy)
                z.append(qz)
                labels.append(e // 6)
    return x, y, z, labels


@register_jitable
def _same_way(parent: list[int], labels: list[int], node: int, other: int) -> bool:
    """Whether the ways to two places go by the same labels, each counted once in a row."""
    while True:
        if labels[node] != labels[other]:
            return False
        label = labels[node]
        while node != 0 and labels[node] == label:
            node = parent[node]
        while other != 0 and labels[other] == label:
            other = parent[other]
        if node == 0 or other == 0:
            return node == other


@register_jitable
def ways(
    x: list[float],
    y: list[float],
    z: list[float],
    labels: list[int],
    solids: FloatArray,
    margins: FloatArray,
    most: float,
    count: int,
) -> list[int]:
    """Short paths from the first place to the second by places that see each other.

    A* on the visibility graph: of the shortest paths to each place that sees the second, the first
    in order of length that go by other labels than those before. The first of all is the shortest
    path there is. Whether two places see each other is tested only where it matters.

    Args:
        x, y, z: (n,) places, n >= 2, [unit], world.
        labels: (n,) which places count as the same, from the third on.
        solids: (k WIDTH,) rows, one after the other.
        margins: (4k,), see ``abi.taut.tighten_kernels``.
        most: length that the paths must be below, [unit].
        count: how many paths at most.

    Returns:
        Indices of the paths, one after the other, each from 0 to 1 (m,); empty when there is none.
    """
    total = len(x)
    solid_count = len(solids) // WIDTH
    cost = [math.inf] * total
    parent = [0] * total
    to_go = [distance((x[i], y[i], z[i]), (x[1], y[1], z[1])) for i in range(total)]
    left = list(range(2, total))
    lasts = [0] * count
    found, guess = 0, 0
    node, cost[0] = 0 if to_go[0] < most else -1, 0.0
    while node >= 0 and found < count:
        px, py, pz, so_far = x[node], y[node], z[node], cost[node]
        first = solid_count if node == 0 else 0
        if not blocked(solids, margins, first + 2 * solid_count, (px, py, pz), (x[1], y[1], z[1])):
            new = True
            for k in range(found):
                if _same_way(parent, labels, node, lasts[k]):
                    new = False
            lasts[found] = node
            found += 1 if new else 0
        last, node, at, least = node, -1, 0, most
        for k in range(len(left)):
            i = left[k]
            through = so_far + distance((px, py, pz), (x[i], y[i], z[i]))
            if through < cost[i] and through + to_go[i] < most:
                # what was in the way is likely to be in the way of the next place too
                in_the_way = blocker(
                    solids, margins, first, guess, (px, py, pz), (x[i], y[i], z[i])
                )
                if in_the_way >= 0:
                    guess = in_the_way
                else:
                    cost[i] = through
                    parent[i] = last
            if cost[i] + to_go[i] < least:
                node, at, least = i, k, cost[i] + to_go[i]
        if node >= 0:
            left[at] = left[len(left) - 1]
            left.pop()
    nodes = [0] * 0
    for k in range(found):
        way = [1, lasts[k]]
        while way[-1] != 0:
            way.append(parent[way[-1]])
        nodes.extend(way[::-1])
    return nodes
