"""Configurations of a URDF arm at the nodes of a mesh, and which of them touch something.

They are spread from node to node. For its capsules see
``abi.arm_planning.certificates.separate_chain_kernels``. Against an obstacle of many parts they are
asked many at once: around each capsule, at all configurations of a branch of a tree, is a box, and
what is clear of the boxes is clear of the arm at each of the configurations.
"""

from __future__ import annotations

import math

import numpy as np

from abi.arm_planning.certificates.separate_chain_kernels import place_bodies
from abi.arm_planning.exclusion.paper_arm_mask_kernels import touched_row
from abi.arm_planning.world.chain_distance_kernels import from_centre, hull_and_row
from abi.arm_planning.world.collision_world_kernels import (
    NO_OBSTACLES,
    Obstacles,
    asked_rows,
    box_gap,
)
from abi.arrays import BoolArray, FloatArray, IntArray
from abi.compilation.borrowed import borrowed, held
from abi.compilation.jitable import jitable
from abi.compilation.plain import numbers, zeros
from abi.compiled import FLAGS, FLOATS, IDS, NEW_FLAGS, NEW_FLOATS, NEW_IDS, compiled
from abi.curves.clearance.separation_kernels import CERTIFIED
from abi.obstacles.triangle_mesh.triangle_kernels import DEPTH, between_segments
from abi.obstacles.vector_kernels import dot, sub, vec3_at
from abi.robot.bodies.capsule_table import BODIES, Bodies
from abi.robot.bodies.hull_kernels import APART, between_hulls
from abi.robot.kinematics.chain_kernels import POSE, TABLE, ChainTable
from abi.robot.kinematics.follow_path_kernels import reach_point, room_of
from abi.tet_mesh.node_tree import NO_NODES, NodeTree

_MOST_ITERATIONS = 15
_TRIES = 3
"""Neighbours from which a node is tried."""
_AT_ONCE = 2000
"""Nodes that are gone on from in one call, about 20 ms."""


_MESH, _LIMITS = (FLOATS, IDS, IDS), (0.0, 1.0)
_SPREAD = (TABLE, _MESH, FLOATS, _LIMITS, (0, 0), NEW_FLOATS, NEW_FLAGS, NEW_IDS, NEW_IDS)


@compiled(example=_SPREAD, fallback=False)
def spread(
    chain: ChainTable,
    nodes: tuple[FloatArray, IntArray, IntArray],
    home: FloatArray,
    limits: tuple[float, float],
    counts: tuple[int, int],
    configurations: FloatArray,
    reached: BoolArray,
    queue: IntArray,
    tries: IntArray,
) -> tuple[int, int]:
    """Spread inverse kinematics some way on over a mesh, breadth first, each node from a neighbour.

    A node whose configuration is far from its neighbour's belongs to another sheet and is not
    reached from there: no motion runs between them.

    Args:
        chain: the chain and its task.
        nodes: of the mesh, flat (3 n,), [m], world; where each one's neighbours begin, (n + 1,);
            the neighbours.
        home: coordinates that joints to spare drift to, (m,).
        limits: what a configuration may lack, over the reach or in [rad], and the largest step of a
            coordinate between neighbours, [rad] or [m].
        counts: of the nodes in the queue, those that were gone on from, and all; 0 and 0 at first.
        configurations: coordinates at each node reached, flat (n m,); written. Those of the first
            node are what it is reached from.
        reached: (n,), False at first; written.
        queue: nodes in the order in which they are reached, (n,); at first that to begin with;
            written.
        tries: how often each was tried, (n,), 0 at first; written.

    Returns:
        The counts; they are equal once all that can be reached is.
    """
    points, indptr, indices = nodes
    allowed, longest = limits
    count = len(home)
    room, q = room_of(chain, count), np.empty(count)
    done, found = counts
    if found == 0:
        first = queue[0]
        for j in range(count):
            q[j] = configurations[first * count + j]
        if reach_point(chain, q, home, False, points, first, 4 * _MOST_ITERATIONS, room) > allowed:
            return 0, 0
        for j in range(count):
            configurations[first * count + j] = q[j]
        reached[first], found = True, 1
    end = done + _AT_ONCE
    while done < min(found, end):
        node = queue[done]
        done += 1
        for place in range(indptr[node], indptr[node + 1]):
            to = indices[place]
            if reached[to] or tries[to] >= _TRIES:
                continue
            tries[to] += 1
            for j in range(count):
                q[j] = configurations[node * count + j]
            if reach_point(chain, q, home, True, points, to, _MOST_ITERATIONS, room) > allowed:
                continue
            jump = 0.0
            for j in range(count):
                jump = max(jump, abs(q[j] - configurations[node * count + j]))
            if jump > longest:
                continue
            for j in range(count):
                configurations[to * count + j] = q[j]
            queue[found], reached[to] = to, True
            found += 1
    return done, found


