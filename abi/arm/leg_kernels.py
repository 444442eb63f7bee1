"""Test whether the paper's arm is clear while its tool moves along a straight segment, a leg.

It works as ``abi.arm.separate_arm_kernels`` does for a curve, but keeps no directions to check
later. The longest pieces of the leg come first, so that a collision shows at one of the first
poses.

Where a capsule passes close to an obstacle, a bound of its motion would split the leg into
thousands of pieces. There a direction n is tried at both ends of the piece, too: between them
n·P(t) is above the lower one less B l²/8, l being the length of the piece and B a bound of the
second derivative of P (:mod:`abi.arm.pose_kernels`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable

from abi.arm.direction_kernels import NO_DIRECTION, is_separated, keep_direction
from abi.arm.mask_kernels import touched_row
from abi.arm.pose_kernels import (
    CAPSULE,
    NO_ARM,
    ArmNumbers,
    ArmTable,
    Pose,
    Rates,
    bend_near,
    capsule_ends,
    capsule_share,
    limits_hold_near,
    pose_of,
    rates_near,
    reaches,
    shoulder_holds,
)
from abi.arm.separate_arm_kernels import moving_capsule
from abi.arm.separate_pairs_kernels import ALLOWANCE, FINEST, Moving
from abi.arm.surroundings_kernels import (
    NO_OBSTACLES,
    Obstacles,
    add_pairs_within,
    between_boxes,
    is_solid,
    judged,
    open_box,
)
from abi.arrays import BoolArray, FloatArray, IntArray
from abi.clearance.separation_kernels import CERTIFIED, REFUTED, UNDECIDED
from abi.compilation.borrowed import borrowed, held
from abi.compiled import FLOATS, NEW_FLAGS, compiled
from abi.obstacles.primitive_kernels import axes_of, centre_of, core_of, in_body, in_world, support
from abi.obstacles.triangle_mesh.closest_point_kernels import DEPTH
from abi.obstacles.vector_kernels import Vec3, axpy, distance, dot, sub, vec3_at

MOST_TRIES = 20_000
"""Largest number of tries to prove a leg clear, before it counts as shut."""


_LOOKS = (2, 4, 8)
"""Parts of a leg at whose ends it is seen whether what was touched last is touched again."""


class ArmLegs(NamedTuple):
    """Arm and surroundings on the legs of its tool.

    Attributes:
        table: the arm.
        around: what to keep clear of.
        extensions: least and greatest q5, [unit].
        most_tries: of a capsule and an obstacle, to prove a leg; those far away do not count.
    """

    table: ArmTable
    around: Obstacles
    extensions: tuple[float, float]
    most_tries: int


class Touched(NamedTuple):
    """Last contact of the arm, on a leg that was not clear: on the next leg it often recurs.

    Attributes:
        pair: (1,) capsule times number of obstacles, plus obstacle; -1 at first.
        waiting: room for ``DEPTH`` rows.
    """

    pair: IntArray
    waiting: IntArray


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


NO_LEGS = ArmLegs(NO_ARM, NO_OBSTACLES, (0.0, 0.0), MOST_TRIES)
"""Example for the compiler."""


@register_jitable(forceinline=True)
def _judged_on(legs: ArmLegs, s: int, capsule: Moving, piece: _Piece) -> tuple[int, Vec3]:
    """Check if a capsule is CERTIFIED clear of row s on a piece, REFUTED in its middle, or neither.

    Args:
        legs: what to keep clear of.
        s: the row.
        capsule: in the middle.
        piece: the piece.

    Returns:
        That, and the direction that separates it.
    """
    around = legs.around
    a, b = capsule.first, capsule.last
    need = capsule.radius + around.margins[s]
    near, far = need - piece.allowance, need + piece.allowance + capsule.way
    if s == len(around.margins) - 1:
        gap, way = min(a[2], b[2]) - around.floor, (0.0, 0.0, 1.0)
        if gap > far:
            return CERTIFIED, way
        return (REFUTED if gap < near else UNDECIDED), way
    gap, way = between_boxes(around.primitives, s, a, b)
    if gap > far:
        return CERTIFIED, way
    enough = min(far, need + piece.allowance + _bow(legs, capsule.number, piece))
    axes, core = axes_of(around.primitives, s), core_of(around.primitives, s)
    centre = centre_of(around.primitives, s)
    p, d = in_body(axes, sub(a, centre)), in_body(axes, sub(b, a))
    outcome, gap, way = judged(core, p, d, near, enough)
    there = in_world(axes, way)
    if outcome != CERTIFIED or gap > far:
        return outcome, there
    reached = support(core, way) + dot(there, centre)
    if reached + around.margins[s] < _level(legs, capsule, piece, there):
        return CERTIFIED, there
    return UNDECIDED, there


@register_jitable(forceinline=True)
def _bow(legs: ArmLegs, c: int, piece: _Piece) -> float:
    """Largest bow of capsule c between the ends of a piece, [unit]; inf if unbounded."""
    if math.isinf(piece.bend):
        return math.inf
    arm, capsules = legs.table
    bow: float = piece.bend * capsule_share(arm, piece.first.forearm, capsules, c)
    return bow


@register_jitable(forceinline=True)
def _level(legs: ArmLegs, capsule: Moving, piece: _Piece, way: Vec3) -> float:
    """Level of a :class:`Direction` that is to separate a capsule all along a piece, [unit]."""
    arm, capsules = legs.table
    level = min(dot(way, capsule.first), dot(way, capsule.last)) - capsule.way
    bow = _bow(legs, capsule.number, piece)
    if bow < capsule.way:
        a, b = capsule_ends(arm, piece.first, capsules, capsule.number)
        c, d = capsule_ends(arm, piece.last, capsules, capsule.number)
        ends = min(min(dot(way, a), dot(way, b)), min(dot(way, c), dot(way, d)))
        level = max(level, ends - bow)
    return level - capsule.radius - piece.allowance


@register_jitable
def new_touched() -> Touched:
    """Nothing touched yet."""
    return Touched(np.full(1, -1, np.int32), np.empty(DEPTH, np.int32))


@register_jitable
def _touches_again(legs: ArmLegs, touched: Touched, first: Vec3, last: Vec3) -> bool:
    """Check if the capsule that touched an obstacle last touches it at places of a leg."""
    (arm, capsules), around, (low, high), _ = legs
    count = len(around.margins)
    c, s = touched.pair[0] // count, touched.pair[0] % count
    if touched.pair[0] < 0 or s == count - 1:
        return False
    root = s
    if around.meshes[s] >= 0:
        for k in range(len(around.outer)):
            if around.meshes[around.outer[k]] == around.meshes[s]:
                root = int(around.outer[k])
    way, forearm = sub(last, first), arm.forearm + (low + high) / 2
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


@register_jitable(forceinline=True)
def _rates_near(arm: ArmNumbers, pose: Pose, way: float, slid: float) -> tuple[Rates, bool]:
    """Rates near a pose, and whether they are finite and the arm keeps its limits there."""
    rates = rates_near(arm, pose, way, slid)
    return rates, not math.isinf(rates.elbow) and limits_hold_near(arm, pose, rates, way, slid)


@register_jitable
def _near_pairs(legs: ArmLegs, middle: Vec3, farthest: float) -> list[int]:
    """Pairs of a capsule and a row that boxes do not keep clear.

    Args:
        legs: what to keep clear of.
        middle: place of the tool, [unit], world.
        farthest: distance of the tool from there, at most, [unit].

    Returns:
        Capsules times number of obstacles, plus obstacle, of what ``around`` asks for.
    """
    (arm, capsules), around, (low, high), _ = legs
    forearm, slid = arm.forearm + (low + high) / 2, (high - low) / 2
    pairs = [0]
    pairs.clear()
    if not reaches(arm, middle, forearm):
        return pairs
    pose = pose_of(arm, middle, forearm)
    rates, bounded = _rates_near(arm, pose, farthest, slid)
    for c in range(len(capsules) // CAPSULE):
        capsule = moving_capsule(arm, capsules, c, pose, rates, (farthest, slid))
        far = math.inf
        if bounded:
            far = capsule.radius + capsule.way + ALLOWANCE * around.size * (1 + rates.slide)
        add_pairs_within(around, c, (capsule.first, capsule.last), far, pairs)
    return pairs


@register_jitable
def arm_is_clear(legs: ArmLegs, touched: Touched, first: Vec3, last: Vec3) -> bool:
    """Check whether it is proven that the arm keeps clear from one place of the tool to another.

    Args:
        legs: what to keep clear of.
        touched: what it touched last; written.
        first, last: places of the tool, [unit], world.
    """
    if _touches_again(legs, touched, first, last):
        return False
    (arm, capsules), around, (low, high), most_tries = legs
    count = len(around.margins)
    forearm, slid = arm.forearm + (low + high) / 2, (high - low) / 2
    length, way = distance(first, last), sub(last, first)
    candidates = _near_pairs(legs, axpy(0.5, way, first), (1 + 2.0**-40) * 0.5 * length)
    pending, at, tries, work = [(0.0, 1.0, 0, len(candidates))], 0, 0, [0]
    latest = [NO_DIRECTION]
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
        rates, bounded = _rates_near(arm, pose, farthest, slid)
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
        latest.clear()
        left, met = len(candidates), -1
        for i in range(lowest, highest):
            work.clear()
            work.append(candidates[i])
            while len(work) > 0:
                pair = work.pop()
                s = pair % count
                if pair // count != capsule.number:
                    capsule = moving_capsule(
                        arm, capsules, pair // count, pose, rates, (farthest, slid)
                    )
                    latest.clear()
                    met = -1
                if is_separated(around, s, latest):
                    continue
                if met >= 0 and around.meshes[s] == met:
                    candidates.append(pair)
                    continue
                tries += 1
                outcome, away = _judged_on(legs, s, capsule, piece)
                if outcome == REFUTED and is_solid(around, pair):
                    touched.pair[0] = pair
                    return False
                if bounded and outcome == CERTIFIED:
                    if around.meshes[s] >= 0:
                        level = _level(legs, capsule, piece, away)
                        keep_direction(latest, away, level, around.meshes[s])
                elif not open_box(around, pair, capsule.way, (capsule.first, capsule.last), work):
                    candidates.append(pair)
                    # the piece is halved anyhow: the rest of the mesh is as good tried there
                    met = around.meshes[s] + 0
        if len(candidates) == left:
            continue
        if tries > most_tries or farthest < FINEST * around.size:
            return False
        pending.append((start, (start + end) / 2, left, len(candidates)))
        pending.append(((start + end) / 2, end, left, len(candidates)))
    return True


@compiled(example=(FLOATS, NO_LEGS, NEW_FLAGS))
def clear_legs(points: FloatArray, legs: ArmLegs, clear: BoolArray) -> None:
    """Flag the legs of a polyline on which it is proven that the arm keeps clear.

    Args:
        points: its vertices, flat (3 k,), k >= 2, [unit], world.
        legs: what the arm is to keep clear of.
        clear: (k - 1,); written.
    """
    own = new_touched()
    touched = borrowed(own)
    for k in range(len(clear)):
        clear[k] = arm_is_clear(legs, touched, vec3_at(points, 3 * k), vec3_at(points, 3 * k + 3))
    held(own)
