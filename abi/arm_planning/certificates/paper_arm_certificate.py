"""Proofs that the links of the paper's arm keep clear while its tool follows a curve.

Theorem. Let a piece of the curve be within d of a point x, and the slide q5 within e of a number,
so that every point of a capsule's segment a..b, as it is at x, moves by at most A d + B e
(:mod:`abi.robot.paper_arm.pose_kernels`). Let O be a compact convex set with the support function
h, and let abs(n) = 1. If min(n·a, n·b) - h(n) > m + radius + A d + B e, then the capsule stays
farther than m from O all along the piece.

Proof. A point of the capsule is within its radius of one of the segment's, and that is within
A d + B e of where it is at x; there n·y >= min(n·a, n·b), and for z in O n·z <= h(n).

The piece lies in the convex hull of its Bézier points, so d is the largest distance of these from
x. If no direction separates a capsule from an obstacle, both halves of the piece are tried.
One direction separates as many triangles of a mesh as lie beyond it.
Rounding: the tool is computed with the errors of the curve's pieces, and the elbow with L times
those, L being its rate and S the largest coordinate; an extra 2^-40 S (1 + L) is required.
:mod:`abi.verify.verify` checks the directions in exact arithmetic, and
``tests/abi/test_proof_constants.py`` derives the number.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Literal

import numpy as np

from abi.arm_planning.certificates.separate_paper_arm_kernels import UNREACHED, Slide, separate_arm
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arm_planning.wrist_drives import wrist_positions
from abi.arrays import flat, read_only
from abi.curves.bezier import Bezier
from abi.curves.clearance.certificate import Certificate, Refutation
from abi.curves.clearance.separation_kernels import CERTIFIED, MOST_HALVINGS, REFUTED
from abi.curves.cubic_profile import CubicProfile, PathProfile
from abi.curves.curve import ArcLength, Curve
from abi.robot.paper_arm.paper_arm import PaperArm
from abi.scene.arm_settings import ArmSettings

_MOST_TRIES = 50_000  # and 20 for each pair of capsule and obstacle
_PARTS = 16  # of each polynomial, at whose ends q5 is known
_SLIDE_PAD = 1e-3  # of its range, for the check's own coarser bounds


def certify_paper_arm(
    curve: Curve | Bezier,
    slide: Slide,
    arm: PaperArm,
    elbow: Literal["up", "down"],
    collision_world: CollisionWorld,
    margin: float,
    most_tries: int | None = None,
) -> Certificate | Refutation:
    """Prove that an arm keeps more than ``margin`` from every obstacle, or find where not.

    Args:
        curve: path of the tool.
        slide: bounds of q5 along it.
        arm: the arm.
        elbow: its branch.
        collision_world: obstacles, floor and column.
        margin: distance to prove from obstacles, at least 0, [unit].
        most_tries: pairs of a capsule and an obstacle to try at most; None for the default limit.
    """
    if most_tries is None:
        most_tries = _MOST_TRIES + 20 * len(collision_world.asked) * collision_world.in_use
    bounds = tuple(flat(values).tobytes() for values in slide)
    return _certified(
        *(curve, bounds, arm, elbow, collision_world, margin, most_tries)  # type: ignore[arg-type]
    )


@lru_cache(maxsize=2)
def _certified(
    curve: Curve | Bezier,
    bounds: tuple[bytes, ...],
    arm: PaperArm,
    elbow: Literal["up", "down"],
    collision_world: CollisionWorld,
    margin: float,
    tries: int,
) -> Certificate | Refutation:
    """Certify an arm along a curve; cached, as a curve that was tried is certified again later."""
    pieces, slide = curve.bezier(), Slide(*map(np.frombuffer, bounds))
    room = np.zeros(3 * (len(pieces.points) + 2 * MOST_HALVINGS + 2) * (pieces.degree + 1))
    status, at, pair, _, planes = separate_arm(
        flat(pieces.points),
        flat(pieces.breaks),
        room,
        arm.table(elbow),
        collision_world.beyond(margin),
        slide,
        tries,
    )
    count = len(collision_world.numbers)
    if status != CERTIFIED:
        capsule, row = (-1, -1) if status == UNREACHED else divmod(pair, count)
        decided = status in (REFUTED, UNREACHED)
        return Refutation(at, int(collision_world.numbers[row]), decided, capsule)
    pairs = planes[:, 2].astype(np.int32)
    rows = pairs % count
    return Certificate(
        margin=margin if (collision_world.numbers >= 0).any() else math.inf,
        pieces=read_only(planes[:, :2].copy()),
        poses=read_only(planes[:, 6].copy()),
        capsule=read_only((pairs // count).astype(np.int32)),
        obstacle=read_only(collision_world.numbers[rows]),
        directions=read_only(planes[:, 3:6].copy()),
    )


def slide_bounds(
    curve: Curve | Bezier, arc: ArcLength, profile: PathProfile, settings: ArmSettings
) -> Slide:
    """Bounds of q5 along a curve that is followed with a speed profile."""
    breaks = curve.bezier().breaks
    if settings.forces[1] == 0 or profile.duration == 0:
        still = read_only(np.full(2, float(settings.q5)))
        return Slide(flat(breaks[[0, -1]]), still, still)
    if isinstance(profile, CubicProfile):
        # a proof is checked again from the duration alone
        ends = np.sort(wrist_positions(settings, np.array([0.0, profile.duration]))[:, 1])
        pad = _SLIDE_PAD * float(np.ptp(ends))
        low, high = np.full(2, ends[0] - pad), np.full(2, ends[1] + pad)
        return Slide(flat(breaks[[0, -1]]), flat(low), flat(high))
    parameters = np.linspace(breaks[:-1], breaks[1:], _PARTS, endpoint=False, axis=1).ravel()
    parameters = np.append(parameters, breaks[-1])
    q5 = wrist_positions(settings, profile.time_at(arc.distance(parameters)))[:, 1]
    pad = _SLIDE_PAD * float(np.ptp(q5))
    low, high = q5 - pad, q5 + pad
    if settings.forces[1] < 0:
        low, high = np.full_like(q5, low.min()), np.full_like(q5, high.max())
    return Slide(flat(parameters), flat(low), flat(high))
