"""Certificates of the paper's arm: directions that separate its capsules from its surroundings.

See ``abi.arm.arm_certificate`` for what a direction proves, ``abi.arm.pose_kernels`` for the
numbers of an arm and its capsules, ``abi.clearance.separation_kernels`` for pieces and planes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from numba.extending import register_jitable

from abi.arm.direction_kernels import (
    NO_DIRECTION,
    Direction,
    is_separated,
    keep_direction,
)
from abi.arm.pose_kernels import (
    CAPSULE,
    NO_ARM,
    ArmNumbers,
    ArmTable,
    Pose,
    Rates,
    capsule_ends,
    capsule_rates,
    limits_hold_near,
    pose_of,
    rates_near,
    reaches,
    shoulder_holds,
)
from abi.arm.surroundings_kernels import (
    NO_OBSTACLES,
    Obstacles,
    add_asked_pairs,
    between_boxes,
    is_solid,
    judged,
    open_box,
)
from abi.arrays import FloatArray
from abi.clearance.separation_kernels import (
    CERTIFIED,
    MOST_HALVINGS,
    NO_PLANE,
    REFUTED,
    UNDECIDED,
    Outcome,
    Piece,
    Plane,
    halves_of,
    table_of,
)
from abi.compiled import FLOATS, NEW_FLOATS, compiled
from abi.obstacles.primitive_kernels import axes_of, centre_of, core_of, in_body, in_world
from abi.obstacles.vector_kernels import Vec3, distance, dot, sub, vec3_at

UNREACHED = 3
"""Outcome of a piece with a place that the arm does not reach within its limits."""

FINEST = 2.0**-26
"""Part of the largest coordinate: smaller pieces are not halved."""
ALLOWANCE = 2.0**-40
"""Part of the largest coordinate, for each place of the elbow computed."""


class Slide(NamedTuple):
    """Bounds of q5 along the curve, which does not fall.

    Attributes:
        parameters: increasing, from the curve's first to its last (m,).
        low, high: bounds at each of them (m,), [unit].
    """

    parameters: FloatArray
    low: FloatArray
    high: FloatArray


NO_SLIDE = Slide(FLOATS, FLOATS, FLOATS)
"""Example for the compiler."""


@register_jitable(forceinline=True)
def _slide_within(slide: Slide, start: float, end: float) -> tuple[float, float]:
    """Bounds of q5 from one parameter to another."""
    last = len(slide.parameters) - 1
    low, high = 0, last
    while low < high:  # the last parameter not after the start
        middle = (low + high + 1) // 2
        if slide.parameters[middle] <= start:
            low = middle
        else:
            high = middle - 1
    first = low
    low, high = 0, last
    while low < high:  # the first parameter not before the end
        middle = (low + high) // 2
        if slide.parameters[middle] >= end:
            high = middle
        else:
            low = middle + 1
    return slide.low[first], slide.high[low]


class Moving(NamedTuple):
    """A capsule at a pose, and how far from there it may be.

    Attributes:
        number: of the capsule.
        first, last: ends of its segment, [unit], world.
        radius: [unit].
        way: of every point of it, at most, [unit].
    """

    number: int
    first: Vec3
    last: Vec3
    radius: float
    way: float


@register_jitable(forceinline=True)
def moving_capsule(
    arm: ArmNumbers,
    capsules: FloatArray,
    c: int,
    pose: Pose,
    rates: Rates,
    ways: tuple[float, float],
) -> Moving:
    """Capsule c near a pose.

    Args:
        arm: its numbers.
        capsules: theirs.
        c: number of the capsule.
        pose: the middle one.
        rates: of the elbow.
        ways: of the tool and the slide, at most, [unit].
    """
    a, b = capsule_ends(arm, pose, capsules, c)
    by_tool, by_slide = capsule_rates(arm, rates, capsules, c)
    way = by_tool * ways[0] + by_slide * ways[1]
    return Moving(c, a, b, capsules[CAPSULE * c + 3], way)


@register_jitable(forceinline=True)
def _allowance(around: Obstacles, rates: Rates) -> float:
    """Room for rounding, [unit]."""
    return ALLOWANCE * around.size * (1.0 if math.isinf(rates.slide) else 1 + rates.slide)


@register_jitable(forceinline=True)
def separating_gap(around: Obstacles, capsule: Moving, rates: Rates) -> float:
    """Gap, less a margin, between a capsule's segment and what it is clear of all the way."""
    return capsule.radius + _allowance(around, rates) + capsule.way


