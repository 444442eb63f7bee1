"""Joints of a URDF that follow others, each resolved to one that moves by itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from abi.arrays import read_only
from abi.robot.urdf.joint import Joint
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
        if joint.kind != "fixed" and joint.follows is not None:
            joint = _with_master(root, joint, by_name)
            master = by_name.get(joint.coordinate)
            if master is None or master.kind == "fixed":
                followed = "a joint that is not there" if master is None else "a fixed joint"
                note = f"Fixed, as it follows {followed}:"
                root.told.setdefault(note, []).append(f"joint {joint.name}")
                pose = read_only(joint.origin @ joint.motion(joint.offset))
                joint = replace(
                    joint, kind="fixed", origin=pose, follows=None, factor=1.0, offset=0.0
                )
            else:
                if _is_past_limits(joint, master):
                    note = "Taken to follow past its own limits, which do not count:"
                    root.told.setdefault(note, []).append(f"joint {joint.name}")
        found.append(joint)
    return _no_faster_than_followers(root, found)


def _no_faster_than_followers(root: XmlElement, joints: Sequence[Joint]) -> tuple[Joint, ...]:
    """The joints with limits of speed at which those that follow them keep their own."""
    speeds = {joint.name: joint.speed for joint in joints}
    for joint in joints:
        if joint.kind != "fixed" and joint.follows is not None and joint.factor != 0:
            most = joint.speed / abs(joint.factor)
            speeds[joint.follows] = min(speeds[joint.follows], most)
    note = "No faster than the limits of speed of those that follow allow:"
    for joint in joints:
        if speeds[joint.name] < joint.speed:
            root.told.setdefault(note, []).append(f"joint {joint.name}")
    return tuple(replace(joint, speed=speeds[joint.name]) for joint in joints)


def _is_past_limits(joint: Joint, master: Joint) -> bool:
    """Check whether a joint exceeds its limits while its master keeps its own, up to rounding."""
    span = joint.high - joint.low
    if joint.kind == "continuous" or joint.low == joint.high == 0:  # as where none are given
        return False
    ends = [joint.position(end) for end in (master.low, master.high)]
    return min(ends) < joint.low - _ROUNDED * span or max(ends) > joint.high + _ROUNDED * span


def _with_master(root: XmlElement, joint: Joint, by_name: Mapping[str, Joint]) -> Joint:
    """A joint that follows the first of its chain of masters, which may be missing."""
    name, factor, offset = joint.coordinate, joint.factor, joint.offset
    passed = [joint.name]
    while True:
        if name in passed:
            ring = " follows ".join([*passed, name])
            raise root.refuse(f"joint {joint.name}, mimic", ring, "one that moves by itself")
        passed.append(name)
        master = by_name.get(name)
        if master is None or master.follows is None or master.kind == "fixed":
            return replace(joint, follows=name, factor=factor, offset=offset)
        name, factor, offset = (
            *(master.coordinate, factor * master.factor),
            factor * master.offset + offset,
        )
