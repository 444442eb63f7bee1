"""Motion and clearance of a URDF arm: its joints go straight from sample to sample."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from abi.arm.arm_clearance import ArmClearance, Contact
from abi.arm.joint_course import JointCourse
from abi.arm.joint_path_clearance import (
    JointPathProof,
    floor_distances,
    least_between,
    obstacle_distances,
    own_distances,
)
from abi.arm.separate_arm_kernels import Slide
from abi.arm.trajectory import ArmMotion, Trajectory, stretches
from abi.arm.urdf_arm import REACHED, UrdfArm
from abi.arrays import FloatArray, read_only
from abi.curves.timed_profile import PathProfile
from abi.obstacles.obstacle_set import ObstacleSet

_TOUCH = 1e-6
"""Distance, over the arm's reach, that is proven where no more is asked than not to touch."""


def follow_course(course: JointCourse, profile: PathProfile, samples: int) -> ArmMotion:
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
    allowed = REACHED * arm.chain.table.reach / arm.metres
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


def course_clearance(
    motion: ArmMotion, arm: UrdfArm, obstacles: ObstacleSet, floor: float, required: float
) -> ArmClearance:
    """Measure how clear an arm stays, and prove as much of it as possible.

    Args:
        motion: its motion.
        arm: the arm.
        obstacles: the solids.
        floor: height that the links are to stay above, [unit].
        required: distance to keep from obstacles, at least 0, [unit].
    """
    distance, number = obstacle_distances(arm, obstacles, motion.positions)
    least = distance.min(axis=1)
    sample = int(least.argmin())
    capsule = int(distance[sample].argmin())
    contacts = (
        *_contacts(motion.time, distance, [one.link for one in arm.capsules], number),
        *_contacts(
            motion.time,
            own_distances(arm, motion.positions),
            [arm.capsules[j].link for _, j in arm.pairs],
            [arm.capsules[i].link for i, _ in arm.pairs],
        ),
        *_contacts(
            motion.time,
            floor_distances(arm, floor, motion.positions),
            [one.link for one in arm.capsules],
            ["floor"] * len(arm.capsules),
        ),
    )
    measured = float(least[sample])
    proof = None
    if motion.reachable and not contacts:
        proof = _proof(motion.positions, arm, obstacles, floor)
    has = len(obstacles) > 0
    return ArmClearance(
        elbow="up",
        distances=read_only(least),
        required=required,
        distance=measured if proof is None else proof.margin,
        time=float(motion.time[sample]),
        link=arm.capsules[capsule].link if has else "",
        obstacle=int(number[sample, capsule]) if has else -1,
        contacts=tuple(sorted(contacts, key=_depth, reverse=True)),
        certificate=proof,
    )


def _proof(
    positions: FloatArray, arm: UrdfArm, obstacles: ObstacleSet, floor: float
) -> JointPathProof | None:
    """Proof that nothing is touched, and of a distance to the obstacles."""
    touch = _TOUCH * arm.chain.table.reach / arm.metres
    apart = (
        (partial(own_distances, arm), arm.pair_levers),
        (partial(floor_distances, arm, floor), arm.levers),
    )
    for distances, levers in apart:
        bound = least_between(distances, levers, positions, touch)
        if bound is None or bound <= 0:
            return None
    if not len(obstacles):
        return JointPathProof(math.inf)
    to_obstacles = partial(_to_obstacles, arm, obstacles)
    proven = least_between(to_obstacles, arm.levers, positions, math.inf)
    return None if proven is None else JointPathProof(proven)


def _to_obstacles(arm: UrdfArm, obstacles: ObstacleSet, positions: FloatArray) -> FloatArray:
    return obstacle_distances(arm, obstacles, positions)[0]


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


def _depth(contact: Contact) -> float:
    return contact.depth