@register_jitable(forceinline=True)
def separates(around: Obstacles, s: int, capsule: Moving, rates: Rates) -> tuple[int, float, Vec3]:
    """Whether a direction keeps a capsule clear of an obstacle near a pose.

    Args:
        around: the obstacles.
        s: number of the obstacle.
        capsule: near the pose.
        rates: of the elbow.

    Returns:
        CERTIFIED, REFUTED at the pose or UNDECIDED; the distance there; the direction.
    """
    a, b, radius = capsule.first, capsule.last, capsule.radius
    far = around.margins[s] + separating_gap(around, capsule, rates)
    near = radius + around.margins[s] - _allowance(around, rates)
    if s == len(around.margins) - 1:
        gap, way = min(a[2], b[2]) - around.floor, (0.0, 0.0, 1.0)
        if gap > far:
            return CERTIFIED, gap, way
        return (REFUTED if gap < near else UNDECIDED), gap - radius, way
    gap, way = between_boxes(around.primitives, s, a, b)
    if gap > far:
        return CERTIFIED, math.inf, way
    axes = axes_of(around.primitives, s)
    p = in_body(axes, sub(a, centre_of(around.primitives, s)))
    d = in_body(axes, sub(b, a))
    outcome, away, way = judged(core_of(around.primitives, s), p, d, near, far)
    return outcome, away - radius, in_world(axes, way)


class _Stance(NamedTuple):
    """The arm at a piece's middle, and how far from there it may be on the piece.

    Attributes:
        pose: there.
        rates: of the elbow.
        ways: of the tool and the slide, at most, [unit].
        bounded: whether it keeps its limits on the piece, and the rates are finite.
    """

    pose: Pose
    rates: Rates
    ways: tuple[float, float]
    bounded: bool


class _Room(NamedTuple):
    """Lists that a proof fills.

    Attributes:
        planes: the directions found.
        candidates: pairs, those of every pending piece, a piece's own together.
        work: pairs of the present piece, the next one last.
        latest: directions that may serve for the next pair, too.
    """

    planes: list[Plane]
    candidates: list[int]
    work: list[int]
    latest: list[Direction]


@register_jitable(forceinline=True)
def _farthest(points: FloatArray, piece: Piece, middle: Vec3) -> float:
    """Distance of a piece from its middle, at most."""
    farthest = 0.0
    for i in range(3 * piece.first, 3 * piece.last, 3):
        farthest = max(farthest, distance(middle, vec3_at(points, i)))
    return farthest * (1 + 2.0**-40)


@register_jitable(forceinline=True)
def _separate_pairs(
    table: ArmTable, around: Obstacles, piece: Piece, at: float, stance: _Stance, room: _Room
) -> tuple[int, int, float, int]:
    """Separate the pairs of ``room.work`` on a piece; those that are left become candidates.

    Returns:
        REFUTED or UNDECIDED; the pair and the distance that refute it; how many were tried.
    """
    (arm, capsules), count = table, len(around.margins)
    planes, candidates, work, latest = room
    capsule = moving_capsule(arm, capsules, 0, stance.pose, stance.rates, stance.ways)
    left, tries = -1, 0
    while len(work) > 0:
        pair = work.pop()
        tries += 1
        s = pair % count
        if pair // count != capsule.number:
            number = pair // count
            capsule = moving_capsule(arm, capsules, number, stance.pose, stance.rates, stance.ways)
            latest.clear()
            left = -1
        if is_separated(around, s, latest):
            continue
        if left >= 0 and around.meshes[s] == left:
            candidates.append(pair)
            continue
        outcome, away, way = separates(around, s, capsule, stance.rates)
        if outcome == REFUTED and is_solid(around, pair):
            return REFUTED, pair, away, tries
        if stance.bounded and outcome == CERTIFIED:
            planes.append(Plane(piece.start, piece.end, pair, way, at))
            if around.meshes[s] >= 0:
                level = min(dot(way, capsule.first), dot(way, capsule.last))
                level -= separating_gap(around, capsule, stance.rates)
                keep_direction(latest, way, level, around.meshes[s])
        elif not open_box(around, pair, capsule.way, (capsule.first, capsule.last), work):
            candidates.append(pair)
            # the piece is halved anyhow: the rest of the mesh is as good tried on its halves
            left = around.meshes[s] + 0
    return UNDECIDED, -1, 0.0, tries


