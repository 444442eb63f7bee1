"""Mask of the configurations in which a URDF arm would touch something.

See ``abi.arm_planning.certificates.separate_chain_kernels`` for its capsules.
"""

from __future__ import annotations

import math

import numpy as np

from abi.arm_planning.certificates.separate_chain_kernels import place_bodies
from abi.arm_planning.exclusion.paper_arm_mask_kernels import touched_row
from abi.arm_planning.world.collision_world_kernels import NO_OBSTACLES, Obstacles, asked_rows
from abi.arm_planning.world.hull_row_kernels import hull_and_row
from abi.arrays import BoolArray, FloatArray, IntArray
from abi.clearance.separation_kernels import CERTIFIED
from abi.compilation.borrowed import borrowed, held
from abi.compilation.jitable import jitable
from abi.compiled import FLAGS, FLOATS, NEW_FLAGS, compiled
from abi.obstacles.triangle_mesh.closest_point_kernels import DEPTH
from abi.obstacles.triangle_mesh.triangle_kernels import between_segments
from abi.obstacles.vector_kernels import dot, sub, vec3_at
from abi.robot.bodies.capsule_table import BODIES, Bodies
from abi.robot.bodies.hull_kernels import APART, between_hulls
from abi.robot.kinematics.chain_kernels import POSE, TABLE, ChainTable


@jitable
def _touches_itself(bodies: Bodies, ends: FloatArray, poses: FloatArray, slack: float) -> bool:
    """Check whether two bodies that are to keep apart are nearer than ``slack``."""
    for pair in range(len(bodies.pairs) // 2):
        i, j = bodies.pairs[2 * pair], bodies.pairs[2 * pair + 1]
        p, q = vec3_at(ends, 6 * i), vec3_at(ends, 6 * j)
        way = between_segments(
            p, sub(vec3_at(ends, 6 * i + 3), p), q, sub(vec3_at(ends, 6 * j + 3), q)
        )
        if math.sqrt(dot(way, way)) > bodies.radii[i] + bodies.radii[j] + slack:
            continue
        need = bodies.roundings[i] + bodies.roundings[j] + slack
        if between_hulls(bodies, poses, pair, (0.0, 0.0, 1.0), need, need)[0] != APART:
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
        if hull_and_row(bodies, poses, c, around, s, need, need)[0] != CERTIFIED:
            return True
    return False


@compiled(example=(TABLE, BODIES, FLOATS, NO_OBSTACLES, 0.0, FLAGS, NEW_FLAGS))
def touching_configurations(
    chain: ChainTable,
    bodies: Bodies,
    configurations: FloatArray,
    around: Obstacles,
    slack: float,
    reached: BoolArray,
    touching: BoolArray,
) -> None:
    """Mark the nodes at whose configuration a capsule is too near to something, or to another.

    Args:
        chain: the chain.
        bodies: its capsules.
        configurations: coordinates at the nodes, flat (k n,).
        around: what to keep clear of.
        slack: distance that capsules keep from each other, [unit]; below 0 they are not looked at.
        reached: nodes to look at, (k,).
        touching: (k,); written.
    """
    count, poses = len(chain.limits) // 2, np.empty(POSE * (len(chain.source) + 1))
    own = poses, np.empty(6 * len(bodies.frames)), np.empty(DEPTH, np.int32)
    poses, ends, waiting = borrowed(own)
    rows = asked_rows(around, len(bodies.frames))
    for node in range(len(reached)):
        if not reached[node]:
            continue
        place_bodies(chain, bodies, configurations, node * count, poses, ends)
        touching[node] = slack >= 0 and _touches_itself(bodies, ends, poses, slack)
        for s in rows:
            if touching[node]:
                break
            touching[node] = touches_row(bodies, ends, poses, around, s, waiting)
    held(own)
