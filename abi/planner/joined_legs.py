"""Motions of an arm one after the other, and their clearances, as one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from abi.arm_planning.motion.arm_clearance import ArmClearance
from abi.arm_planning.motion.trajectory import ArmMotion, Violation
from abi.arrays import FloatArray, read_only


def joined_motion(motions: Sequence[ArmMotion]) -> ArmMotion:
    """Motions one after the other, each from where the last one ended.

    The last sample of one and the first of the next are one.

    Args:
        motions: at least one, all of the same joints.
    """
    starts = begins([float(motion.time[-1]) for motion in motions])
    skips = [0, *[1] * (len(motions) - 1)]
    times = [
        motion.time[skip:] + at for motion, at, skip in zip(motions, starts, skips, strict=True)
    ]
    return replace(
        motions[0],
        time=read_only(np.concatenate(times)),
        positions=_joined([one.positions for one in motions]),
        target=_joined([one.target for one in motions]),
        tool=_joined([one.tool for one in motions]),
        tool_velocity=_joined([one.tool_velocity for one in motions]),
        shortfall=_joined([one.shortfall for one in motions]),
        limit_violations=joined_violations([one.limit_violations for one in motions], starts),
        peak_joint_speed=read_only(np.max([one.peak_joint_speed for one in motions], axis=0)),
        rates=(
            _joined([one.joint_velocities for one in motions]),
            _joined([one.joint_accelerations for one in motions]),
        ),
    )


def joined_clearance(
    clearances: Sequence[ArmClearance], durations: Sequence[float]
) -> ArmClearance | None:
    """Clearance of motions one after the other; None without any.

    It has the certificate of the one that comes nearest to an obstacle, or none where one of them
    has none: what is proven of each is proven by its own.

    Args:
        clearances: of the motions.
        durations: of these, [s].
    """
    if not clearances:
        return None
    starts = begins(durations)
    number = int(np.argmin([one.distance for one in clearances]))
    nearest = clearances[number]
    contacts = [
        one._replace(first=one.first + at, last=one.last + at, time=one.time + at)
        for clearance, at in zip(clearances, starts, strict=False)
        for one in clearance.contacts
    ]
    return replace(
        nearest,
        distances=_joined([one.distances for one in clearances]),
        time=nearest.time + starts[number],
        contacts=tuple(sorted(contacts, key=lambda one: -one.depth)),
        certificate=nearest.certificate if all(one.certified for one in clearances) else None,
        allowed=tuple(dict.fromkeys(one for each in clearances for one in each.allowed)),
        apart_only=tuple(dict.fromkeys(one for each in clearances for one in each.apart_only)),
    )


def joined_violations(
    of_legs: Sequence[Sequence[Violation]], starts: Sequence[float]
) -> tuple[Violation, ...]:
    """Limits that motions one after the other pass, each where a joint is farthest past it.

    Args:
        of_legs: limits that each motion passes, at times from its own begin.
        starts: when each begins, [s].
    """
    found: dict[tuple[str, str], Violation] = {}
    for passed, at in zip(of_legs, starts, strict=True):
        for one in passed:
            later = one._replace(time=one.time + at, since=one.since + at)
            before = found.setdefault((one.joint, one.quantity), later)
            worst = max(before, later, key=lambda each: abs(each.value - each.limit))
            found[one.joint, one.quantity] = worst._replace(since=before.since)
    return tuple(found.values())


def begins(durations: Sequence[float]) -> list[float]:
    """When each of several motions begins, [s]."""
    return [0.0, *np.cumsum(durations)[:-1].tolist()]


def _joined(parts: Sequence[FloatArray]) -> FloatArray:
    """Rows of all parts, but for the first one of each after the first part."""
    return read_only(np.concatenate([parts[0], *(part[1:] for part in parts[1:])]))
