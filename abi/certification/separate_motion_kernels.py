"""Directions that keep a robot's convex bodies clear while its joints follow polynomials of time.

The polynomials are bounded by their Bézier points. See ``abi.certification.clearance_proof`` for
what a direction proves, ``abi.arm_planning.world.collision_world_kernels`` for the obstacles.
"""

from __future__ import annotations

import math

import numpy as np

from abi.arm_planning.certificates.separate_chain_kernels import WIDER
from abi.arm_planning.certificates.separate_pairs_kernels import ALLOWANCE, FINEST
from abi.arm_planning.world.collision_world_kernels import (
    NO_OBSTACLES,
    Obstacles,
    is_solid,
    open_box,
)
from abi.arrays import FloatArray
from abi.certification.posed_hulls_kernels import (
    HullPose,
    box_gap,
    from_body,
    from_row,
    new_pose,
    outcome_of,
    place_hulls,
    radius_of,
)
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, compiled
from abi.curves.clearance.separation_kernels import (
    CERTIFIED,
    REFUTED,
    UNDECIDED,
    Attempt,
    HalvingLimits,
    Piece,
    ProofLists,
    SeparatingPlane,
    halves_of_motion,
    new_lists,
    separate_pieces,
    table_of,
    whole_motion,
)
from abi.obstacles.vector_kernels import Vec3, vec3_at
from abi.robot.bodies.capsule_table import BODIES, Bodies
from abi.robot.bodies.hull_kernels import separation
from abi.robot.kinematics.chain_kernels import TABLE, ChainTable


@jitable
def _part_of(
    points: FloatArray, piece: int, j: int, shares: tuple[float, float], pose: HullPose
) -> None:
    """Write the Bézier points of joint j on a part of a polynomial (de Casteljau, twice)."""
    low, high = shares
    room, joints = pose.room, len(pose.joints)
    width, last = len(room), len(room) - 1
    for i in range(width):
        room[i] = points[(piece * width + i) * joints + j]
    for level in range(1, width):
        for i in range(last, level - 1, -1):
            room[i] = room[i - 1] + high * (room[i] - room[i - 1])
    inner = low / high if high > 0 else 0.0
    for level in range(1, width):
        for i in range(width - level):
            room[i] = room[i] + inner * (room[i + 1] - room[i])


