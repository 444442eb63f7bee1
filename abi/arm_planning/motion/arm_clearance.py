"""Clearance of the whole arm along its motion: measured at samples, and proven between them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from operator import attrgetter
from typing import NamedTuple

import numpy as np
import scipy

from abi.arm_planning.certificates.paper_arm_certificate import certify_paper_arm
from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arm_planning.world import paper_arm_distance_kernels
from abi.arm_planning.world.arm_worlds import paper_arm_world
from abi.arm_planning.world.collision_world import FLOOR, CollisionWorld
from abi.arm_planning.world.paper_arm_distance_kernels import capsules_near_meshes
from abi.arrays import FloatArray, IntArray, ShortRepr, flat, read_only
from abi.curves.clearance.certificate import Certificate, Refutation
from abi.obstacles.obstacle_set import ObstacleSet
from abi.robot.any_arm import AnyArm
from abi.robot.bodies.allowed_contacts import AllowedContact
from abi.robot.paper_arm.paper_arm import PaperArm

_SHARES = (0.95, 0.8, 0.6, 0.4, 0.2)
"""Fractions of the measured distance that are tried to prove, before the required one."""

_MANY = 1_000
"""Number of rows around an arm, mostly of triangle meshes, beyond which only one proof is tried."""

_DIP = 1e-10
"""Depth of the tool below the floor that counts as rounding, over the arm's size."""

_TOUCH = 1e-9
"""Distance beyond which the arm's distance from itself and the floor is not measured, [unit], as
only contacts are reported."""


class Contact(NamedTuple):
    """A stretch of time in which a link touches something.

    Attributes:
        link: name of the link.
        obstacle: number of an obstacle, or name of a link, or ``floor``.
        first: time of the first sample, [s].
        last: time of the last sample, [s].
        time: time at which it is deepest, [s].
        depth: how far the link's capsule is in it then, [unit].
        certain: whether the link touches it indeed: the bodies of a URDF arm contain its links and
            are a little larger, so that one that overlaps something says that the link may touch.
        apart: whether it is known that the link itself does not touch it then.
    """

    link: str
    obstacle: int | str
    first: float
    last: float
    time: float
    depth: float
    certain: bool = True
    apart: bool = False


@dataclass(frozen=True, eq=False, repr=False)
class ArmClearance(ShortRepr):
    """Clearance of the arm from obstacles, from the floor and from itself.

    Attributes:
        distances: of the links' surfaces to the nearest obstacle at each sample of the motion,
            shape (m,), [unit], negative inside; inf without obstacles, and possibly where a
            triangle mesh is nearest and another sample is nearer to it; possibly 0 where one is
            touched and another sample of the contact is deeper.
        required: distance to keep from obstacles, [unit].
        distance: least distance of the links' surfaces to an obstacle, [unit]; proven where there
            is a certificate, else that of the samples; inf without obstacles.
        time: time at which it is least, [s].
        link: name of the link that is nearest then; empty without obstacles.
        obstacle: number of that obstacle, -1 without obstacles.
        contacts: what touches what, the deepest first.
        certificate: proof of ``distance``, and that nothing else is touched; None if there is none.
        allowed: contacts of a URDF arm that count for nothing.
        apart_only: names of the links that need only not touch obstacles, while something is taken
            or set down: the distances leave them out.
        has_verdict: whether ``distance`` is proven by a verdict on the motion, which has its own
            certificate.
    """

    distances: FloatArray
    required: float
    distance: float
    time: float
    link: str
    obstacle: int
    contacts: tuple[Contact, ...]
    certificate: Certificate | None
    allowed: tuple[AllowedContact, ...] = ()
    apart_only: tuple[str, ...] = ()
    has_verdict: bool = False

    @property
    def certified(self) -> bool:
        """Whether the whole arm is proven to keep the required distance at all times."""
        if self.has_verdict:
            return self.distance >= self.required
        return self.certificate is not None and self.certificate.margin >= self.required

    @property
    def is_too_near(self) -> bool:
        """Whether at a sample the links are nearer to an obstacle than required."""
        return bool(self.distances.min(initial=math.inf) < self.required)

    def with_contacts(self, others: Sequence[Contact]) -> ArmClearance:
        """A copy with further contacts."""
        return replace(self, contacts=_deepest_first((*self.contacts, *others)))

    def renumbered(self, number: Callable[[int], int]) -> ArmClearance:
        """A copy that counts obstacles as another scene does, but for its certificate.

        Args:
            number: the number there of an obstacle by its number here.
        """

        def again(other: int | str) -> int | str:
            return number(other) if isinstance(other, int) else other

        return replace(
            self,
            obstacle=self.obstacle if self.obstacle < 0 else number(self.obstacle),
            contacts=tuple(one._replace(obstacle=again(one.obstacle)) for one in self.contacts),
            allowed=tuple(one._replace(other=again(one.other)) for one in self.allowed),
        )

    def touching(self, time: float) -> frozenset[str]:
        """Names of the links that touch something, or each other, at a time [s]."""
        now = [one for one in self.contacts if one.first <= time <= one.last]
        links = {contact.link for contact in now}
        return frozenset(links | {one.obstacle for one in now if isinstance(one.obstacle, str)})


