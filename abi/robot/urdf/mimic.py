"""Joints of a URDF that follow others, each resolved to one that moves by itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from abi.arrays import read_only
from abi.robot.urdf.joint import Joint, Mimic
from abi.robot.urdf.strict_xml import XmlElement

_ROUNDED = 1e-2
"""Relative rounding of numbers in a file, over a joint's range."""


def with_masters(root: XmlElement, joints: Sequence[Joint]) -> tuple[Joint, ...]:
    """The joints, each follower resolved to a joint that moves by itself.

    What follows a fixed joint, or one that there is not, is fixed at its offset: as if that joint
    were at 0. No joint is faster than those that follow it may be.

    Raises:
        SceneError: some follow each other in a ring.
    """
    by_name = {joint.name: joint for joint in joints}
    found = []
    for joint in joints:
        if joint.kind != "fixed" and joint.mimic is not None:
            mimic = _master(root, joint, by_name)
            if mimic.joint not in by_name or by_name[mimic.joint].kind == "fixed":
                followed = (
                    "a fixed joint" if mimic.joint in by_name else "a joint that is not there"
                )
                note = f"Fixed, as it follows {followed}:"
                root.told.setdefault(note, []).append(f"joint {joint.name}")
                pose = read_only(joint.origin @ joint.motion(mimic.offset))
                joint = replace(joint, kind="fixed", origin=pose, mimic=None)
            else:
                joint = replace(joint, mimic=mimic)
                if _is_past_limits(joint, mimic, by_name[mimic.joint]):
                    note = "Taken to follow past its own limits, which do not count:"
                    root.told.setdefault(note, []).append(f"joint {joint.name}")
        found.append(joint)
    return _no_faster_than_followers(root, found)


def _no_faster_than_followers(root: XmlElement, joints: Sequence[Joint]) -> tuple[Joint, ...]:
    """The joints with limits of speed at which those that follow them keep their own."""
    speeds = {joint.name: joint.speed for joint in joints}
    for joint in joints:
        if joint.kind != "fixed" and joint.mimic is not None and joint.mimic.factor != 0:
            most = joint.speed / abs(joint.mimic.factor)
            speeds[joint.mimic.joint] = min(speeds[joint.mimic.joint], most)
    note = "No faster than the limits of speed of those that follow allow:"
    for joint in joints:
        if speeds[joint.name] < joint.speed:
            root.told.setdefault(note, []).append(f"joint {joint.name}")
    return tuple(replace(joint, speed=speeds[joint.name]) for joint in joints)


def _is_past_limits(joint: Joint, mimic: Mimic, master: Joint) -> bool:
    """Check whether a joint exceeds its limits while its master keeps its own, up to rounding."""
    span = joint.high - joint.low
    if joint.kind == "continuous" or span == 0:
        return False
    ends = [mimic.factor * end + mimic.offset for end in (master.low, master.high)]
    return min(ends) < joint.low - _ROUNDED * span or max(ends) > joint.high + _ROUNDED * span


def _master(root: XmlElement, joint: Joint, by_name: Mapping[str, Joint]) -> Mimic:
    """How a joint follows the first of its chain of masters, which may be missing."""
    assert joint.mimic is not None
    name, factor, offset = joint.mimic
    passed = [joint.name]
    while True:
        if name in passed:
            ring = " follows ".join([*passed, name])
            raise root.refuse(f"joint {joint.name}, mimic", ring, "one that moves by itself")
        passed.append(name)
        master = by_name[name].mimic if name in by_name else None
        if master is None or by_name[name].kind == "fixed":
            return Mimic(name, factor, offset)
        name, factor, offset = (
            *(master.joint, factor * master.factor),
            factor * master.offset + offset,
        )
