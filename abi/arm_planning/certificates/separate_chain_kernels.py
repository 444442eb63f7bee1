"""Certificates of a URDF arm, whose joints move straight from knot to knot.

They are directions that separate its capsules from the surroundings and from each other. See
``abi.arm_planning.certificates.chain_certificate`` for what a direction proves,
``abi.arm_planning.world.collision_world_kernels`` for the surroundings.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from abi.arm_planning.certificates.separate_pairs_kernels import (
    ALLOWANCE,
    FINEST,
    Found,
    Moving,
    Span,
    separate_pairs,
)
from abi.arm_planning.world.chain_distance_kernels import hull_and_row
from abi.arm_planning.world.collision_world_kernels import NO_OBSTACLES, Obstacles, add_pairs_within
from abi.arrays import FloatArray, IntArray
from abi.compilation.borrowed import borrowed, held
from abi.compilation.jitable import jitable
from abi.compilation.plain import numbers, zeros
from abi.compiled import FLOATS, compiled
from abi.curves.clearance.separation_kernels import (
    CERTIFIED,
    NO_PLANE,
    REFUTED,
    UNDECIDED,
    Attempt,
    HalvingLimits,
    Outcome,
    Piece,
    ProofLists,
    SeparatingPlane,
    halves_of_motion,
    new_lists,
    separate_pieces,
    table_of,
    whole_motion,
)
from abi.obstacles.primitive_kernels import centre_of
from abi.obstacles.triangle_mesh.triangle_kernels import between_segments
from abi.obstacles.vector_kernels import Vec3, dot, sub, vec3_at
from abi.robot.bodies.capsule_table import BODIES, Bodies
from abi.robot.bodies.hull_kernels import APART, OVERLAP, between_hulls, placed_corner
from abi.robot.kinematics.chain_kernels import POSE, TABLE, ChainTable, place_chain

WIDER = 1 + 2.0**-36
"""Factor of how far a link moves: its levers are rounded, and the chain's matrices are nearly
rotations."""


class _Pose(NamedTuple):
    """Joint positions in the middle of a piece of a motion, and arrays for the bodies there.

    Attributes:
        joints: coordinates (n,).
        ways: farthest that each goes from there on the stretch (n,).
        ends: of all capsules, flat (6 c,), [unit], world.
        poses: of the joints, flat (12 (m + 1),).
        end: room for coordinates (n,).
        placed: number of the pose at which each capsule's ends were written last (c,), and at last
            the number of this one.
    """

    joints: FloatArray
    ways: FloatArray
    ends: FloatArray
    poses: FloatArray
    end: FloatArray
    placed: IntArray


_NearPose = tuple[Bodies, _Pose]
"""Bodies at a pose, and how far the joints get from it on a piece."""


@jitable
def _joints_at(knots: FloatArray, at: float, joints: FloatArray) -> None:
    """Interpolate the joint coordinates linearly at a parameter of the motion."""
    count = len(joints)
    knot = min(int(at), len(knots) // count - 2)
    share = at - knot
    for j in range(count):
        a, b = knots[knot * count + j], knots[(knot + 1) * count + j]
        joints[j] = a + share * (b - a)


@jitable
def _ways_of(
    knots: FloatArray, stretch: Piece, joints: FloatArray, end: FloatArray, ways: FloatArray
) -> None:
    """Write how far each coordinate gets from ``joints`` on a piece of the motion, at most."""
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
    for c in range(len(bodies.frames)):
        _place_body(bodies, c, poses, ends)


@jitable
def _place_body(bodies: Bodies, c: int, poses: FloatArray, ends: FloatArray) -> None:
    """Write both ends of capsule c, [unit], world, by the poses of the joints."""
    frame, scale = bodies.frames[c], bodies.scale
    for k in range(6 * c, 6 * c + 6, 3):
        x, y, z = bodies.ends[k], bodies.ends[k + 1], bodies.ends[k + 2]
        if frame < 0:
            ends[k], ends[k + 1], ends[k + 2] = scale * x, scale * y, scale * z
            continue
        for r in range(3):
            at = POSE * frame + 3 * r
            ends[k + r] = scale * (
                poses[at] * x + poses[at + 1] * y + poses[at + 2] * z + poses[POSE * frame + 9 + r]
            )


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
    bodies, (_, ways, ends, poses, _, _) = near
    count = len(ways)
    i, j = bodies.pairs[2 * pair], bodies.pairs[2 * pair + 1]
    _need(near, i)
    _need(near, j)
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
    apart = away > radii
    radii = bodies.roundings[i] + bodies.roundings[j]
    far = radii + 2 * allowance + moves
    if apart:  # the hulls, too, but two of their corners are too near for so long a piece
        p = placed_corner(bodies, poses, i, 3 * bodies.first[i])
        between = sub(placed_corner(bodies, poses, j, 3 * bodies.first[j]), p)
        if dot(between, between) <= far * far:
            return True, UNDECIDED, away - radii, way, moves
    found, away, way = between_hulls(bodies, poses, pair, way, radii, far, False)
    outcome = CERTIFIED if found == APART else REFUTED if found == OVERLAP else UNDECIDED
    return True, outcome, away - radii, way, moves


@jitable(forceinline=True)
def _capsule_of(near: _NearPose, c: int) -> Moving:
    """Capsule c at a pose, with the largest displacement of its points on the piece."""
    bodies, (_, ways, ends, _, _, _) = near
    moves = 0.0
    _need(near, c)
    for j in range(len(ways)):
        moves += bodies.levers[c * len(ways) + j] * ways[j]
    first, last = vec3_at(ends, 6 * c), vec3_at(ends, 6 * c + 3)
    return Moving(c, first, last, bodies.radii[c], moves * WIDER, math.inf)


@jitable(forceinline=True)
def _level_at_ends(near: _NearPose, capsule: Moving, way: Vec3) -> float:
    """No bound of a capsule at the ends of a piece: the one around its middle counts."""
    return -math.inf


@jitable
def _refined(
    near: _NearPose, around: Obstacles, c: int, s: int, allowance: float, found: Found
) -> tuple[bool, Found]:
    """Separate the hull inside capsule c from obstacle row s, where its capsule is not."""
    bodies, (_, ways, _, poses, _, _) = near
    moves = 0.0
    for j in range(len(ways)):
        moves += bodies.point_levers[c * len(ways) + j] * ways[j]
    rounding = bodies.roundings[c]
    need = rounding + around.margins[s]
    least, most = need - allowance, need + allowance + moves * WIDER
    if found[0] != REFUTED and s < len(around.margins) - 1:
        corner = placed_corner(bodies, poses, c, 3 * bodies.first[c])
        between = sub(corner, centre_of(around.primitives, s))
        if dot(between, between) <= most * most:  # too near for so long a piece
            return False, found
    outcome, gap, way = hull_and_row(bodies, poses, c, around, s, found[2], least, most, False)
    return True, (outcome, gap - rounding, way)


_AlongKnots = tuple[ChainTable, Bodies, FloatArray, Obstacles, bool, _Pose, list[SeparatingPlane]]
"""A chain, its capsules, knots of its joints, what it is to keep clear of, whether planes are
wanted, and room for a pose and for planes."""


@jitable
def _go_to(problem: _AlongKnots, piece: Piece, at: float) -> _NearPose:
    """Place the joints at a parameter, with bounds of their displacement on a piece.

    Bodies are placed when they are asked about: on a short piece few of them are.
    """
    chain, bodies, knots, _, _, pose, _ = problem
    joints, ways, _, poses, end, placed = pose
    _joints_at(knots, at, joints)
    _ways_of(knots, piece, joints, end, ways)
    place_chain(chain, joints, 0, poses)
    placed[len(placed) - 1] += 1
    return bodies, pose


@jitable
def _need(near: _NearPose, c: int) -> None:
    """Place capsule c at the pose, if it is not."""
    bodies, (_, _, ends, poses, _, placed) = near
    now = placed[len(placed) - 1]
    if placed[c] != now:
        placed[c] = now
        _place_body(bodies, c, poses, ends)


@jitable(forceinline=True)
def _balls_apart(balls: FloatArray, bodies: Bodies, pair: int, allowance: float) -> bool:
    """Check whether balls around all that two capsules pass through are apart.

    Args:
        balls: middle and radius of that of each capsule, flat (4 c,), [unit], world.
        bodies: the bodies.
        pair: number of the pair.
        allowance: for rounding, [unit].
    """
    i, j = 4 * bodies.pairs[2 * pair], 4 * bodies.pairs[2 * pair + 1]
    way = sub(vec3_at(balls, j), vec3_at(balls, i))
    far = balls[i + 3] + balls[j + 3] + 4 * allowance
    apart: bool = dot(way, way) > far * far
    return apart


@jitable
def _add_pairs(problem: _AlongKnots, near: _NearPose, pairs: list[int]) -> None:
    """Add all pairs; unless planes are wanted not those that boxes or balls keep clear."""
    _, bodies, _, around, certify, _, _ = problem
    count, allowance = len(around.margins), ALLOWANCE * around.size
    balls = numbers(4 * len(bodies.frames))
    for c in range(len(bodies.frames)):
        capsule = _capsule_of(near, c)
        far = math.inf if certify else capsule.radius + capsule.way + allowance
        add_pairs_within(around, c, (capsule.first, capsule.last), far, pairs)
        half = sub(capsule.last, capsule.first)
        for r in range(3):
            balls[4 * c + r] = 0.5 * (capsule.first[r] + capsule.last[r])
        balls[4 * c + 3] = 0.5 * math.sqrt(dot(half, half)) + capsule.radius + capsule.way
    for own in range(len(bodies.pairs) // 2):
        if certify or not _balls_apart(balls, bodies, own, allowance):
            pairs.append(len(bodies.frames) * count + own)


@jitable(forceinline=True)
def _along_knots(
    problem: _AlongKnots, piece: Piece, behind: Piece, known: tuple[int, int], lists: ProofLists
) -> Attempt:
    """Separate capsules from rows, and from each other, while the joints move along a piece.

    The size of what is left is the largest way of a capsule.
    """
    _, bodies, _, around, certify, _, latest = problem
    planes, candidates, work = lists.planes, lists.candidates, lists.work
    solid_pairs, allowance = len(bodies.frames) * len(around.margins), ALLOWANCE * around.size
    near, before = _go_to(problem, piece, behind.start), len(candidates)
    work.clear()
    for i in range(known[1] - 1, known[0] - 1, -1):
        if candidates[i] < solid_pairs:
            work.append(candidates[i])
    span = Span(piece.start, piece.end, behind.start, allowance, True, certify)
    outcome, pair, away, tried, farthest = separate_pairs(
        around, span, lists, latest, _capsule_of, _level_at_ends, _refined, near
    )
    tries = tried[0] + tried[1]
    if outcome == REFUTED:
        return Attempt(REFUTED, pair, away, tries, farthest)
    for i in range(known[0], known[1]):
        pair = candidates[i]
        if pair < solid_pairs:
            continue
        tries += 1
        closer, outcome, away, way, moves = _apart(near, pair - solid_pairs, allowance)
        if outcome == REFUTED:
            return Attempt(REFUTED, pair, away, tries, farthest)
        if outcome == CERTIFIED:
            number = -1 - pair if closer else pair
            planes.append(SeparatingPlane(piece.start, piece.end, number, way, behind.start))
        else:
            candidates.append(pair)
            farthest = max(farthest, moves)
    left = candidates[len(candidates) - 1] if len(candidates) > before else -1
    return Attempt(UNDECIDED, left, 0.0, tries, farthest)


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

    Args:
        chain: the chain.
        bodies: its capsules.
        knots: coordinates at m >= 2 knots, flat (m n,).
        around: what to keep clear of.
        most_tries: tries it may take; without ``certify`` those of boxes do not count.
        certify: whether planes are wanted of all pairs, those that boxes keep clear included;
            otherwise the longest pieces come first.

    Returns:
        As for curves, the parameter of knot k being k; a plane's obstacle is the number of its
        pair, -1 less that if it separates the hull, and its level the parameter of the pose.
    """
    count, ends = len(chain.limits) // 2, numbers(6 * len(bodies.frames))
    ways, poses = numbers(count), numbers(POSE * (len(chain.source) + 1))
    placed = zeros(len(bodies.frames) + 1)
    own = _Pose(numbers(count), ways, ends, poses, numbers(count), placed)
    pose = borrowed(own)
    problem = chain, bodies, knots, around, certify, pose, [NO_PLANE]
    lists = new_lists()
    whole = whole_motion(len(knots) // count)
    near = _go_to(problem, whole, halves_of_motion(problem, whole)[1].start)
    _add_pairs(problem, near, lists.candidates)
    limits = HalvingLimits(1, FINEST * around.size, most_tries, math.inf, False, not certify)
    ending = separate_pieces(problem, whole, halves_of_motion, _along_knots, limits, lists)
    held(own)
    return (*ending, table_of(lists.planes))


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
