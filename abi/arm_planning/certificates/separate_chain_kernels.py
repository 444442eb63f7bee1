"""Certificates of a URDF arm, whose joints move straight from knot to knot.

They are directions that separate its capsules from the surroundings and from each other. See
``abi.arm_planning.certificates.chain_certificate`` for what a direction proves,
``abi.arm_planning.world.collision_world_kernels`` for the surroundings.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from abi.arm_planning.certificates.separate_pairs_kernels import (
    ALLOWANCE,
    FINEST,
    NO_DIRECTION,
    Found,
    Moving,
    ProofLists,
    Span,
    separate_pairs,
)
from abi.arm_planning.world.chain_distance_kernels import hull_and_row
from abi.arm_planning.world.collision_world_kernels import NO_OBSTACLES, Obstacles, add_pairs_within
from abi.arrays import FloatArray
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, compiled
from abi.curves.clearance.separation_kernels import (
    CERTIFIED,
    MOST_HALVINGS,
    NO_PLANE,
    REFUTED,
    UNDECIDED,
    Outcome,
    SeparatingPlane,
    table_of,
)
from abi.obstacles.triangle_mesh.triangle_kernels import between_segments
from abi.obstacles.vector_kernels import Vec3, dot, sub, vec3_at
from abi.robot.bodies.capsule_table import BODIES, Bodies
from abi.robot.bodies.hull_kernels import APART, OVERLAP, between_hulls
from abi.robot.kinematics.chain_kernels import POSE, TABLE, ChainTable, place_chain

WIDER = 1 + 2.0**-36
"""Factor of how far a link moves: its levers are rounded, and the chain's matrices are nearly
rotations."""


class _JointStretch(NamedTuple):
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


class _NearPose(NamedTuple):
    """Bodies near a pose.

    Attributes:
        bodies: the bodies.
        ends: of all capsules at the pose, flat (6 c,), [unit], world.
        ways: of the coordinates from the pose, at most, (n,).
        poses: of the joints there, flat (12 (m + 1),).
    """

    bodies: Bodies
    ends: FloatArray
    ways: FloatArray
    poses: FloatArray


@jitable
def _joints_at(knots: FloatArray, at: float, joints: FloatArray) -> None:
    """Write the coordinates at a place between two knots."""
    count = len(joints)
    knot = min(int(at), len(knots) // count - 2)
    share = at - knot
    for j in range(count):
        a, b = knots[knot * count + j], knots[(knot + 1) * count + j]
        joints[j] = a + share * (b - a)


@jitable
def _ways_of(
    knots: FloatArray, stretch: _JointStretch, joints: FloatArray, end: FloatArray, ways: FloatArray
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


@jitable
def place_bodies(
    chain: ChainTable,
    bodies: Bodies,
    joints: FloatArray,
    first: int,
    poses: FloatArray,
    ends: FloatArray,
) -> None:
    """Write both ends of every capsule, flat (6 c,), [unit], world; ``poses`` is room.

    The coordinates are those from ``first`` on.
    """
    place_chain(chain, joints, first, poses)
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


@jitable
def _go_to_middle(
    chain: ChainTable, bodies: Bodies, knots: FloatArray, stretch: _JointStretch, pose: _Pose
) -> float:
    """Write the pose in the middle of a stretch, or at a knot near it; its parameter."""
    at = 0.5 * (stretch.start + stretch.end)
    if stretch.end - stretch.start > 1:
        at = 1.0 * math.floor(at)
    joints, ways, ends, poses, end = pose
    _joints_at(knots, at, joints)
    _ways_of(knots, stretch, joints, end, ways)
    place_bodies(chain, bodies, joints, 0, poses, ends)
    return at


@jitable
def _apart(near: _NearPose, pair: int, allowance: float) -> tuple[bool, int, float, Vec3, float]:
    """Check whether a direction keeps two capsules, or else the hulls in them, apart near a pose.

    Args:
        near: the bodies near the pose.
        pair: number of the pair.
        allowance: for rounding, [unit].

    Returns:
        Whether what follows is of the hulls; CERTIFIED, REFUTED at the pose or UNDECIDED; the
        distance there; the direction; the ways of both beside each other, at most, [unit].
    """
    bodies, ends, ways, poses = near
    count = len(ways)
    i, j = bodies.pairs[2 * pair], bodies.pairs[2 * pair + 1]
    p, a = vec3_at(ends, 6 * i), vec3_at(ends, 6 * i + 3)
    q, b = vec3_at(ends, 6 * j), vec3_at(ends, 6 * j + 3)
    moves = 0.0
    for k in range(count):
        moves += bodies.pair_levers[pair * count + k] * ways[k]
    moves *= WIDER
    way = between_segments(q, sub(b, q), p, sub(a, p))
    away = math.sqrt(dot(way, way))
    radii = bodies.radii[i] + bodies.radii[j]
    if away > 0:
        way = (way[0] / away, way[1] / away, way[2] / away)
        gap = min(dot(way, q), dot(way, b)) - max(dot(way, p), dot(way, a))
        if gap > radii + 2 * allowance + moves:
            return False, CERTIFIED, away - radii, way, moves
    else:
        way = (0.0, 0.0, 1.0)
    moves = 0.0
    for k in range(count):
        moves += bodies.point_pair_levers[pair * count + k] * ways[k]
    moves *= WIDER
    radii = bodies.roundings[i] + bodies.roundings[j]
    far = radii + 2 * allowance + moves
    found, away, way = between_hulls(bodies, poses, pair, way, radii, far, False)
    outcome = CERTIFIED if found == APART else REFUTED if found == OVERLAP else UNDECIDED
    return True, outcome, away - radii, way, moves


@jitable(forceinline=True)
def _capsule_of(near: _NearPose, c: int) -> Moving:
    """Capsule c near a pose."""
    bodies, ends, ways, _ = near
    moves = 0.0
    for j in range(len(ways)):
        moves += bodies.levers[c * len(ways) + j] * ways[j]
    first, last = vec3_at(ends, 6 * c), vec3_at(ends, 6 * c + 3)
    return Moving(c, first, last, bodies.radii[c], moves * WIDER, math.inf)


@jitable(forceinline=True)
def _level_at_ends(near: _NearPose, capsule: Moving, way: Vec3) -> float:
    """Least product of a direction and a capsule's segment at the ends of a stretch: unknown."""
    return -math.inf