def arm_clearance(
    motion: ArmMotion,
    arm: PaperArm,
    collision_world: CollisionWorld,
    required: float,
) -> ArmClearance:
    """Measure the clearance of an arm along its motion, and prove as much of it as possible.

    Args:
        motion: its motion.
        arm: the arm.
        collision_world: obstacles, floor and the arm's column.
        required: distance to keep from obstacles, at least 0, [unit].
    """
    ends = arm.place(motion.positions)
    own = _distances(ends, arm, collision_world.only(collision_world.numbers < 0), _TOUCH)
    measured = _distances(
        ends,
        arm,
        collision_world.only((collision_world.numbers >= 0) & (collision_world.meshes < 0)),
    )
    if collision_world.obstacles.meshes:
        measured = _with_meshes(*measured, ends, arm, collision_world.obstacles)
    capsules = range(len(arm.capsules))
    contacts = (
        *contacts_of(motion.time, *own, capsules, arm),
        *contacts_of(motion.time, *measured, capsules, arm),
        *_dips(motion, arm, collision_world.floor),
    )
    certify = partial(
        certify_paper_arm, motion.curve, motion.slide, arm, motion.elbow, collision_world
    )
    return proven_clearance(
        motion, arm, measured, contacts, required, collision_world.in_use, certify
    )


def _dips(motion: ArmMotion, arm: PaperArm, floor: float) -> list[Contact]:
    """The contact of the tool with the floor where the curve leads below it, if it does.

    The fingers around the tool may touch the floor, so nothing else keeps them above it.
    """
    size = abs(floor) + arm.a1 + arm.a2 + arm.a3 + arm.a4 + arm.a5
    heights = motion.curve.bezier().points[..., 2] - floor
    depth = 0.0
    for piece in heights[heights.min(axis=1) < -_DIP * size]:
        power = scipy.interpolate.BPoly(piece[:, None], [0.0, 1.0])
        slopes = scipy.interpolate.PPoly.from_bernstein_basis(power.derivative())
        turns = slopes.roots(extrapolate=False)
        depth = max(depth, -float(power(np.append(turns[np.isfinite(turns)], (0.0, 1.0))).min()))
    if depth <= _DIP * size:
        return []
    low = motion.tool[:, 2]
    below = np.flatnonzero(low <= max(floor, float(low.min())))
    first, deepest, last = (motion.time[k] for k in (below[0], low.argmin(), below[-1]))
    link = arm.capsule_links[-1]
    return [Contact(link, "floor", float(first), float(last), float(deepest), depth)]


def distance_from_itself(motion: ArmMotion, arm: PaperArm, lowest: float) -> float:
    """Least distance of the paper's arm from floor and column at the samples of a motion, [unit].

    Args:
        motion: the motion.
        arm: the arm.
        lowest: height of the workspace's bottom, [unit].
    """
    own = paper_arm_world(arm, ObstacleSet(()), lowest)
    return float(_distances(arm.place(motion.positions), arm, own)[0].min())


def proven_clearance(
    motion: ArmMotion,
    arm: AnyArm,
    measured: tuple[FloatArray, IntArray],
    contacts: Sequence[Contact],
    required: float,
    rows: int,
    certify: Callable[[float], Certificate | Refutation],
) -> ArmClearance:
    """Prove as much as possible of the clearance that was measured at the samples of a motion.

    Args:
        motion: the motion.
        arm: the arm.
        measured: signed distances of its c capsules to the obstacles at the samples, (m, c),
            [unit], and numbers of the nearest obstacles, (m, c); without obstacles inf and -1.
        contacts: what it touches.
        required: distance to keep from obstacles, at least 0, [unit].
        rows: number of rows around.
        certify: proves a distance, [unit].
    """
    distances, numbers = measured
    least = distances.min(axis=1)
    sample = int(least.argmin())
    capsule = int(distances[sample].argmin())
    distance, obstacle = float(least[sample]), int(numbers[sample, capsule])
    proof = None
    if motion.reachable and not contacts:
        proof = _best_proof(certify, distance, required, rows)
    return ArmClearance(
        distances=read_only(least),
        required=required,
        distance=distance if proof is None else proof.margin,
        time=float(motion.time[sample]),
        link=arm.capsule_links[capsule] if obstacle >= 0 else "",
        obstacle=obstacle,
        contacts=_deepest_first(contacts),
        certificate=proof,
    )


