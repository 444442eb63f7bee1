"""Joints of a URDF that follow others, each led back to one that moves by itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from abi.arrays import read_only
from abi.robot.robot import Joint, Mimic
from abi.robot.strict_xml import Element


def with_masters(root: Element, joints: Sequence[Joint]) -> tuple[Joint, ...]:
    """The joints, each that follows another following one that moves by itself.

    What follows a fixed joint is fixed at its offset: that joint's position is 0.

    Raises:
        SceneError: one follows a joint that there is not, or some follow each other in a ring.
    """
    by_name = {joint.name: joint for joint in joints}
    found = []
    for joint in joints:
        if joint.kind != "fixed" and joint.mimic is not None:
            mimic = _master(root, joint, by_name)
            if by_name[mimic.joint].kind == "fixed":
                note = "Fixed, as it follows a fixed joint:"
                root.told.setdefault(note, []).append(f"joint {joint.name}")
                pose = read_only(joint.origin @ joint.motion(mimic.offset))
                joint = replace(joint, kind="fixed", origin=pose, mimic=None)
            else:
                joint = replace(joint, mimic=mimic)
        found.append(joint)
    return tuple(found)


def _master(root: Element, joint: Joint, by_name: Mapping[str, Joint]) -> Mimic:
    """How a joint follows the first of its chain of masters."""
    assert joint.mimic is not None
    name, factor, offset = joint.mimic
    passed = [joint.name]
    while True:
        if name not in by_name:
            raise root.refuse(f"joint {joint.name}, mimic", name, "the name of a joint")
        if name in passed:
            ring = " follows ".join([*passed, name])
            raise root.refuse(f"joint {joint.name}, mimic", ring, "one that moves by itself")
        passed.append(name)
        master = by_name[name].mimic
        if master is None or by_name[name].kind == "fixed":
            return Mimic(name, factor, offset)
        name, factor, offset = (
            *(master.joint, factor * master.factor),
            factor * master.offset + offset,
        )
