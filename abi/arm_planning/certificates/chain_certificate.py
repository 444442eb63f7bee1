"""Proofs that a URDF arm's links keep clear while its joints move straight from knot to knot.

Theorem. Let the joints stay within w_j of a pose, each coordinate j, so that every point of a
capsule's segment moves by at most W = sum of lever_j w_j from where it is at the pose. Let O be a
compact convex set with the support function h, and let abs(n) = 1. If
min(n·a, n·b) - h(n) > m + radius + W for the segment's ends a, b at the pose, then the capsule
stays farther than m from O all along.

Proof. While the joints go straight from the pose to another, a point of the segment turns about
joint j at most at the distance lever_j: that of the chain stretched out; a slide moves it as far as
itself. So it moves by at most W, and n·y >= min(n·a, n·b) - W - radius for every point y of the
capsule, whereas n·z <= h(n) for z in O. Two capsules are seen from the frame of the last joint that
moves both: there only joints behind it count, and the ways of both add up. A joint that follows a
coordinate, on the way to the tip or beside it, goes straight, too; its lever is that of its own
chain times its factor, and the levers of all that one coordinate moves add up.

A link is in pieces, each of which is inside its capsule and inside the convex hull of a few points,
with a rounding r. Where a capsule is not separated, its hull is: the same holds with the points of
the hull instead of the segment's ends, and r instead of the radius. At any time one of both is
enough, so a certificate may take them in turn.

If no direction separates a pair, both halves of the stretch are tried. Rounding: an extra 2^-40 of
the largest coordinate is required. :mod:`abi.verify.verify_chain` checks it in exact arithmetic.
"""

from __future__ import annotations

import math

import numpy as np

from abi import arguments
from abi.arm_planning.certificates.separate_chain_kernels import separate_chain
from abi.arm_planning.world.collision_world import OWN, CollisionWorld
from abi.arm_planning.world.collision_world_kernels import Obstacles
from abi.arrays import FloatArray, IntArray, flat, read_only
from abi.curves.clearance.certificate import Certificate, Refutation
from abi.curves.clearance.separation_kernels import CERTIFIED, REFUTED, Outcome
from abi.errors import ArgumentError
from abi.robot.bodies.capsule_table import Bodies
from abi.robot.kinematics.chain_kernels import ChainTable
from abi.robot.urdf_arm import UrdfArm

MOST_TRIES = 200_000


def certify_chain(
    arm: UrdfArm,
    positions: FloatArray,
    collision_world: CollisionWorld,
    margin: float,
    with_itself: bool = True,
) -> Certificate | Refutation:
    """Prove that an arm keeps more than ``margin`` from every obstacle, or find where not.

    From the floor and from itself it keeps more than 0. The parameter of the k-th position is k.
    Of a triangle mesh only the surface counts: the caller must know one position at which the arm
    is not inside.

    Args:
        arm: the arm.
        positions: joint positions (k, n), k >= 2, [rad] or [unit].
        collision_world: what to keep clear of.
        margin: distance to prove from obstacles, at least 0, [unit].
        with_itself: whether it is to keep clear of itself, too.
    """
    table, bodies, knots, around = _task(arm, positions, collision_world, margin)
    asked = bodies if with_itself else arm.unpaired_bodies
    outcome = separate_chain(table, asked, knots, around, MOST_TRIES, True)
    refutation, planes = _refutation(arm, collision_world, outcome), outcome[-1]
    if refutation is not None:
        return refutation
    closer = planes[:, 2] < 0
    capsules, others = _pairs(
        arm, collision_world, np.where(closer, -1 - planes[:, 2], planes[:, 2])
    )
    return Certificate(
        margin=margin if (collision_world.numbers >= 0).any() else math.inf,
        pieces=read_only(planes[:, :2].copy()),
        poses=read_only(planes[:, 6].copy()),
        capsule=capsules,
        obstacle=others,
        directions=read_only(planes[:, 3:6].copy()),
        positions=positions,
        closer=read_only(closer),
    )


def chain_refutation(
    arm: UrdfArm,
    positions: FloatArray,
    collision_world: CollisionWorld,
    margin: float,
    most_tries: int = MOST_TRIES,
    with_itself: bool = True,
) -> Refutation | None:
    """Find where :func:`certify_chain` finds that an arm does not keep clear; None if it does.

    Without ``with_itself`` it is not asked whether the arm keeps clear of itself.
    """
    table, bodies, knots, around = _task(arm, positions, collision_world, margin)
    asked = bodies if with_itself else arm.unpaired_bodies
    outcome = separate_chain(table, asked, knots, around, most_tries, False)
    return _refutation(arm, collision_world, outcome)


def _task(
    arm: UrdfArm, positions: FloatArray, collision_world: CollisionWorld, margin: float
) -> tuple[ChainTable, Bodies, FloatArray, Obstacles]:
    positions = arguments.numbers("positions", positions, (-1, len(arm.scales)))
    if len(positions) < 2:
        raise ArgumentError("number of positions", len(positions), "2 or more")
    margin = arguments.number("margin", margin, 0.0, math.inf)
    coordinates = flat(positions / arm.scales)
    return arm.chain.table, arm.bodies, coordinates, collision_world.beyond(margin)


def _refutation(
    arm: UrdfArm, collision_world: CollisionWorld, outcome: Outcome
) -> Refutation | None:
    status, at, pair, _, _ = outcome
    if status == CERTIFIED:
        return None
    capsules, others = _pairs(arm, collision_world, np.array([pair]))
    return Refutation(at, int(others[0]), status == REFUTED, int(capsules[0]))


def _pairs(
    arm: UrdfArm, collision_world: CollisionWorld, pairs: FloatArray | IntArray
) -> tuple[IntArray, IntArray]:
    """Numbers of the capsules of pairs (k,), and of what each is separated from."""
    count = len(collision_world.numbers)
    numbers = pairs.astype(np.int64)
    behind = numbers - len(arm.capsules) * count
    own = behind >= 0
    links = arm.pairs[np.where(own, behind, 0)] if own.any() else np.zeros((len(numbers), 2))
    capsules = np.where(own, links[:, 1], numbers // count)
    others = np.where(own, OWN - links[:, 0], collision_world.numbers[numbers % count])
    return read_only(capsules.astype(np.int32)), read_only(others.astype(np.int32))
