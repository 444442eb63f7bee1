"""Certificates of a URDF arm, whose joints move straight from knot to knot.

They are directions that separate its capsules from the surroundings and from each other.
See ``abi.arm.chain_certificate`` for what a direction proves, ``abi.arm.surroundings_kernels``
for the surroundings.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable

from abi.arm.chain_kernels import POSE, TABLE, ChainTable, place_chain
from abi.arm.direction_kernels import NO_DIRECTION, is_separated, keep_direction
from abi.arm.surroundings_kernels import (
    NO_OBSTACLES,
    Obstacles,
    between_boxes,
    box_gap,
    is_solid,
    judged,
    open_box,
)
from abi.arrays import FloatArray, IntArray
from abi.clearance.separation_kernels import (
    CERTIFIED,
    MOST_HALVINGS,
    NO_PLANE,
    REFUTED,
    UNDECIDED,
    Outcome,
    Plane,
    table_of,
)
from abi.compiled import FLOATS, IDS, compiled
from abi.obstacles.primitive_kernels import axes_of, centre_of, core_of, in_body, in_world
from abi.obstacles.vector_kernels import Vec3, axpy, dot, sub, vec3_at

_ALLOWANCE = 2.0**-40  # of the largest coordinate, for each place computed
_WIDER = 1 + 2.0**-28  # of ways: the check takes the chain's matrices for rotations only nearly
_FINEST = 2.0**-26  # of the largest coordinate: pieces with smaller ways are not halved


class Bodies(NamedTuple):
    """Capsules of a chain with n coordinates.

    Attributes:
        frames: joint that moves each, -1 where it stands still, (c,).
        ends: of their segments in that frame, or in the world where they stand still, flat
            (6 c,), [m].
        radii: (c,), [unit].
        levers: bound of each one's way for one of each coordinate, flat (c n,), [unit].
        pairs: capsules that are to keep apart, flat (2 p,).
        pair_levers: the same of the second's way beside the first, flat (p n,), [unit].
        scale: one metre in [unit].
    """

    frames: IntArray
    ends: FloatArray
    radii: FloatArray
    levers: FloatArray
    pairs: IntArray
    pair_levers: FloatArray
    scale: float


BODIES = Bodies(IDS, FLOATS, FLOATS, FLOATS, IDS, FLOATS, 1.0)
"""Example of capsules."""


class _Stretch(NamedTuple):
    """Joints from one knot, or place between two, to another."""

    start: float
    end: float
    halvings: int


class _Pose(NamedTuple):
    """Pose of a stretch, and room to work it out.

    Attributes:
        joints: coordinates (n,).
        ways: farthest that each goes from there on the stretch (n,).
        ends: of all capsules, flat (6 c,), [unit], world.
        poses: of the joints, flat (12 (m + 1),).
        end: room for coordinates (n,).
    """

    joints: FloatArray
    ways: FloatArray
    ends: FloatArray
    poses: FloatArray
    end: FloatArray


@register_jitable
def _joints_at(knots: FloatArray, at: float, joints: FloatArray) -> None:
    """Write the coordinates at a place between two knots."""
    count = len(joints)
    knot = min(int(at), len(knots) // count - 2)
    share = at - knot
    for j in range(count):
        a, b = knots[knot * count + j], knots[(knot + 1) * count + j]
        joints[j] = a + share * (b - a)


@register_jitable
def _ways_of(
    knots: FloatArray, stretch: _Stretch, joints: FloatArray, end: FloatArray, ways: FloatArray
) -> None:
    """Write how far each coordinate gets from ``joints`` on a stretch; ``end`` is room."""
    count = len(joints)
    for j in range(count):
        ways[j] = 0.0
    for side in range(2):
        _joints_at(knots, stretch.start if side == 0 else stretch.end, end)
        for j in range(count):
            ways[j] = max(ways[j], abs(end[j] - joints[j]))
    for knot in range(int(stretch.start) + 1, math.ceil(stretch.end)):
        for j in range(count):
            ways[j] = max(ways[j], abs(knots[knot * count + j] - joints[j]))


@register_jitable
def place_bodies(
    chain: ChainTable, bodies: Bodies, joints: FloatArray, poses: FloatArray, ends: FloatArray
) -> None:
    """Write both ends of every capsule, flat (6 c,), [unit], world; ``poses`` is room."""
    place_chain(chain, joints, 0, poses)
    for k in range(2 * len(bodies.frames)):
        frame = bodies.frames[k // 2]
        for r in range(3):
            if frame < 0:
                ends[3 * k + r] = bodies.scale * bodies.ends[3 * k + r]
            else:
                at = POSE * frame
                ends[3 * k + r] = bodies.scale * (
                    poses[at + 3 * r] * bodies.ends[3 * k]
                    + poses[at + 3 * r + 1] * bodies.ends[3 * k + 1]
                    + poses[at + 3 * r + 2] * bodies.ends[3 * k + 2]
                    + poses[at + 9 + r]
                )


@register_jitable
def _go_to_middle(
    chain: ChainTable, bodies: Bodies, knots: FloatArray, stretch: _Stretch, pose: _Pose
) -> float:
    """Write the pose in the middle of a stretch, or at a knot near it; its parameter."""
    at = 0.5 * (stretch.start + stretch.end)
    if stretch.end - stretch.start > 1:
        at = 1.0 * math.floor(at)
    joints, ways, ends, poses, end = pose
    _joints_at(knots, at, joints)
    _ways_of(knots, stretch, joints, end, ways)
    place_bodies(chain, bodies, joints, poses, ends)
    return at


@register_jitable
def between_segments(p: Vec3, d: Vec3, q: Vec3, e: Vec3) -> Vec3:
    """Way from the nearest point of p to p + d to that of q to q + e (Ericson, section 5.1.9)."""
    a, b, c = dot(d, d), dot(d, e), dot(e, e)
    r = sub(p, q)
    f, g = dot(d, r), dot(e, r)
    tiny = 1e-300
    best, way = math.inf, (0.0, 0.0, 1.0)
    inner = min(max((b * g - c * f) / max(a * c - b * b, tiny), 0.0), 1.0)
    for s in (inner, 0.0, 1.0, -f / max(a, tiny), (b - f) / max(a, tiny)):
        on_first = min(max(s, 0.0), 1.0)
        on_second = min(max((b * on_first + g) / max(c, tiny), 0.0), 1.0)
        away = sub(axpy(on_second, e, q), axpy(on_first, d, p))
        size = dot(away, away)
        if size < best:
            best, way = size, away
    return way


@register_jitable
def _apart(
    ends: FloatArray, bodies: Bodies, pair: int, ways: FloatArray, allowance: float
) -> tuple[int, float, Vec3, float]:
    """Whether a direction keeps two capsules apart near a pose; as :func:`_separates`."""
    count = len(ways)
    i, j = bodies.pairs[2 * pair], bodies.pairs[2 * pair + 1]
    p, a = vec3_at(ends, 6 * i), vec3_at(ends, 6 * i + 3)
    q, b = vec3_at(ends, 6 * j), vec3_at(ends, 6 * j + 3)
    moves = 0.0
    for k in range(count):
        moves += bodies.pair_levers[pair * count + k] * ways[k]
    moves *= _WIDER
    way = between_segments(p, sub(a, p), q, sub(b, q))
    away = math.sqrt(dot(way, way))
    radii = bodies.radii[i] + bodies.radii[j]
    if away <= radii:
        return REFUTED, away - radii, way, moves
    way = (way[0] / away, way[1] / away, way[2] / away)
    gap = min(dot(way, q), dot(way, b)) - max(dot(way, p), dot(way, a))
    if gap > radii + 2 * allowance + moves:
        return CERTIFIED, away - radii, way, moves
    return UNDECIDED, away - radii, way, moves


@register_jitable(forceinline=True)
def _moves(bodies: Bodies, c: int, ways: FloatArray) -> float:
    """Way of a capsule, at most, where so far goes each coordinate, [unit]."""
    moves = 0.0
    for j in range(len(ways)):
        moves += bodies.levers[c * len(ways) + j] * ways[j]
    return moves * _WIDER


@register_jitable
def _add_pairs(
    bodies: Bodies, around: Obstacles, pose: _Pose, certify: bool, pairs: list[int]
) -> None:
    """Add all pairs; unless it is to ``certify`` not those that boxes keep clear near a pose."""
    count, allowance = len(around.margins), _ALLOWANCE * around.size
    for c in range(len(bodies.frames)):
        a, b = vec3_at(pose.ends, 6 * c), vec3_at(pose.ends, 6 * c + 3)
        reach = bodies.radii[c] + _moves(bodies, c, pose.ways) + allowance
        for k in range(len(around.outer)):
            s = around.outer[k]
            if around.asked[c * count + s] and (
                certify
                or s == count - 1
                or box_gap(around.primitives, s, a, b) <= reach + around.margins[s]
            ):
                pairs.append(c * count + s)
    for own in range(len(bodies.pairs) // 2):
        pairs.append(len(bodies.frames) * count + own)


@register_jitable
def _separates(
    ends: FloatArray, bodies: Bodies, around: Obstacles, pair: int, ways: FloatArray
) -> tuple[int, float, Vec3, float]:
    """Whether a direction keeps a capsule clear of something near a pose.

    Args:
        ends: of all capsules at the pose, [unit], world.
        bodies: the capsules.
        around: the obstacles.
        pair: capsule times number of obstacles, plus obstacle; behind these pairs of capsules.
        ways: of the coordinates from the pose, at most.

    Returns:
        CERTIFIED, REFUTED at the pose or UNDECIDED; the distance there; the direction; the way of
        the capsule at most, [unit].
    """
    count, allowance = len(around.margins), _ALLOWANCE * around.size
    c, s = pair // count, pair % count
    if c >= len(bodies.frames):
        return _apart(ends, bodies, pair - len(bodies.frames) * count, ways, allowance)
    a, b = vec3_at(ends, 6 * c), vec3_at(ends, 6 * c + 3)
    radius, moves = bodies.radii[c], _moves(bodies, c, ways)
    need = radius + around.margins[s] + allowance
    if s == count - 1:
        gap, way = min(a[2], b[2]) - around.floor, (0.0, 0.0, 1.0)
    else:
        gap, way = between_boxes(around.primitives, s, a, b)
        if gap > need + moves:
            return CERTIFIED, math.inf, way, moves
        axes = axes_of(around.primitives, s)
        p = in_body(axes, sub(a, centre_of(around.primitives, s)))
        d = in_body(axes, sub(b, a))
        core = core_of(around.primitives, s)
        outcome, away, way = judged(core, p, d, need - 2 * allowance, need + moves)
        return outcome, away - radius, in_world(axes, way), moves
    if gap > need + moves:
        return CERTIFIED, gap, way, moves
    if gap < need - 2 * allowance:
        return REFUTED, gap - radius, way, moves
    return UNDECIDED, gap - radius, way, moves


@compiled(example=(TABLE, BODIES, FLOATS, NO_OBSTACLES, 9, True))
def separate_chain(
    chain: ChainTable,
    bodies: Bodies,
    knots: FloatArray,
    around: Obstacles,
    most_tries: int,
    certify: bool,
) -> Outcome:
    """Separate every capsule from everything around while the joints go from knot to knot.

    A stretch carries the pairs that its parents were not separated in; what is left of them is
    tried on both halves. Stretches of many knots are halved at a knot.

    Args:
        chain: the chain.
        bodies: its capsules.
        knots: coordinates at m >= 2 knots, flat (m n,).
        around: what to keep clear of.
        most_tries: tries it may take; without ``certify`` those of boxes do not count.
        certify: whether to keep the planes.

    Returns:
        As for curves, the parameter of knot k being k; a plane's obstacle is the number of its
        pair, and its level the parameter of the pose.
    """
    count, rows = len(chain.limits) // 2, len(around.margins)
    ways, ends = np.empty(count), np.empty(6 * len(bodies.frames))
    poses = np.empty(POSE * (len(chain.source) + 1))
    pose = _Pose(np.empty(count), ways, ends, poses, np.empty(count))
    planes, candidates, work, tries = [NO_PLANE], [0], [0], 0
    latest, solid_pairs = [NO_DIRECTION], len(bodies.frames) * rows
    candidates.clear()
    whole = _Stretch(0.0, 1.0 * (len(knots) // count - 1), 0)
    _go_to_middle(chain, bodies, knots, whole, pose)
    _add_pairs(bodies, around, pose, certify, candidates)
    pending = [(whole, 0, len(candidates))]
    while len(pending) > 0:
        stretch, lowest, highest = pending.pop()
        while len(candidates) > highest:
            candidates.pop()
        at = _go_to_middle(chain, bodies, knots, stretch, pose)
        work.clear()
        latest.clear()
        for i in range(highest - 1, lowest - 1, -1):
            work.append(candidates[i])
        farthest, c, left = 0.0, -1, -1
        while len(work) > 0:
            pair = work.pop()
            tries += 1
            of_links = pair >= solid_pairs
            if pair // rows != c:
                c = pair // rows
                latest.clear()
                left = -1
            if not of_links and is_separated(around, pair % rows, latest):
                continue
            if not of_links and left >= 0 and around.meshes[pair % rows] == left:
                candidates.append(pair)
                continue
            outcome, away, way, moves = _separates(ends, bodies, around, pair, ways)
            if outcome == REFUTED and (of_links or is_solid(around, pair)):
                return REFUTED, at, pair, away, table_of(planes)
            if outcome == CERTIFIED:
                if certify:
                    planes.append(Plane(stretch.start, stretch.end, pair, way, at))
                if not of_links and around.meshes[pair % rows] >= 0:
                    a, b = vec3_at(ends, 6 * c), vec3_at(ends, 6 * c + 3)
                    level = min(dot(way, a), dot(way, b)) - bodies.radii[c] - moves
                    level -= _ALLOWANCE * around.size
                    keep_direction(latest, way, level, around.meshes[pair % rows])
                continue
            if not of_links:
                segment = (vec3_at(ends, 6 * c), vec3_at(ends, 6 * c + 3))
                if open_box(around, pair, moves, segment, work):
                    continue
                # the stretch is halved anyhow: the rest of the mesh is as good tried on its halves
                left = around.meshes[pair % rows] + 0
            candidates.append(pair)
            farthest = max(farthest, moves)
        if len(candidates) == highest:
            continue
        run = stretch.end - stretch.start > 1
        final = stretch.halvings == MOST_HALVINGS or farthest < _FINEST * around.size
        if tries > most_tries or (not run and (final or not stretch.start < at < stretch.end)):
            return UNDECIDED, at, candidates[len(candidates) - 1], 0.0, table_of(planes)
        deeper = 0 if run else stretch.halvings + 1
        pending.append((_Stretch(at, stretch.end, deeper), highest, len(candidates)))
        pending.append((_Stretch(stretch.start, at, deeper), highest, len(candidates)))
    return CERTIFIED, 0.0, -1, math.inf, table_of(planes)
