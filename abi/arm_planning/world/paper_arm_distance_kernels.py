"""Distances of the paper's arm's capsules to the surroundings.

See ``abi.robot.paper_arm.pose_kernels`` for the numbers of an arm and its capsules.
"""

from __future__ import annotations

import math

import numpy as np

from abi.arm_planning.world.collision_world_kernels import (
    NO_OBSTACLES,
    Obstacles,
    asked_rows,
    box_gap,
)
from abi.arrays import FloatArray, IntArray
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, NEW_FLOATS, NEW_IDS, compiled
from abi.obstacles.obstacle_set_kernels import distance_to_segment
from abi.obstacles.vector_kernels import distance, vec3_at
from abi.robot.paper_arm.pose_kernels import CAPSULE

_ROUNDING = 1e-12
"""Part, and [unit], by which distances that are compared may be wrong."""


@jitable(forceinline=True)
def way(ends: FloatArray, k: int, before: int) -> float:
    """Largest distance of a segment's points from where they were; both by their rows."""
    a, b = vec3_at(ends, 6 * k), vec3_at(ends, 6 * k + 3)
    at_a, at_b = vec3_at(ends, 6 * before), vec3_at(ends, 6 * before + 3)
    return (1 + _ROUNDING) * max(distance(a, at_a), distance(b, at_b)) + _ROUNDING


@compiled(example=(FLOATS, FLOATS, NO_OBSTACLES, 0.0, NEW_FLOATS, NEW_IDS))
def capsule_clearances(
    ends: FloatArray,
    capsules: FloatArray,
    around: Obstacles,
    enough: float,
    clearances: FloatArray,
    nearest: IntArray,
) -> None:
    """Least signed distance of capsules' surfaces to what they are to keep clear of.

    Of a capsule that touches nothing and is not the nearest of its pose the distance may be inf.
    One that has been far away is not measured again before it has come near by its own way.

    Args:
        ends: of each pose both ends of the capsules, flat (6 n c,), [unit], world.
        capsules: rows (4 c,).
        around: the obstacles; the last one is the floor.
        enough: distances above it may be inf, too, [unit]; above 0.
        clearances: (n c,), [unit]; written.
        nearest: (n c,) the nearest obstacle, -1 where there is none; written.
    """
    moving, count = len(capsules) // CAPSULE, len(around.margins)
    rows = asked_rows(around, moving)
    least_yet = np.full(moving, -np.inf)  # what each capsule's clearance is not below
    latest = np.zeros(moving, np.int64)  # what each capsule was nearest to
    likely = 0  # the nearest capsule of the pose before
    for i in range(len(clearances) // moving):
        least, first = enough, likely
        for number in range(moving + 1):
            c = first if number == 0 else number - 1
            if number > 0 and c == first:
                continue
            k = i * moving + c
            if i > 0:
                least_yet[c] -= way(ends, k, k - moving)
            clearances[k], nearest[k] = math.inf, -1
            if least_yet[c] > max(least, 0.0):
                continue
            radius = capsules[CAPSULE * c + 3]
            a, b = vec3_at(ends, 6 * k), vec3_at(ends, 6 * k + 3)
            # as far again as it counts, so that it need not be measured again soon
            best, whose = 2 * max(least, 0.0) + radius, -1
            beyond = math.inf
            # what was nearest at the pose before rules out most of the others
            for turn in range(len(rows) + 1):
                s = latest[c] if turn == 0 else rows[turn - 1]
                if not around.asked[c * count + s] or (turn > 0 and s == latest[c]):
                    continue
                if s == count - 1:
                    away = min(a[2], b[2]) - around.floor
                else:
                    away = box_gap(around.primitives, s, a, b)
                    if away < best:
                        away = distance_to_segment(around.primitives, s, best, a, b)
                beyond = min(beyond, away)
                if away < best:
                    best, whose = away, s
            least_yet[c] = beyond - radius
            if whose < 0:
                continue
            clearances[k], nearest[k], latest[c] = best - radius, whose, whose
            if clearances[k] < least:
                least, likely = clearances[k], c
