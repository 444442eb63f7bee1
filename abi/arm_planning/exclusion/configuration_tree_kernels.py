"""Configurations at which a URDF arm touches an obstacle, many configurations at once.

Around each capsule, at all configurations of a branch of a tree, is a box: what is clear of the
boxes is clear of the arm at each of the configurations.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abi.arm_planning.certificates.separate_chain_kernels import place_bodies
from abi.arm_planning.exclusion.chain_mask_kernels import touches_row
from abi.arm_planning.world.collision_world_kernels import NO_OBSTACLES, Obstacles, box_gap
from abi.arrays import BoolArray, FloatArray, IntArray
from abi.compilation.borrowed import borrowed, held
from abi.compilation.jitable import jitable
from abi.compiled import FLAGS, FLOATS, IDS, NEW_FLAGS, NEW_FLOATS, compiled
from abi.obstacles.triangle_mesh.closest_point_kernels import DEPTH
from abi.obstacles.vector_kernels import vec3_at
from abi.robot.bodies.capsule_table import BODIES, Bodies
from abi.robot.kinematics.chain_kernels import POSE, TABLE, ChainTable

_BOX = 6
"""Numbers of a box: its low and its high corner."""


class ConfigurationTree(NamedTuple):
    """Configurations of a chain with n coordinates, in a tree over their places.

    Attributes:
        configurations: coordinates at the k places, flat (k n,).
        order: places in the tree's order (k,).
        leaves: first place of each leaf in that order, as in :class:`abi.tet_mesh.node_tree`.
        boxes: around the segment of each of c capsules at the configurations of each of m branches,
            low corners above high ones where there is none, flat (6 c m,), [unit], world.
    """

    configurations: FloatArray
    order: IntArray
    leaves: IntArray
    boxes: FloatArray


NO_CONFIGURATIONS = ConfigurationTree(FLOATS, IDS, IDS, FLOATS)
"""Example for the compiler."""


@compiled(example=(TABLE, BODIES, NO_CONFIGURATIONS, FLAGS, NEW_FLOATS))
def bound_configurations(
    chain: ChainTable,
    bodies: Bodies,
    tree: ConfigurationTree,
    reached: BoolArray,
    boxes: FloatArray,
) -> None:
    """Write the boxes of a tree.

    Args:
        chain: the chain.
        bodies: its capsules.
        tree: the configurations, without boxes.
        reached: places that count, (k,).
        boxes: those around nothing at first; written.
    """
    count, size = len(chain.limits) // 2, _BOX * len(bodies.frames)
    own = np.empty(POSE * (len(chain.source) + 1)), np.empty(size)
    poses, ends = borrowed(own)
    inner = len(tree.leaves) - 2
    for leaf in range(len(tree.leaves) - 1):
        for i in range(tree.leaves[leaf], tree.leaves[leaf + 1]):
            node, at = tree.order[i], size * (inner + leaf)
            if not reached[node]:
                continue
            place_bodies(chain, bodies, tree.configurations, node * count, poses, ends)
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


@compiled(example=(TABLE, BODIES, NO_CONFIGURATIONS, (NO_OBSTACLES, 0), FLAGS, NEW_FLAGS))
def configurations_touching(
    chain: ChainTable,
    bodies: Bodies,
    tree: ConfigurationTree,
    obstacle: tuple[Obstacles, int],
    asked: BoolArray,
    touching: BoolArray,
) -> None:
    """Mark the places at whose configuration a capsule is too near to an obstacle.

    Args:
        chain: the chain.
        bodies: its capsules.
        tree: the configurations.
        obstacle: what to keep clear of, and the row with all of it.
        asked: places to look at, of those that count in the tree, (k,).
        touching: (k,), False at first; written.
    """
    around, root = obstacle
    count, size = len(chain.limits) // 2, _BOX * len(bodies.frames)
    poses = np.empty(POSE * (len(chain.source) + 1))
    own = poses, np.empty(size), np.empty(DEPTH, np.int32)
    poses, ends, waiting = borrowed(own)
    inner, work = len(tree.leaves) - 2, [0]
    while len(work) > 0:
        branch = work.pop()
        if not _comes_near(bodies, tree.boxes, size * branch, around, root):
            continue
        if branch < inner:
            work.append(2 * branch + 1)
            work.append(2 * branch + 2)
            continue
        for i in range(tree.leaves[branch - inner], tree.leaves[branch - inner + 1]):
            node = tree.order[i]
            if not asked[node]:
                continue
            place_bodies(chain, bodies, tree.configurations, node * count, poses, ends)
            touching[node] = touches_row(bodies, ends, poses, around, root, waiting)
    held(own)
