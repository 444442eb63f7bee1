"""Whether an arm is clear while its tool runs straight from one place to another.

As ``abi.arm.separate_arm_kernels`` decides it of a curve, without directions that can be checked.
Pieces of the leg come the longest first: what is not clear shows at one of the first poses.

Where a capsule comes along an obstacle, near to it, a bound of its way would part the leg in
thousands of pieces. There a direction n is tried at both ends of the piece, too: between them
n·P(t) is above the lower one less B l²/8, l being the length of the piece and B a bound of the
second derivative of P (:mod:`abi.arm.pose_kernels`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from numba.extending import register_jitable

from abi.arm.pose_kernels import (
    NO_ARM,
    ArmTable,
    Pose,
    bend_near,
    capsule_ends,
    capsule_share,
    limits_hold_near,
    pose_of,
    rates_near,
    reaches,
    shoulder_holds,
)
from abi.arm.separate_arm_kernels import ALLOWANCE, FINEST, Moving, moving_capsule
from abi.arm.surroundings_kernels import (
    NO_OBSTACLES,
    Obstacles,
    between_boxes,
    is_solid,
    judged,
    open_box,
    support,
)
from abi.arrays import BoolArray, FloatArray, IntArray
from abi.clearance.separation_kernels import CERTIFIED, REFUTED, UNDECIDED
from abi.compiled import FLOATS, IDS, NEW_FLAGS, compiled
from abi.obstacles.primitive_kernels import axes_of, centre_of, core_of, in_body, in_world
from abi.obstacles.vector_kernels import Vec3, axpy, distance, dot, sub, vec3_at

MOST_TRIES = 20_000
"""To prove a leg clear, before it counts as shut."""


class ArmLegs(NamedTuple):
    """Arm and surroundings on the legs of its tool.

    Attributes:
        table: the arm.
        around: what to keep clear of.
        pairs: capsules times number of obstacles, plus obstacle, that ``around`` asks for (p,).
        extensions: least and greatest q5, [unit].
        most_tries: of a capsule and an obstacle, to prove a leg.
    """

    table: ArmTable
    around: Obstacles
    pairs: IntArray
    extensions: tuple[float, float]
    most_tries: int


class _Piece(NamedTuple):
    """Poses of the arm on a piece of a leg.

    Attributes:
        first, last: at its ends.
        bend: bound of the elbow's second derivative, times l²/8, [unit]; inf where there is none.
        allowance: for rounding, [unit].
    """

    first: Pose
    last: Pose
    bend: float
    allowance: float


NO_LEGS = ArmLegs(NO_ARM, NO_OBSTACLES, IDS, (0.0, 0.0), MOST_TRIES)
"""Example."""


@register_jitable
def _judged_on(legs: ArmLegs, s: int, capsule: Moving, piece: _Piece) -> int:
    """Whether a capsule is CERTIFIED clear of row s on a piece, REFUTED in its middle, or neither.

    Args:
        legs: what to keep clear of.
        s: the row.
        capsule: in the middle.
        piece: the piece.
    """
    (arm, capsules), around = legs.table, legs.around
    a, b = capsule.first, capsule.last
    need = capsule.radius + around.margins[s]
    near, far = need - piece.allowance, need + piece.allowance + capsule.way
    if s == len(around.margins) - 1:
        gap = min(a[2], b[2]) - around.floor
        if gap > far:
            return CERTIFIED
        return REFUTED if gap < near else UNDECIDED
    gap, way = between_boxes(around.primitives, s, a, b)
    if gap > far:
        return CERTIFIED
    bow = piece.bend * capsule_share(arm, piece.first.forearm, capsules, capsule.number)
    enough = min(far, need + piece.allowance + bow)
    axes, core = axes_of(around.primitives, s), core_of(around.primitives, s)
    centre = centre_of(around.primitives, s)
    p, d = in_body(axes, sub(a, centre)), in_body(axes, sub(b, a))
    outcome, gap, way = judged(core, p, d, near, enough)
    if outcome != CERTIFIED or gap > far:
        return outcome
    there = in_world(axes, way)
    level = support(core, way) + dot(there, centre) + enough
    for pose in (piece.first, piece.last):
        a, b = capsule_ends(arm, pose, capsules, capsule.number)
        if not min(dot(there, a), dot(there, b)) > level:
            return UNDECIDED
    return CERTIFIED


@register_jitable
def arm_is_clear(legs: ArmLegs, first: Vec3, last: Vec3) -> bool:
    """Whether it is proven that the arm keeps clear from one place of the tool to another."""
    (arm, capsules), around, pairs, (low, high), most_tries = legs
    count = len(around.margins)
    forearm, slid = arm.forearm + (low + high) / 2, (high - low) / 2
    length, way = distance(first, last), sub(last, first)
    candidates = [int(pair) for pair in pairs]
    if len(candidates) == 0:
        return True
    pending, at, tries, work = [(0.0, 1.0, 0, len(candidates))], 0, 0, [0]
    while at < len(pending):
        start, end, lowest, highest = pending[at]
        at += 1
        middle = axpy((start + end) / 2, way, first)
        farthest = (1 + 2.0**-40) * (end - start) / 2 * length
        if not reaches(arm, middle, forearm):
            return False
        pose = pose_of(arm, middle, forearm)
        if not shoulder_holds(arm, pose):
            return False
        rates = rates_near(arm, pose, farthest, slid)
        bounded = not math.isinf(rates.elbow)
        bounded = bounded and limits_hold_near(arm, pose, rates, farthest, slid)
        allowance = ALLOWANCE * around.size
        piece = _Piece(pose, pose, math.inf, allowance)
        if bounded:
            allowance *= 1 + rates.slide
            piece = _Piece(pose, pose, math.inf, allowance)
            if slid == 0:
                a = pose_of(arm, axpy(start, way, first), forearm)
                b = pose_of(arm, axpy(end, way, first), forearm)
                bend = bend_near(arm, pose, rates, farthest) * farthest * farthest / 2
                piece = _Piece(a, b, bend, allowance)
        capsule = moving_capsule(arm, capsules, 0, pose, rates, (farthest, slid))
        left = len(candidates)
        for i in range(lowest, highest):
            work.clear()
            work.append(candidates[i])
            while len(work) > 0:
                pair = work.pop()
                tries += 1
                if pair // count != capsule.number:
                    capsule = moving_capsule(
                        arm, capsules, pair // count, pose, rates, (farthest, slid)
                    )
                outcome = _judged_on(legs, pair % count, capsule, piece)
                if outcome == REFUTED and is_solid(around, pair):
                    return False
                if not (bounded and outcome == CERTIFIED) and not open_box(
                    around, pair, capsule.way, (capsule.first, capsule.last), work
                ):
                    candidates.append(pair)
        if len(candidates) == left:
            continue
        if tries > most_tries or farthest < FINEST * around.size:
            return False
        pending.append((start, (start + end) / 2, left, len(candidates)))
        pending.append(((start + end) / 2, end, left, len(candidates)))
    return True


@compiled(example=(FLOATS, NO_LEGS, NEW_FLAGS))
def clear_legs(points: FloatArray, legs: ArmLegs, clear: BoolArray) -> None:
    """On which legs of a polyline it is proven that the arm keeps clear.

    Args:
        points: its vertices, flat (3 k,), k >= 2, [unit], world.
        legs: what the arm is to keep clear of.
        clear: (k - 1,); written.
    """
    for k in range(len(clear)):
        clear[k] = arm_is_clear(legs, vec3_at(points, 3 * k), vec3_at(points, 3 * k + 3))