def _deepest_first(contacts: Sequence[Contact]) -> tuple[Contact, ...]:
    return tuple(sorted(contacts, key=attrgetter("depth"), reverse=True))


def is_clear(motion: ArmMotion, clearance: ArmClearance) -> bool:
    """Check whether the whole arm is proven clear all along a motion, within reach and limits."""
    return motion.reachable and motion.within_limits and clearance.certified


def _best_proof(
    certify: Callable[[float], Certificate | Refutation],
    measured: float,
    required: float,
    rows: int,
) -> Certificate | None:
    """Prove the largest possible of a few distances below the measured one; None if none holds.

    With very many rows, as near large triangle meshes, only the required distance is proven.

    Args:
        certify: proves a distance.
        measured: least distance at samples, [unit].
        required: distance asked for, [unit].
        rows: number of rows around.
    """
    tries = {0.0, required}
    if math.isfinite(measured):
        tries |= {share * measured for share in _SHARES}
    many = rows > _MANY and 0 <= required < measured
    asked = certify(required) if many else None
    if isinstance(asked, Certificate):
        return asked
    for margin in sorted((one for one in tries if 0 <= one < measured), reverse=True):
        result = asked if asked is not None and margin == required else certify(margin)
        if isinstance(result, Certificate):
            return result
        if result.capsule < 0 or (result.decided and result.obstacle < 0):
            return None
    return None


def _distances(
    ends: FloatArray, arm: PaperArm, collision_world: CollisionWorld, enough: float = math.inf
) -> tuple[FloatArray, IntArray]:
    """Signed distances of capsules to convex solids and the floor, (m, c), and their numbers.

    What is above ``enough``, [unit], may be inf.
    """
    shape = ends.shape[:2]
    distance, row = np.empty(shape), np.empty(shape, dtype=np.int32)
    paper_arm_distance_kernels.capsule_clearances(
        *(flat(ends), arm.capsule_rows, collision_world.beyond(0.0), enough),
        *(distance.reshape(-1), row.reshape(-1)),
    )
    return distance, collision_world.numbers[row]


def _with_meshes(
    distance: FloatArray, number: IntArray, ends: FloatArray, arm: PaperArm, obstacles: ObstacleSet
) -> tuple[FloatArray, IntArray]:
    """The nearer of convex solids and meshes, for capsules with these ends (m, c, 2, 3).

    Of a capsule that touches nothing and is not the nearest of its pose the distance may be inf. Of
    one that touches a mesh it may be 0 if it is deeper at another pose of the same contact.
    """
    distance, mesh = distance.copy(), np.empty(number.shape, dtype=np.int32)
    capsules_near_meshes(
        *(flat(ends), arm.capsule_rows, obstacles.surfaces),
        *(distance.reshape(-1), mesh.reshape(-1)),
    )
    return distance, np.where(mesh >= 0, obstacles.mesh_numbers[mesh], number)


def contacts_of(
    time: FloatArray,
    distance: FloatArray,
    number: IntArray,
    capsules: Sequence[int],
    arm: AnyArm,
) -> tuple[Contact, ...]:
    """Stretches of time in which capsules are inside something.

    Args:
        time: of the samples (m,), [s].
        distance: of k capsules at them, (m, k), [unit], negative inside.
        number: of the nearest body, (m, k).
        capsules: numbers of these, (k,).
        arm: the arm.
    """
    contacts = []
    touches = distance <= 0
    if not touches.any():  # as most often of the arm itself
        return ()
    # no number is so low: where nothing is touched
    numbers = np.where(touches, number, np.iinfo(np.int32).min)
    for c in np.flatnonzero(touches.any(axis=0)).tolist():
        touched = numbers[:, c]
        changes = np.flatnonzero(touched[1:] != touched[:-1]) + 1
        for first, end in itertools.pairwise([0, *changes.tolist(), len(time)]):
            if touches[first, c]:
                deepest = first + int(distance[first:end, c].argmin())
                contact = Contact(
                    *(arm.capsule_links[capsules[c]], named(int(touched[first]), arm)),
                    *(float(time[first]), float(time[end - 1]), float(time[deepest])),
                    -float(distance[deepest, c]),
                    arm.has_exact_bodies,
                )
                contacts.append(contact)
    return tuple(contacts)


def named(number: int, arm: AnyArm) -> int | str:
    """Number of an obstacle, or name of another part of an arm's collision world."""
    if number >= 0:
        return number
    return "floor" if number == FLOOR else arm.capsule_links[-number - 2]
