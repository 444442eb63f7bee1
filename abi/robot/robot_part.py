"""The part of a robot that hangs from one of its links, as an arm on a column or one of two."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

from abi.robot.robot import MOST_JOINTS, Joint, Robot


def bases_to(robot: Robot, tip: str) -> tuple[str, ...]:
    """Links from which 1 to 16 joints move ``tip``, the robot's root first if it is one.

    A link is none if a joint below it mimics one above it.
    """
    parents = {joint.child: joint for joint in robot.joints}
    found: list[str] = []
    link, moving = tip, 0
    while link in parents:
        moving += parents[link].kind != "fixed"
        link = parents[link].parent
        if 1 <= moving <= MOST_JOINTS and _stands_alone(_joints_below(robot, link)):
            found.append(link)
    return tuple(reversed(found))


def part_from(robot: Robot, base: str) -> Robot:
    """The robot with ``base`` as its root, and only the links that this carries."""
    if base == robot.root:
        return robot
    joints = _joints_below(robot, base)
    names = {base, *(joint.child for joint in joints)}
    links = {name: link for name, link in robot.links.items() if name in names}
    return replace(robot, root=base, links=MappingProxyType(links), joints=joints)


def _joints_below(robot: Robot, base: str) -> tuple[Joint, ...]:
    """Joints of all that a link carries, parents before children."""
    carried, found = {base}, []
    for joint in robot.joints:
        if joint.parent in carried:
            carried.add(joint.child)
            found.append(joint)
    return tuple(found)


def _stands_alone(joints: tuple[Joint, ...]) -> bool:
    """Check whether every joint that one of them mimics is among them."""
    names = {joint.name for joint in joints}
    return all(joint.mimic is None or joint.mimic.joint in names for joint in joints)
