"""Joint positions of a URDF arm along a curve, its motion and its clearance.

The joints start from a chosen or a given pose, and move straight from sample to sample.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from typing import Any

import numpy as np
import scipy

from abi.arm_planning.certificates.chain_certificate import chain_refutation
from abi.arm_planning.certificates.separate_paper_arm_kernels import Slide
from abi.arm_planning.exclusion.touching import touching
from abi.arm_planning.motion.arm_clearance import (
    ArmClearance,
    Contact,
    contacts_of,
    proven_clearance,
)
from abi.arm_planning.motion.proof_memory import ProofMemory
from abi.arm_planning.motion.tool_motion import tool_samples
from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arm_planning.world.chain_distances import (
    Poses,
    floor_distances,
    hull_distances_to,
    obstacle_distances,
    own_distances,
)
from abi.arm_planning.world.collision_world import FLOOR, OWN, CollisionWorld
from abi.arm_planning.world.link_contact import are_apart, link_gap
from abi.arrays import FloatArray, IntArray, flat, read_only
from abi.curves.cubic_profile import PathProfile
from abi.curves.curve import ArcLength, Curve
from abi.robot.kinematics.start_poses import REACHED
from abi.robot.urdf_arm import UrdfArm

_FEW, _GRID = 41, 1201
"""Points of the curve at which first poses are compared, and at which the chosen one is
followed."""
_ROUGH_FIRST = (slice(4, None, 8), slice(0, None, 8), slice(2, None, 4), slice(1, None, 2))
"""Batches of these points; a first pose that touches at some of a batch is discarded."""
_EVERY, _TRIES_TO_REFUTE = 3, 5_000
"""Step between the points of a quick refutation, and the tests that it may take."""
_CLOSER = 0.02
"""Distance beyond the least, over the arm's reach, up to which hulls are measured."""
_ENOUGH = 0.03
"""Clearance, over the arm's reach, beyond which the shorter motion is preferred."""


@dataclass(frozen=True, eq=False)
class ChainJointPath:
    """Joint positions of a URDF arm as functions of the distance along a curve.

    The curve is one of the tool, which the joints follow, or one of the joints, which lead the
    tool: then the distance is one in both spaces (``abi.arm_planning.joint_search.joint_motion``).

    Attributes:
        curve: path of the tool.
        arc: its arc length; None if the joints lead.
        arm: the arm.
        positions: joint positions at equal distances, shape (k, n), [rad] or [unit].
        missed: distance by which the tool misses the curve there, shape (k,), [unit].
        length: the whole distance, [unit].
    """

    curve: Curve
    arc: ArcLength | None
    arm: UrdfArm
    positions: FloatArray
    missed: FloatArray
    length: float

    @cached_property
    def _spline(self) -> Any:
        distances = np.linspace(0.0, self.length, len(self.positions))
        return scipy.interpolate.CubicSpline(distances, self.positions)

    @property
    def is_timed(self) -> bool:
        """Whether the joints depend on the time, too: False."""
        return False

    def rate_limits(self, acceleration: float) -> tuple[FloatArray, FloatArray]:
        """Largest speeds and accelerations of the joints, (n,) each, [rad] or [unit] by [s]."""
        return self.arm.rate_limits(acceleration)[:2]

    def at(self, distances: FloatArray, times: FloatArray | None = None) -> FloatArray:
        """Joint positions at distances (k,), (k, n), within the limits."""
        limits = self.arm.limits
        return np.asarray(np.clip(self._spline(distances), limits[:, 0], limits[:, 1]))

    def motion(self, profile: PathProfile, samples: int) -> ArmMotion:
        """Motion by a profile, at uniform times; cached by profile."""
        return self._last_motion(profile, samples)

    @cached_property
    def _last_motion(self) -> Callable[[PathProfile, int], ArmMotion]:
        return lru_cache(maxsize=1)(self._motion)

    @cached_property
    def _proofs(self) -> ProofMemory:
        return ProofMemory(self.arm)

    def _motion(self, profile: PathProfile, samples: int) -> ArmMotion:
        arm, time = self.arm, np.linspace(0.0, profile.duration, samples)
        travelled, step = profile(time), profile.duration / (samples - 1)
        positions = self.at(travelled)
        tool = arm.tool(positions)
        target, velocity = tool, np.gradient(tool, step, axis=0)
        if self.arc is not None:
            target, _, velocity = tool_samples(self.curve, self.arc, profile, time)
        distances = np.linspace(0.0, self.length, len(self.missed))
        missed = np.interp(travelled, distances, self.missed)
        allowed = REACHED * arm.reach
        nothing = read_only(np.zeros(2))
        return ArmMotion(
            curve=self.curve,
            elbow="up",
            slide=Slide(nothing, nothing, nothing),
            time=read_only(time),
            positions=read_only(positions),
            target=read_only(target),
            tool=read_only(tool),
            tool_velocity=read_only(velocity),
            shortfall=read_only(np.where(missed > allowed, missed, 0.0)),
            limit_violations=(),
            peak_joint_speed=read_only(np.abs(np.diff(positions, axis=0)).max(axis=0) / step),
            joints=arm.joints,
            slides=arm.chain.slides,
        )

    def is_refuted(
        self,
        profile: Callable[[], PathProfile],
        collision_world: CollisionWorld,
        required: float,
    ) -> bool:
        """Check whether some of the poses show that the arm is not clear."""
        poses = self.positions[::_EVERY]
        fault = chain_refutation(self.arm, poses, collision_world, required, _TRIES_TO_REFUTE)
        return fault is not None and fault.decided

    def clearance(
        self,
        motion: ArmMotion,
        collision_world: CollisionWorld,
        required: float,
    ) -> ArmClearance:
        """Clearance of the whole arm in that motion, measured and proven."""
        arm, allowed = self.arm, collision_world.allowed
        poses = _poses(arm, motion)
        obstacles = collision_world.obstacles
        of_capsules = obstacle_distances(arm, obstacles, poses.ends, allowed=allowed)
        least = float(of_capsules[0][:, ~arm.touchable].min(initial=math.inf))
        below = max(required, least) + _CLOSER * arm.reach
        measured = hull_distances_to(arm, poses, collision_world, of_capsules, below)
        measured = _without_touchable(arm, *measured)
        contacts = contacts_of(motion.time, *measured, range(len(arm.capsules)), arm)
        certify = partial(self._proofs.certify, motion.positions, collision_world)
        rows = collision_world.in_use
        found = proven_clearance(motion, arm, measured, contacts, required, rows, certify)
        if found.certificate is not None and _apart_though_allowed(arm, motion):
            found = replace(found, certificate=None)
        if found.certificate is None:  # else it touches neither itself nor the floor
            found = found.with_contacts(_own_contacts(arm, motion, collision_world.floor))
        deepest = [_decided(arm, motion, collision_world, one) for one in found.contacts[:1]]
        contacts = (*deepest, *found.contacts[1:])
        touchable = itertools.compress((one.link for one in arm.capsules), arm.touchable)
        return replace(
            found,
            contacts=contacts,
            allowed=(*arm.allowed, *allowed),
            apart_only=tuple(dict.fromkeys(touchable)),
        )