@jitable
def _refined(
    near: _NearPose, around: Obstacles, c: int, s: int, allowance: float, found: Found
) -> tuple[bool, Found]:
    """What is found of the hull in capsule c and row s."""
    bodies, _, ways, poses = near
    moves = 0.0
    for j in range(len(ways)):
        moves += bodies.point_levers[c * len(ways) + j] * ways[j]
    rounding = bodies.roundings[c]
    need = rounding + around.margins[s]
    least, most = need - allowance, need + allowance + moves * WIDER
    outcome, gap, way = hull_and_row(bodies, poses, c, around, s, found[2], least, most, False)
    return True, (outcome, gap - rounding, way)


@jitable
def _add_pairs(
    bodies: Bodies, around: Obstacles, pose: _Pose, certify: bool, pairs: list[int]
) -> None:
    """Add all pairs; unless it is to ``certify`` not those that boxes keep clear near a pose."""
    count, allowance = len(around.margins), ALLOWANCE * around.size
    for c in range(len(bodies.frames)):
        capsule = _capsule_of(_NearPose(bodies, pose.ends, pose.ways, pose.poses), c)
        far = math.inf if certify else capsule.radius + capsule.way + allowance
        add_pairs_within(around, c, (capsule.first, capsule.last), far, pairs)
    for own in range(len(bodies.pairs) // 2):
        pairs.append(len(bodies.frames) * count + own)


@jitable
def separate_knots(
    chain: ChainTable,
    bodies: Bodies,
    knots: FloatArray,
    around: Obstacles,
    most_tries: int,
    certify: bool,
) -> Outcome:
    """Separate every capsule from everything around while the joints go from knot to knot.

    A stretch carries the pairs that its parents were not separated in; what is left of them is
    tried on both halves. Stretches of many knots are halved at a knot. Without ``certify`` the long
    ones come first, so that a contact shows at one of the first poses; with it one half is done
    with before the other is begun, which takes less room.

    Args:
        chain: the chain.
        bodies: its capsules.
        knots: coordinates at m >= 2 knots, flat (m n,).
        around: what to keep clear of.
        most_tries: tries it may take; without ``certify`` those of boxes do not count.
        certify: whether planes are wanted of all pairs, those that boxes keep clear included.

    Returns:
        As for curves, the parameter of knot k being k; a plane's obstacle is the number of its
        pair, -1 less that if it separates the hull, and its level the parameter of the pose.
    """
    count, ends = len(chain.limits) // 2, np.empty(6 * len(bodies.frames))
    ways, poses = np.empty(count), np.empty(POSE * (len(chain.source) + 1))
    pose = _Pose(np.empty(count), ways, ends, poses, np.empty(count))
    planes, candidates, work, tries = [NO_PLANE], [0], [0], 0
    lists = ProofLists(planes, candidates, work, [NO_DIRECTION])
    candidates.clear()
    solid_pairs, allowance = len(bodies.frames) * len(around.margins), ALLOWANCE * around.size
    whole = _JointStretch(0.0, 1.0 * (len(knots) // count - 1), 0)
    _go_to_middle(chain, bodies, knots, whole, pose)
    _add_pairs(bodies, around, pose, certify, candidates)
    pending, first = [(whole, 0, len(candidates))], 0
    while len(pending) > first:
        if certify:
            stretch, lowest, highest = pending.pop()
            while len(candidates) > highest:
                candidates.pop()
        else:
            stretch, lowest, highest = pending[first]
            first += 1
        left = len(candidates)
        at = _go_to_middle(chain, bodies, knots, stretch, pose)
        work.clear()
        lists.latest.clear()
        for i in range(highest - 1, lowest - 1, -1):
            if candidates[i] < solid_pairs:
                work.append(candidates[i])
        near = _NearPose(bodies, ends, ways, poses)
        span = Span(stretch.start, stretch.end, at, allowance, True, certify)
        outcome, pair, away, tried, farthest = separate_pairs(
            around, span, lists, _capsule_of, _level_at_ends, _refined, near
        )
        tries += tried[0] + tried[1]
        if outcome == REFUTED:
            return REFUTED, at, pair, away, table_of(planes)
        for i in range(lowest, highest):
            pair = candidates[i]
            if pair < solid_pairs:
                continue
            tries += 1
            closer, outcome, away, way, moves = _apart(near, pair - solid_pairs, allowance)
            if outcome == REFUTED:
                return REFUTED, at, pair, away, table_of(planes)
            if outcome == CERTIFIED:
                number = -1 - pair if closer else pair
                planes.append(SeparatingPlane(stretch.start, stretch.end, number, way, at))
            else:
                candidates.append(pair)
                farthest = max(farthest, moves)
        if len(candidates) == left:
            continue
        run = stretch.end - stretch.start > 1
        final = stretch.halvings == MOST_HALVINGS or farthest < FINEST * around.size
        if tries > most_tries or (not run and (final or not stretch.start < at < stretch.end)):
            return UNDECIDED, at, candidates[len(candidates) - 1], 0.0, table_of(planes)
        deeper = 0 if run else stretch.halvings + 1
        pending.append((_JointStretch(at, stretch.end, deeper), left, len(candidates)))
        pending.append((_JointStretch(stretch.start, at, deeper), left, len(candidates)))
    return CERTIFIED, 0.0, -1, math.inf, table_of(planes)


@compiled(example=(TABLE, BODIES, FLOATS, NO_OBSTACLES, 9, True))
def separate_chain(
    chain: ChainTable,
    bodies: Bodies,
    knots: FloatArray,
    around: Obstacles,
    most_tries: int,
    certify: bool,
) -> Outcome:
    """Separate a chain's capsules along a path of its joints: see :func:`separate_knots`."""
    return separate_knots(chain, bodies, knots, around, most_tries, certify)