@jitable
def _touches_itself(bodies: Bodies, ends: FloatArray, poses: FloatArray, slack: float) -> bool:
    """Check whether two bodies that are to keep apart are nearer than ``slack``."""
    for pair in range(len(bodies.pairs) // 2):
        i, j = bodies.pairs[2 * pair], bodies.pairs[2 * pair + 1]
        p, q = vec3_at(ends, 6 * i), vec3_at(ends, 6 * j)
        way = between_segments(
            p, sub(vec3_at(ends, 6 * i + 3), p), q, sub(vec3_at(ends, 6 * j + 3), q)
        )
        away = math.sqrt(dot(way, way))
        if away > bodies.radii[i] + bodies.radii[j] + slack:
            continue
        need = bodies.roundings[i] + bodies.roundings[j] + slack
        way = (-way[0] / away, -way[1] / away, -way[2] / away) if away > 0 else (0.0, 0.0, 1.0)
        if between_hulls(bodies, poses, pair, way, need, need, False)[0] != APART:
            return True
    return False


@jitable
def touches_row(
    bodies: Bodies,
    ends: FloatArray,
    poses: FloatArray,
    around: Obstacles,
    s: int,
    waiting: IntArray,
) -> bool:
    """Check whether a body is too near to row s, or the floor, if it is to keep clear of it.

    Of a triangle mesh it is asked of the capsule.
    """
    count = len(around.margins)
    for c in range(len(bodies.frames)):
        if not around.asked[c * count + s]:
            continue
        a, b = vec3_at(ends, 6 * c), vec3_at(ends, 6 * c + 3)
        need = bodies.radii[c] + around.margins[s]
        if s == count - 1:
            if min(a[2], b[2]) - around.floor >= need:
                continue
        elif touched_row(around, s, a, b, need, -1, waiting) < 0:
            continue
        elif around.meshes[s] >= 0:
            return True
        need = bodies.roundings[c] + around.margins[s]
        way = from_centre(around, s, a, b)
        if hull_and_row(bodies, poses, c, around, s, way, need, need, False)[0] != CERTIFIED:
            return True
    return False


@jitable(forceinline=True)
def _touches(
    chain: ChainTable,
    bodies: Bodies,
    configurations: FloatArray,
    node: int,
    asked: tuple[Obstacles, list[int], float],
    room: tuple[FloatArray, FloatArray, IntArray],
) -> bool:
    """Check whether a capsule is too near to one of the rows asked of, or to another capsule.

    ``room`` is for the poses of the joints, flat (12 (m + 1),), for the ends of all capsules, flat
    (6 c,), and for ``DEPTH`` rows.
    """
    (poses, ends, waiting), (around, rows, slack) = room, asked
    place_bodies(chain, bodies, configurations, node * (len(chain.limits) // 2), poses, ends)
    touching = False
    for s in rows:
        touching = touching or touches_row(bodies, ends, poses, around, s, waiting)
    # last, as it takes longest
    return touching or (slack >= 0 and _touches_itself(bodies, ends, poses, slack))


_BOX = 6
"""Numbers of a box: its low and its high corner."""


BoxedTree = tuple[NodeTree, FloatArray]
"""A tree over the places of configurations, and boxes around the segment of each of c capsules at
the configurations of each of its m branches, low corners above high ones where there is none, flat
(6 c m,), [unit], world."""

NO_BOXES = NO_NODES, FLOATS
"""A tree of nothing: for configurations that are asked one by one, and for the compiler."""


@compiled(example=(TABLE, BODIES, FLOATS, NO_NODES, FLAGS, NEW_FLOATS))
def bound_configurations(
    chain: ChainTable,
    bodies: Bodies,
    configurations: FloatArray,
    tree: NodeTree,
    reached: BoolArray,
    boxes: FloatArray,
) -> None:
    """Write the boxes of a tree, see :data:`BoxedTree`.

    Args:
        chain: the chain, with n coordinates.
        bodies: its capsules.
        configurations: coordinates at the k places, flat (k n,).
        tree: over the places.
        reached: places that count, (k,).
        boxes: those around nothing at first; written.
    """
    count, size = len(chain.limits) // 2, _BOX * len(bodies.frames)
    own = numbers(POSE * (len(chain.source) + 1)), numbers(size)
    poses, ends = borrowed(own)
    inner = len(tree.leaves) - 2
    for leaf in range(len(tree.leaves) - 1):
        for i in range(tree.leaves[leaf], tree.leaves[leaf + 1]):
            node, at = tree.order[i], size * (inner + leaf)
            if not reached[node]:
                continue
            place_bodies(chain, bodies, configurations, node * count, poses, ends)
            for k in range(size):
                low = at + k - (3 if k % _BOX >= 3 else 0)
                boxes[low] = min(boxes[low], ends[k])
                boxes[low + 3] = max(boxes[low + 3], ends[k])
    for branch in range(inner - 1, -1, -1):
        for k in range(size):
            a, b = boxes[size * (2 * branch + 1) + k], boxes[size * (2 * branch + 2) + k]
            boxes[size * branch + k] = min(a, b) if k % _BOX < 3 else max(a, b)
    held(own)


@jitable
def _comes_near(bodies: Bodies, boxes: FloatArray, at: int, around: Obstacles, s: int) -> bool:
    """Check if the capsule of some box, of those from ``at`` on, may be too near to row s."""
    for c in range(len(bodies.frames)):
        low, high = vec3_at(boxes, at + _BOX * c), vec3_at(boxes, at + _BOX * c + 3)
        need = bodies.radii[c] + around.margins[s]
        if low[0] <= high[0] and box_gap(around.primitives, s, low, high) < need:
            return True
    return False


@compiled(example=(TABLE, BODIES, FLOATS, NO_BOXES, (NO_OBSTACLES, 0), 0.0, FLAGS, NEW_FLAGS))
def touching_configurations(
    chain: ChainTable,
    bodies: Bodies,
    configurations: FloatArray,
    tree: BoxedTree,
    obstacle: tuple[Obstacles, int],
    slack: float,
    asked: BoolArray,
    touching: BoolArray,
) -> None:
    """Mark the places at whose configuration a capsule is too near to something, or to another.

    Args:
        chain: the chain, with n coordinates.
        bodies: its capsules.
        configurations: coordinates at the k places, flat (k n,).
        tree: over the places; :data:`NO_BOXES` where the row is -1 and each is checked by itself.
        obstacle: what to keep clear of, and the row with all that is asked about; -1 for all rows.
        slack: distance that capsules keep from each other, [unit]; below 0 they are not looked at.
        asked: places to look at, of those that count in the tree, (k,).
        touching: (k,), False at first; written.
    """
    (around, root), (nodes, boxes) = obstacle, tree
    size = _BOX * len(bodies.frames)
    poses = numbers(POSE * (len(chain.source) + 1))
    own = poses, numbers(size), zeros(DEPTH)
    room, work = borrowed(own), [0]
    if root < 0:
        every = around, asked_rows(around, len(bodies.frames)), slack
        for node in range(len(asked)):
            if asked[node]:
                touching[node] = _touches(chain, bodies, configurations, node, every, room)
        work.clear()
    inner, this = len(nodes.leaves) - 2, (around, [root], slack)
    while len(work) > 0:
        branch = work.pop()
        if not _comes_near(bodies, boxes, size * branch, around, root):
            continue
        if branch < inner:
            work.append(2 * branch + 1)
            work.append(2 * branch + 2)
            continue
        for i in range(nodes.leaves[branch - inner], nodes.leaves[branch - inner + 1]):
            node = nodes.order[i]
            if asked[node]:
                touching[node] = _touches(chain, bodies, configurations, node, this, room)
    held(own)
