"""Distances of an arm's hulls to its surroundings at many poses."""

from __future__ import annotations

import math

import numpy as np

from abi.arm_planning.world.collision_world_kernels import NO_OBSTACLES, Obstacles, box_gap
from abi.arm_planning.world.hull_row_kernels import hull_and_row
from abi.arrays import FloatArray, IntArray
from abi.compiled import FLOATS, IDS, NEW_FLOATS, NEW_IDS, compiled
from abi.obstacles.triangle_mesh.closest_point_kernels import DEPTH
from abi.obstacles.vector_kernels import vec3_at
from abi.robot.bodies.capsule_table import BODIES, Bodies
from abi.robot.kinematics.chain_kernels import POSE


@compiled(example=(BODIES, FLOATS, FLOATS, NO_OBSTACLES, IDS, 0.0, NEW_FLOATS, NEW_IDS))
def hull_clearances(
    bodies: Bodies,
    poses: FloatArray,
    ends: FloatArray,
    around: Obstacles,
    asked: IntArray,
    enough: float,
    distances: FloatArray,
    rows: IntArray,
) -> None:
    """Distances of hulls, with their roundings, to what their capsules are to keep clear of.

    Args:
        bodies: the bodies.
        poses: of the joints at each of n poses, flat (12 (m + 1) n,), [m].
        ends: of all capsules at each, flat (6 c n,), [unit], world.
        around: what to keep clear of.
        asked: number of a pose and of a body, flat (2 k,).
        enough: distances above it may be any from there on, [unit].
        distances: (k,), [unit], 0 where they overlap; written.
        rows: the nearest row of each, -1 where none is as near, (k,); written.
    """
    size, capsules, count = POSE * (bodies.moving + 1), len(bodies.frames), len(around.margins)
    waiting = np.empty(DEPTH + count, np.int32)
    for k in range(len(distances)):
        at, c = asked[2 * k] * size, asked[2 * k + 1]
        placed, first = poses[at : at + size], 6 * (asked[2 * k] * capsules + c)
        a, b = vec3_at(ends, first), vec3_at(ends, first + 3)
        best, nearest, open_ = bodies.roundings[c] + enough, -1, 0
        for one in range(len(around.outer)):
            if around.asked[c * count + around.outer[one]]:
                waiting[open_] = around.outer[one]
                open_ += 1
        while open_ > 0:
            open_ -= 1
            s = waiting[open_]
            # the hull is not in the capsule where this is exactly as wide
            gap = -math.inf if s == count - 1 else box_gap(around.primitives, s, a, b)
            if gap - 1.01 * bodies.radii[c] > best:
                continue
            if s < count - 1 and around.inside[2 * s + 1] > 0:
                for row in range(around.inside[2 * s], around.inside[2 * s + 1]):
                    waiting[open_] = row
                    open_ += 1
                continue
            _, away, _ = hull_and_row(bodies, placed, c, around, s, 0.0, best)
            if away < best:
                best, nearest = away, s
        distances[k], rows[k] = max(best - bodies.roundings[c], 0.0), nearest
