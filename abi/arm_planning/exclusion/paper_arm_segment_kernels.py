"""Test whether the paper's arm is clear while its tool moves along a straight segment.

It works as ``abi.arm_planning.certificates.separate_paper_arm_kernels`` does for a curve, but keeps
no directions to check later. The longest pieces of the segment come first, so that a collision
shows at one of the first poses.

Where a capsule passes close to an obstacle, a bound of its motion would split the segment into
thousands of pieces. There a direction n is tried at both ends of the piece, too: between them
n·P(t) is above the lower one less B l²/8, l being the length of the piece and B a bound of the
second derivative of P (:mod:`abi.robot.paper_arm.pose_kernels`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from abi.arm_planning.certificates.direction_kernels import NO_DIRECTION
from abi.arm_planning.certificates.separate_pairs_kernels import (
    ALLOWANCE,
    FINEST,
    LONGER,
    ProofLists,
    Span,
    as_found,
    separate_pairs,
)
from abi.arm_planning.certificates.separate_paper_arm_kernels import (
    PoseNeighbourhood,
    allowance_of,
    capsule_of,
    level_at_ends,
    neighbourhood_of,
)
from abi.arm_planning.exclusion.paper_arm_mask_kernels import touched_row
from abi.arm_planning.world.collision_world_kernels import NO_OBSTACLES, Obstacles, add_pairs_within
from abi.arrays import BoolArray, FloatArray, IntArray
from abi.clearance.separation_kernels import NO_PLANE, REFUTED
from abi.compilation.borrowed import borrowed, held
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, NEW_FLAGS, compiled
from abi.obstacles.triangle_mesh.closest_point_kernels import DEPTH
from abi.obstacles.vector_kernels import Vec3, axpy, distance, sub, vec3_at
from abi.robot.paper_arm.pose_kernels import (
    CAPSULE,
    NO_ARM,
    ArmTable,
    bend_near,
    capsule_ends,
    pose_of,
    reaches,
    shoulder_holds,
)

MOST_TRIES = 20_000
"""Largest number of tries to prove a segment clear, before it counts as shut."""


_LOOKS = (2, 4, 8)
"""Parts of a segment at whose ends it is seen whether what was touched last is touched again."""


class ArmSegments(NamedTuple):
    """Arm and surroundings on the segments of its tool.

    Attributes:
        table: the arm.
        around: what to keep clear of.
        forearm: middle of a6, [unit].
        slide: how much longer or shorter it may be, [unit].
        most_tries: of a capsule and an obstacle, to prove a segment; those far away do not count.
    """

    table: ArmTable
    around: Obstacles
    forearm: float
    slide: float
    most_tries: int


class Touched(NamedTuple):
    """Last contact of the arm, on a segment that was not clear: it often recurs on the next.

    Attributes:
        pair: (1,) capsule times number of obstacles, plus obstacle; -1 at first.
        waiting: room for ``DEPTH`` rows.
    """

    pair: IntArray
    waiting: IntArray


NO_SEGMENTS = ArmSegments(NO_ARM, NO_OBSTACLES, 1.0, 0.0, MOST_TRIES)
"""Example for the compiler."""


@jitable
def new_touched() -> Touched:
    """Nothing touched yet."""
    return Touched(np.full(1, -1, np.int32), np.empty(DEPTH, np.int32))


@jitable
def _touches_again(segments: ArmSegments, touched: Touched, first: Vec3, last: Vec3) -> bool:
    """Check if the capsule that touched an obstacle last touches it at places of a segment."""
    (arm, capsules), around, forearm, _, _ = segments
    count = len(around.margins)
    c, s = touched.pair[0] // count, touched.pair[0] % count
    if touched.pair[0] < 0 or s == count - 1:
        return False
    root = s
    if around.meshes[s] >= 0:
        for k in range(len(around.outer)):
            if around.meshes[around.outer[k]] == around.meshes[s]:
                root = int(around.outer[k])
    way = sub(last, first)
    need = capsules[CAPSULE * c + 3] + around.margins[s] - ALLOWANCE * around.size
    for parts in _LOOKS:
        for k in range(1, parts, 2):
            tool = axpy(k / parts, way, first)
            if not reaches(arm, tool, forearm):
                return True
            a, b = capsule_ends(arm, pose_of(arm, tool, forearm), capsules, c)
            row = touched_row(around, root, a, b, need, s, touched.waiting)
            if row >= 0:
                touched.pair[0] = c * count + row
                return True
    return False


@jitable
def arm_is_clear(segments: ArmSegments, touched: Touched, first: Vec3, last: Vec3) -> bool:
    """Check whether it is proven that the arm keeps clear from one place of the tool to another.

    Args:
        segments: what to keep clear of.
        touched: what it touched last; written.
        first, last: places of the tool, [unit], world.
    """
    if _touches_again(segments, touched, first, last):
        return False
    (arm, capsules), around, forearm, slid, most_tries = segments
    length, way = distance(first, last), sub(last, first)
    pending, at, candidates, tries, work = [(0.0, 1.0, 0, 0)], 0, [0], 0, [0]
    candidates.clear()
    lists = ProofLists([NO_PLANE], candidates, work, [NO_DIRECTION])
    while at < len(pending):
        start, end, lowest, highest = pending[at]
        at += 1
        middle = axpy((start + end) / 2, way, first)
        farthest = LONGER * (end - start) / 2 * length
        if not reaches(arm, middle, forearm):
            return False
        pose = pose_of(arm, middle, forearm)
        if not shoulder_holds(arm, pose):
            return False
        neighbourhood, bounded = neighbourhood_of(arm, pose, (farthest, slid))
        if bounded and slid == 0:
            a = pose_of(arm, axpy(start, way, first), forearm)
            b = pose_of(arm, axpy(end, way, first), forearm)
            bend = bend_near(arm, pose, neighbourhood.rates, farthest) * farthest * farthest / 2
            neighbourhood = PoseNeighbourhood(
                pose, neighbourhood.rates, neighbourhood.ways, a, b, bend
            )
        allowance = allowance_of(around, neighbourhood.rates)
        if at == 1:  # the whole segment: what boxes do not keep clear of it
            for c in range(len(capsules) // CAPSULE):
                capsule, far = capsule_of((segments.table, neighbourhood), c), math.inf
                if bounded:
                    far = capsule.radius + capsule.way + allowance
                add_pairs_within(around, c, (capsule.first, capsule.last), far, candidates)
            highest = len(candidates)
        span = Span(start, end, (start + end) / 2, allowance, bounded, False)
        work.clear()
        lists.latest.clear()
        left = len(candidates)
        for i in range(highest - 1, lowest - 1, -1):
            work.append(candidates[i])
        outcome, pair, _, tried, _ = separate_pairs(
            around,
            span,
            lists,
            capsule_of,
            level_at_ends,
            as_found,
            (segments.table, neighbourhood),
        )
        if outcome == REFUTED:
            touched.pair[0] = pair
            return False
        tries += tried[0]
        if len(candidates) == left:
            continue
        if tries > most_tries or farthest < FINEST * around.size:
            return False
        pending.append((start, (start + end) / 2, left, len(candidates)))
        pending.append(((start + end) / 2, end, left, len(candidates)))
    return True


@compiled(example=(FLOATS, NO_SEGMENTS, NEW_FLAGS))
def clear_segments(points: FloatArray, segments: ArmSegments, clear: BoolArray) -> None:
    """Flag the segments of a polyline on which it is proven that the arm keeps clear.

    Args:
        points: its vertices, flat (3 k,), k >= 2, [unit], world.
        segments: what the arm is to keep clear of.
        clear: (k - 1,); written.
    """
    own = new_touched()
    touched = borrowed(own)
    for k in range(len(clear)):
        clear[k] = arm_is_clear(
            segments, touched, vec3_at(points, 3 * k), vec3_at(points, 3 * k + 3)
        )
    held(own)
