"""Motion and clearance of a URDF arm, whose joints move straight from sample to sample."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
import scipy

from abi.arm.arm_clearance import ArmClearance, Contact, Measured, proven_clearance
from abi.arm.chain_certificate import certify_chain
from abi.arm.chain_distances import (
    floor_distances,
    obstacle_distances,
    own_distances,
)
from abi.arm.separate_arm_kernels import Slide
from abi.arm.surroundings import Surroundings
from abi.arm.trajectory import ArmMotion, Trajectory, stretches
from abi.arm.urdf_arm import REACHED, UrdfArm
from abi.arrays import FloatArray, read_only
from abi.curves.curve import ArcLength, Curve
from abi.curves.timed_profile import PathProfile
from abi.obstacles.obstacle_set import ObstacleSet


@dataclass(frozen=True, eq=False)
class JointCourse:
    """Joint positions of a URDF arm as functions of the distance along a curve.

    Attributes:
        curve: path of the tool.
        arc: its arc length.
        arm: the arm.
        positions: joint positions at equal distances, shape (k, n), [rad] or [unit].
        missed: distance by which the tool misses the curve there, shape (k,), [unit].
    """

    curve: Curve
    arc: ArcLength
    arm: UrdfArm
    positions: FloatArray
    missed: FloatArray

    @property
    def speeds(self) -> FloatArray:
        """Largest speed of each joint, (n,), [rad/s] or [unit/s]."""
        return np.asarray(self.arm.chain.speeds * self.arm.scales)

    @property
    def scales(self) -> FloatArray:
        """Factors from [rad/s²] or [m/s²] to [rad/s²] or [unit/s²], (n,)."""
        return self.arm.scales

    @cached_property
    def _spline(self) -> Any:
        distances = np.linspace(0.0, self.arc.length, len(self.positions))
        return scipy.interpolate.CubicSpline(distances, self.positions)

    def at(self, distances: FloatArray) -> FloatArray:
        """Joint positions at distances (k,), (k, n), within the limits."""
        limits = self.arm.limits
        return np.asarray(np.clip(self._spline(distances), limits[:, 0], limits[:, 1]))

    def motion(self, profile: PathProfile, samples: int) -> ArmMotion:
        """Motion by a profile, at uniform times."""
        return _follow(self, profile, samples)

    def is_refuted(self, profile: PathProfile, surroundings: Surroundings, required: float) -> bool:
        """Check if a quick test shows that the arm is not clear: False, it takes the motion."""
        return False

    def clearance(
        self, motion: ArmMotion, obstacles: ObstacleSet, surroundings: Surroundings, required: float
    ) -> ArmClearance:
        """Clearance of the whole arm in that motion, measured and proven."""
        return _clearance(motion, self.arm, obstacles, surroundings, required)


def _follow(course: JointCourse, profile: PathProfile, samples: int) -> ArmMotion:
    """Move an arm along its course, sampled uniformly in time.

    Args:
        course: its joints along the curve.
        profile: the motion along it.
        samples: number of samples m, at least 2.
    """
    arm, trajectory = course.arm, Trajectory(course.curve, course.arc, profile)
    time = np.linspace(0.0, profile.duration, samples)
    target, _, velocity = trajectory.sampled(time)
    travelled = profile(time)
    positions = course.at(travelled)
    step = profile.duration / (samples - 1)
    distances = np.linspace(0.0, course.arc.length, len(course.missed))
    missed = np.interp(travelled, distances, course.missed)
    allowed = REACHED * arm.reach
    nothing = read_only(np.zeros(2))
    return ArmMotion(
        curve=course.curve,
        elbow="up",
        slide=Slide(nothing, nothing, nothing),
        time=read_only(time),
        positions=read_only(positions),
        target=read_only(target),
        tool=read_only(arm.tool(positions)),
        velocity=read_only(velocity),
        unreachable=stretches(time, np.where(missed > allowed, missed, 0.0)),
        limit_violations=(),
        peak_joint_speed=read_only(np.abs(np.diff(positions, axis=0)).max(axis=0) / step),
        joints=arm.joints,
        slides=arm.chain.slides,
    )


def _clearance(
    motion: ArmMotion,
    arm: UrdfArm,
    obstacles: ObstacleSet,
    surroundings: Surroundings,
    required: float,
) -> ArmClearance:
    """Measure how clear an arm stays, and prove as much of it as possible.

    Args:
        motion: its motion.
        arm: the arm.
        obstacles: the solids.
        surroundings: the same, with the floor.
        required: distance to keep from obstacles, at least 0, [unit].
    """
    distance, number = obstacle_distances(arm, obstacles, motion.positions)
    links = [one.link for one in arm.capsules]
    contacts = (
        *_contacts(motion.time, distance, links, number),
        *_contacts(
            motion.time,
            own_distances(arm, motion.positions),
            [links[j] for _, j in arm.pairs],
            [links[i] for i, _ in arm.pairs],
        ),
        *_contacts(
            motion.time,
            floor_distances(arm, surroundings.floor, motion.positions),
            links,
            ["floor"] * len(links),
        ),
    )
    certify = partial(certify_chain, arm, motion.positions, surroundings)
    measured = Measured(distance, number)
    return proven_clearance(motion, arm, measured, contacts, required, surroundings.in_use, certify)


def _contacts(
    time: FloatArray, distance: FloatArray, links: list[str], others: object
) -> list[Contact]:
    """One contact for each of the pairs (c,) whose ``distance`` (m, c) is at most 0 anywhere.

    Args:
        time: shape (m,), [s].
        distance: [unit].
        links: name of the link of each pair.
        others: what each touches: names (c,), or numbers of obstacles (m, c).
    """
    found = []
    for c in np.flatnonzero((distance <= 0).any(axis=0)).tolist():
        touched = np.flatnonzero(distance[:, c] <= 0)
        deepest = int(distance[:, c].argmin())
        other = others[deepest, c] if isinstance(others, np.ndarray) else others[c]  # type: ignore[index]
        first, last, time_of = (float(time[k]) for k in (touched[0], touched[-1], deepest))
        name = other if isinstance(other, str) else int(other)
        depth = -float(distance[deepest, c])
        found.append(Contact(links[c], name, first, last, time_of, depth))
    return found