def _apart_though_allowed(arm: UrdfArm, motion: ArmMotion) -> bool:
    """Check whether links that are said to touch always are apart at either end or in the middle.

    No proof tells whether such a pair touches elsewhere.
    """
    few = motion.positions[[0, len(motion.time) // 2, -1]]
    always = [(one.link, str(one.other)) for one in arm.allowed if one.reason == "always"]
    return any(are_apart(arm, pose, *pair) for pair in always for pose in few)


@lru_cache(maxsize=4)
def _poses(arm: UrdfArm, motion: ArmMotion) -> Poses:
    """Poses of an arm in a motion."""
    return Poses.of(arm, motion.positions)


@lru_cache(maxsize=4)
def _own_contacts(arm: UrdfArm, motion: ArmMotion, floor: float) -> tuple[Contact, ...]:
    """Contacts of an arm in a motion with itself and the floor."""
    poses = _poses(arm, motion)
    own, below = own_distances(arm, poses, 0.0), floor_distances(arm, floor, poses)
    links = np.broadcast_to(OWN - arm.pairs[:, 0], own.shape)
    floors = np.full(below.shape, FLOOR, dtype=np.int32)
    return (
        *contacts_of(motion.time, own, links, arm.pairs[:, 1].tolist(), arm),
        *contacts_of(motion.time, below, floors, range(len(arm.capsules)), arm),
    )


def _decided(
    arm: UrdfArm,
    motion: ArmMotion,
    collision_world: CollisionWorld,
    contact: Contact,
) -> Contact:
    """A contact of a link's bodies, decided by its given shapes at that time."""
    pose = motion.positions[int(np.searchsorted(motion.time, contact.time))]
    pair = contact.link, contact.obstacle
    gap = link_gap(arm, collision_world, pose, pair)
    if gap is None:
        return contact
    if gap <= 0:
        return contact._replace(depth=-gap, certain=True)
    return contact._replace(apart=True)


def _without_touchable(
    arm: UrdfArm, distance: FloatArray, number: IntArray
) -> tuple[FloatArray, IntArray]:
    """Distances and numbers without those of capsules that only must not touch, if they do not."""
    left_out = arm.touchable & (distance > 0)
    return np.where(left_out, np.inf, distance), np.where(left_out, np.int32(-1), number)


def chain_joint_path(curve: Curve, arc: ArcLength, arm: UrdfArm, number: int) -> ChainJointPath:
    """Move an arm's tool along a curve, from a start pose by its number; see :func:`start_pose`."""
    firsts, _ = _followed(arm, _few(curve, arc).tobytes())
    return joint_path_from(firsts[number], curve, arc, arm)


def start_pose(
    curve: Curve,
    arc: ArcLength,
    arm: UrdfArm,
    collision_world: CollisionWorld,
    likely: int = -1,
) -> int:
    """Number of the pose at the start of a curve from which an arm keeps clearest on it.

    Among the poses with the tool at the start it takes one from which the whole curve can be
    followed, if possible with all links clear, and among these the one with the least motion.

    Args:
        curve: path of the tool.
        arc: its arc length, above 0.
        arm: the arm.
        collision_world: what the links must keep clear of.
        likely: number of a pose that will do if the whole curve can be followed from it, far from
            obstacles; -1 for none.
    """
    firsts, followed = _followed(arm, _few(curve, arc).tobytes())
    positions = np.stack([joints for joints, _ in followed])
    beyond = [float(missed.max()) for _, missed in followed]
    beyond = [far if far > REACHED * arm.reach else 0.0 for far in beyond]
    enough = _ENOUGH * arm.reach
    if 0 <= likely < len(firsts) and beyond[likely] == 0:
        poses = Poses.of(arm, positions[likely])
        if _gaps_outside(arm, poses, collision_world).min() >= enough:
            return likely
    least = [k for k, far in enumerate(beyond) if far == min(beyond)]
    if len(least) == 1:
        return least[0]
    gaps = np.minimum(_gaps(arm, positions[least], collision_world), enough)
    travels = np.abs(np.diff(positions[least] / arm.scales, axis=1)).sum(axis=(1, 2))
    return least[int(np.lexsort((travels, -gaps))[0])]


def touches_from_all(
    curve: Curve, arc: ArcLength, arm: UrdfArm, collision_world: CollisionWorld, required: float
) -> bool:
    """Check whether an arm touches something at a few points of a curve from every start pose.

    Args:
        curve: path of the tool.
        arc: its arc length, above 0.
        arm: the arm.
        collision_world: what it must keep clear of, without triangle meshes.
        required: distance that it keeps from obstacles, [unit].
    """
    firsts, followed = _followed(arm, _few(curve, arc).tobytes())
    coordinates = flat(np.concatenate([joints for joints, _ in followed]) / arm.scales)
    around, found = collision_world.beyond(required), np.zeros((len(firsts), _FEW), dtype=bool)
    for some in _ROUGH_FIRST:
        asked = np.zeros_like(found)
        asked[~found.any(axis=1), some] = True
        touches = touching(arm, coordinates, around, 0.0, asked.reshape(-1))
        found |= touches.reshape(found.shape)
    return bool(found.any(axis=1).all())


def _few(curve: Curve, arc: ArcLength) -> FloatArray:
    """Points (k, 3) along a curve at which first poses are compared."""
    return curve(arc.parameter(np.linspace(0.0, arc.length, _FEW)))


@lru_cache(maxsize=4)
def _followed(
    arm: UrdfArm, points: bytes
) -> tuple[tuple[FloatArray, ...], list[tuple[FloatArray, FloatArray]]]:
    """First poses of an arm, and from each the joints along points and the distances missed."""
    few = np.frombuffer(points).reshape(-1, 3)
    firsts = arm.first_poses(few[0])
    return firsts, [arm.follow(pose, few) for pose in firsts]


def _gaps(arm: UrdfArm, positions: FloatArray, collision_world: CollisionWorld) -> FloatArray:
    """Least distances (p,) of an arm at joint positions (p, k, n), exact where below enough."""
    poses, enough = Poses.of(arm, positions.reshape(-1, positions.shape[2])), _ENOUGH * arm.reach
    own = own_distances(arm, poses, enough, positions.shape[1]).min(axis=1, initial=np.inf)
    least = np.minimum(_gaps_outside(arm, poses, collision_world), own)
    return np.asarray(least.reshape(positions.shape[:2]).min(axis=1))


def _gaps_outside(arm: UrdfArm, poses: Poses, collision_world: CollisionWorld) -> FloatArray:
    """Least distances (k,) of an arm's poses to obstacles and floor, exact where below enough."""
    enough, obstacles = _ENOUGH * arm.reach, collision_world.obstacles
    of_capsules = obstacle_distances(arm, obstacles, poses.ends, enough, collision_world.allowed)
    outside = hull_distances_to(arm, poses, collision_world, of_capsules, enough)[0]
    floor = floor_distances(arm, collision_world.floor, poses)
    least = np.minimum(outside.min(axis=1, initial=np.inf), floor.min(axis=1, initial=np.inf))
    return np.asarray(least)


def joint_path_from(
    pose: FloatArray,
    curve: Curve,
    arc: ArcLength,
    arm: UrdfArm,
    home: FloatArray | None = None,
) -> ChainJointPath:
    """Move an arm's tool along a curve from a given pose; redundant joints drift towards
    ``home``."""
    points = curve(arc.parameter(np.linspace(0.0, arc.length, _GRID)))
    positions, missed = arm.follow(pose, points, home)
    return ChainJointPath(curve, arc, arm, read_only(positions), read_only(missed), arc.length)