@jitable
def joints_at(points: FloatArray, at: float, pose: HullPose) -> None:
    """Write the coordinates at a parameter."""
    width, joints = len(pose.room), len(pose.joints)
    piece = min(int(at), len(points) // (width * joints) - 1)
    for j in range(joints):
        _part_of(points, piece, j, (0.0, at - piece), pose)
        pose.joints[j] = pose.room[width - 1]


@jitable
def ways_of(points: FloatArray, stretch: Piece, pose: HullPose) -> None:
    """Write how far each coordinate gets from the pose: bounded by Bézier points."""
    first = int(stretch.start)
    last = max(first + 1, math.ceil(stretch.end))
    for j in range(len(pose.joints)):
        far = 0.0
        for piece in range(first, last):
            shares = max(stretch.start - piece, 0.0), min(stretch.end - piece, 1.0)
            _part_of(points, piece, j, shares, pose)
            for i in range(len(pose.room)):
                far = max(far, abs(pose.room[i] - pose.joints[j]))
        pose.ways[j] = far


@jitable
def _moves(levers: FloatArray, row: int, ways: FloatArray) -> float:
    """Bound of a motion: levers of a row times how far the coordinates get, [unit]."""
    moves = 0.0
    for j in range(len(ways)):
        moves += levers[row * len(ways) + j] * ways[j]
    return moves * WIDER


@jitable
def _from_row(
    around: Obstacles, hulls: Bodies, pose: HullPose, pair: int, moves: float, allowance: float
) -> tuple[int, Vec3]:
    """Check whether a direction keeps a body clear of a row, or of the floor, near a pose."""
    count = len(around.margins)
    b, s = pair // count, pair % count
    radius = hulls.roundings[b]
    if s == count - 1:
        gap = pose.bounds[6 * b + 2] - around.floor - radius
        outcome = CERTIFIED if gap > moves + allowance else UNDECIDED
        return (REFUTED if gap < -allowance else outcome), (0.0, 0.0, 1.0)
    near = radius + around.margins[s]
    gap, way = box_gap(pose.bounds, b, around.primitives, s)
    if gap > near + moves + allowance:  # the bounds of a row hold its radius
        return CERTIFIED, way
    near += radius_of(around.primitives, s)
    hull = pose.points, hulls.first[b], hulls.first[b + 1]
    far = near + moves + allowance
    pairing = hull, around.primitives, s
    found, _, way = separation(from_row, pairing, way, max(near - allowance, 0.0), far, False)
    return outcome_of(found), way


@jitable
def _add_pairs(around: Obstacles, hulls: Bodies, pairs: list[int]) -> None:
    """Add all pairs: of a body and an outer row that it is to keep clear of, and of two bodies."""
    count, bodies = len(around.margins), len(hulls.frames)
    for b in range(bodies):
        for k in range(len(around.outer)):
            if around.asked[b * count + around.outer[k]]:
                pairs.append(b * count + around.outer[k])
    for own in range(len(hulls.pairs) // 2):
        pairs.append(bodies * count + own)


_AlongMotion = tuple[ChainTable, Bodies, FloatArray, Obstacles, HullPose]
"""A chain, the bodies that it moves, Bézier points of its joints, flat (k (degree + 1) n,), what to
keep clear of, and room for a pose."""


@jitable(forceinline=True)
def _along_motion(
    problem: _AlongMotion, piece: Piece, behind: Piece, known: tuple[int, int], lists: ProofLists
) -> Attempt:
    """Separate bodies from rows, and from each other, while the joints move along a piece.

    The size of what is left is the largest motion of a body.
    """
    chain, hulls, points, around, pose = problem
    planes, candidates, work = lists.planes, lists.candidates, lists.work
    joints_at(points, behind.start, pose)
    ways_of(points, piece, pose)
    place_hulls(chain, hulls, pose)
    work.clear()
    for i in range(known[1] - 1, known[0] - 1, -1):
        work.append(candidates[i])
    solid_pairs, allowance = len(hulls.frames) * len(around.margins), ALLOWANCE * around.size
    tries, farthest, touching, left = 0, 0.0, -1, -1
    while len(work) > 0:
        pair = work.pop()
        tries += 1
        if pair >= solid_pairs:
            moves = _moves(hulls.point_pair_levers, pair - solid_pairs, pose.ways)
            outcome, way = from_body(hulls, pose, pair - solid_pairs, moves, allowance)
        else:
            b = pair // len(around.margins)
            moves = _moves(hulls.point_levers, b, pose.ways)
            outcome, way = _from_row(around, hulls, pose, pair, moves, allowance)
            if outcome != CERTIFIED:
                segment = vec3_at(pose.bounds, 6 * b), vec3_at(pose.bounds, 6 * b + 3)
                if open_box(around, pair, moves, segment, work):
                    continue
                if not is_solid(around, pair):
                    outcome = UNDECIDED
        if outcome == CERTIFIED:
            planes.append(SeparatingPlane(piece.start, piece.end, pair, way, behind.start))
            continue
        if outcome == REFUTED and touching < 0:
            touching = pair
        candidates.append(pair)
        left, farthest = pair, max(farthest, moves)
    if touching >= 0:
        return Attempt(REFUTED, touching, 0.0, tries, farthest)
    return Attempt(UNDECIDED, left, 0.0, tries, farthest)


@compiled(example=(TABLE, BODIES, FLOATS, 2, NO_OBSTACLES, 1.0, 9, True), fallback=False)
def separate_motion(
    chain: ChainTable,
    hulls: Bodies,
    points: FloatArray,
    width: int,
    around: Obstacles,
    finest: float,
    most_tries: int,
    to_the_end: bool,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Separate every body from everything around while the joints follow polynomials of time.

    Args:
        chain: the chain.
        hulls: the bodies that it moves.
        points: Bézier points of the n joints between waypoints, flat (k width n,), [rad] or [m].
        width: points of a polynomial: its degree + 1.
        around: what to keep clear of.
        finest: length of a piece that touches at its pose from which on it is not halved.
        most_tries: pairs to try at most; what is then left is undecided.
        to_the_end: whether to go on once a piece is left.

    Returns:
        Planes (k, 7), as of chains; what is left (l, 7), as planes without a direction; and of each
        of these REFUTED if the piece touches at its pose, UNDECIDED or SPENT (l,).
    """
    count = len(chain.limits) // 2
    pose = new_pose(chain, hulls, count, width)
    lists = new_lists()
    _add_pairs(around, hulls, lists.candidates)
    size = FINEST * around.size
    limits = HalvingLimits(1, size, most_tries, finest, to_the_end, False)
    whole = whole_motion(len(points) // (width * count) + 1)
    problem = chain, hulls, points, around, pose
    separate_pieces(problem, whole, halves_of_motion, _along_motion, limits, lists)
    outcomes = np.empty(len(lists.outcomes) - 1)
    for i in range(len(outcomes)):
        outcomes[i] = lists.outcomes[i + 1]
    return table_of(lists.planes), table_of(lists.left), outcomes
