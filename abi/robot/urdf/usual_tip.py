"""The default tool link: the last before joints branch into fingers."""

from __future__ import annotations

import re
from collections.abc import Iterable

from abi.robot.urdf.joint import Joint
from abi.robot.urdf.robot import Robot

_FINGER = re.compile(r"finger|gripper|jaw|claw", re.IGNORECASE)
_WRIST = re.compile(r"wrist|roll|rot|yaw|pitch", re.IGNORECASE)


def usual_tip(robot: Robot) -> str:
    """The link moved by the most joints other than a gripper's; the last one if there are several.

    Joints that follow others count where links are else moved by as many.

    A gripper is where two or more rows of joints, the longest of equal length, begin at links that
    are fixed to each other, and are shorter than the row that carries them; or a last joint that is
    called one. What only follows joints before it, as a parallel linkage does, is no such row.
    """
    ways: dict[str, list[Joint]] = {robot.root: []}
    for joint in robot.joints:
        ways[joint.child] = ways[joint.parent] + ([joint] if joint.kind != "fixed" else [])
    ranks = {
        link: (len({joint.coordinate for joint in way}), len(way)) for link, way in ways.items()
    }
    deepest = [link for link, rank in ranks.items() if rank == max(ranks.values())][-1]
    way = ways[deepest]
    most = len(way)
    for count in range(1, most):
        if count > most - count and _branches(robot, way, count):
            return _last_of(robot, way[count - 1].child)
    kept = list(way)
    while len(kept) > 1 and _FINGER.search(kept[-1].name) and not _WRIST.search(kept[-1].name):
        kept.pop()
    return deepest if len(kept) == len(way) else _last_of(robot, kept[-1].child)


def _branches(robot: Robot, way: list[Joint], count: int) -> bool:
    """Check whether joints branch into fingers after that many joints of the deepest row."""
    body = _fixed_to(robot, way[count - 1].child)
    before = {joint.coordinate for joint in way[:count]}
    rows = [
        _longest_row(robot, joint)
        for joint in robot.joints
        if joint.parent in body and joint.kind != "fixed" and joint.coordinate not in before
    ]
    return len(rows) > 1 and rows.count(max(rows)) > 1


def _fixed_to(robot: Robot, link: str) -> list[str]:
    """A link and those fixed to it further out."""
    found = [link]
    for joint in robot.joints:
        if joint.kind == "fixed" and joint.parent in found:
            found.append(joint.child)
    return found


def _longest_row(robot: Robot, first: Joint) -> int:
    """Number of joints in the longest row from a joint on."""
    counts = {first.child: 1}
    for joint in _behind(robot, first):
        counts[joint.child] = counts[joint.parent] + (joint.kind != "fixed")
    return max(counts.values())


def _behind(robot: Robot, first: Joint) -> Iterable[Joint]:
    """Joints further out than one, parents before children."""
    carried = {first.child}
    for joint in robot.joints:
        if joint.parent in carried:
            carried.add(joint.child)
            yield joint


def _last_of(robot: Robot, link: str) -> str:
    """The last link that is fixed to one, such as a flange after the last joint."""
    return _fixed_to(robot, link)[-1]