@compiled(example=(FLOATS, FLOATS, NEW_FLOATS, NO_ARM, NO_OBSTACLES, NO_SLIDE, 9))
def separate_arm(
    world: FloatArray,
    breaks: FloatArray,
    points: FloatArray,
    table: ArmTable,
    around: Obstacles,
    slide: Slide,
    most_tries: int,
) -> Outcome:
    """Separate every capsule from every obstacle while the tool runs along a curve.

    Where that is proven, q2 and q3 keep their limits, too. A piece of the curve carries the pairs
    that its parents were not separated in; what is left of them is tried on both halves.

    Args:
        world: Bézier points of the s polynomials, flat (3 s (degree + 1),), world frame.
        breaks: parameters between them (s + 1,).
        points: room for the same and the halves, flat (3 (s + 2 MOST_HALVINGS + 2) (degree + 1),).
        table: the arm.
        around: what to keep clear of.
        slide: bounds of q5.
        most_tries: tries it may take.

    Returns:
        As for curves; a plane's obstacle is the number of its pair, and its level the parameter of
        the pose.
    """
    arm, capsules = table
    spans = len(breaks) - 1
    width = len(world) // (3 * spans)
    for i in range(len(world)):
        points[i] = world[i]
    planes, candidates, work, tries = [NO_PLANE], [0], [0], 0
    latest = [NO_DIRECTION]
    room = _Room(planes, candidates, work, latest)
    candidates.clear()
    add_asked_pairs(around, len(capsules) // CAPSULE, candidates)
    if len(candidates) == 0:
        return CERTIFIED, 0.0, -1, math.inf, table_of(planes)
    whole = Piece(0, spans * width, 0, breaks[0], breaks[spans])
    pending = [(whole, 0, len(candidates))]
    while len(pending) > 0:
        piece, lowest, highest = pending.pop()
        while len(candidates) > highest:
            candidates.pop()
        at, ahead, behind = halves_of(points, piece, breaks, width)
        middle = vec3_at(points, 3 * behind.first)
        low, high = _slide_within(slide, piece.start, piece.end)
        forearm, slid = arm.forearm + (low + high) / 2, (high - low) / 2
        farthest = _farthest(points, piece, middle)
        if not reaches(arm, middle, forearm):
            return UNREACHED, at, -1, 0.0, table_of(planes)
        pose = pose_of(arm, middle, forearm)
        if not shoulder_holds(arm, pose):
            return UNREACHED, at, -1, 0.0, table_of(planes)
        rates = rates_near(arm, pose, farthest, slid)
        bounded = not math.isinf(rates.elbow)
        bounded = bounded and limits_hold_near(arm, pose, rates, farthest, slid)
        stance = _Stance(pose, rates, (farthest, slid), bounded)
        work.clear()
        latest.clear()
        for i in range(highest - 1, lowest - 1, -1):
            work.append(candidates[i])
        outcome, pair, away, tried = _separate_pairs(table, around, piece, at, stance, room)
        tries += tried
        if outcome == REFUTED:
            return REFUTED, at, pair, away, table_of(planes)
        if len(candidates) == highest:
            continue
        run = piece.last - piece.first > width
        final = piece.halvings == MOST_HALVINGS or farthest < FINEST * around.size
        if tries > most_tries or (not run and (final or not piece.start < at < piece.end)):
            return UNDECIDED, at, candidates[len(candidates) - 1], 0.0, table_of(planes)
        pending.append((behind, highest, len(candidates)))
        pending.append((ahead, highest, len(candidates)))
    return CERTIFIED, 0.0, -1, math.inf, table_of(planes)
