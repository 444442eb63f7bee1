"""Strict reader of SRDF files: pairs of links that may touch, groups of joints and named states.

The format: http://wiki.ros.org/srdf. What of it the robot does not have is ignored.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

from abi.obstacles.mesh_files.words import counted, shown
from abi.robot.urdf.joint_limits import TURN
from abi.robot.urdf.link_names import rename_links
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.strict_xml import XmlElement, parse
from abi.robot.urdf.urdf_joints import some_of

_PAST = 1e-9
"""Distance by which a state may exceed a limit without a note, [rad] or [m]."""
_ELEMENTS = (
    *("group", "group_state", "passive_joint"),
    *("disable_collisions", "disable_default_collisions", "enable_collisions"),
)
_PASSIVE = "Moved like any other joint, though its SRDF says that nothing drives it:"
_UNUSED = "Not used of its SRDF:"
_UNREACHED = "Left out of its SRDF, as a joint that others follow is turned farther than planned:"
_TURNED = "Whole turns are left off where a state of its SRDF has more than one:"
_BEYOND = "The limit counts where a state of its SRDF is beyond:"
_AGAIN = "The last one counts where its SRDF has a state twice:"


def with_srdf(robot: Robot, content: bytes, name: str, renamed: Mapping[str, str]) -> Robot:
    """A robot with the groups, named states and pairs that may touch of its SRDF.

    Where several groups have a state of a name, it is called ``GROUP/NAME``.

    Args:
        robot: the robot.
        content: of the file.
        name: of the file, for the sentences.
        renamed: new names of its links, by those that the file has.

    Raises:
        SceneError: it is no SRDF, it is truncated, or a state has a position that is no number.
    """
    root = XmlElement(parse(content, name), name, "robot")
    rename_links(root.xml, renamed)
    groups: dict[str, tuple[str, ...]] = {}
    for group in root.all("group"):
        if group.text("name"):  # one inside another is a reference to one before
            groups[group.text("name")] = _joints(group, robot, groups)
    touching, states = _may_touch(root, robot), _states(root, robot)
    own = {one.name for one in robot.joints if one.kind != "fixed" and one.follows is None}
    for joint in root.all("passive_joint"):
        if joint.text("name") in own:
            root.told.setdefault(_PASSIVE, []).append(joint.text("name"))
    others = dict.fromkeys(str(one.tag) for one in root.xml if one.tag not in _ELEMENTS)
    if others:
        root.told[_UNUSED] = [*others]
    notes = [*robot.notes]
    if root.text("name") != robot.name:
        of = shown(root.text("name"))
        notes.append(f"Its SRDF is that of a robot {of}, and counts all the same.")
    if touching:
        pairs = counted(len(touching), "pair of links", "pairs of links")
        notes.append(f"{pairs} not checked against each other: its SRDF says so.")
    if states:
        notes.append(f"Named states of its SRDF: {some_of([*states], 6)}.")
    notes += [f"{note} {some_of(named)}." for note, named in root.told.items()]
    return replace(robot, may_touch=touching, groups=groups, states=states, notes=tuple(notes))


def _may_touch(root: XmlElement, robot: Robot) -> frozenset[frozenset[str]]:
    """Pairs of links whose collisions are disabled, one by one or for a whole link."""
    links = robot.links.keys()
    pairs = {_pair(one) for one in root.all("disable_collisions")}
    alone = {one.text("link") for one in root.all("disable_default_collisions")}
    pairs |= {frozenset((one, other)) for one in alone & links for other in links}
    pairs -= {_pair(one) for one in root.all("enable_collisions")}
    return frozenset(pair for pair in pairs if len(pair) == 2 and pair <= links)


def _pair(element: XmlElement) -> frozenset[str]:
    return frozenset((element.text("link1"), element.text("link2")))


def _joints(
    group: XmlElement, robot: Robot, known: Mapping[str, tuple[str, ...]]
) -> tuple[str, ...]:
    """Names of a group's movable joints, in the order of the robot."""
    named = {one.text("name") for one in group.all("joint")}
    links = {one.text("name") for one in group.all("link")}
    by_child = {joint.child: joint for joint in robot.joints}
    for chain in group.all("chain"):
        base, link = chain.text("base_link"), chain.text("tip_link")
        while link != base and link in by_child:
            links.add(link)
            link = by_child[link].parent
    for one in group.all("group"):
        named |= {*known.get(one.text("name"), ())}
    return tuple(
        joint.name
        for joint in robot.joints
        if joint.kind != "fixed" and (joint.name in named or joint.child in links)
    )


def _states(root: XmlElement, robot: Robot) -> dict[str, Mapping[str, float]]:
    """Positions of existing joints within their limits, by the names of states.

    Of several states of one name and group the last one counts, as in MoveIt.
    """
    last: dict[tuple[str, str], XmlElement] = {}
    for element in root.all("group_state"):
        title, group = element.text("name"), element.text("group")
        if (title, group) in last:
            root.told.setdefault(_AGAIN, []).append(f"{title} of {group}")
        last[title, group] = element
    count = Counter(title for title, _ in last)
    limits = {one.name: (one.low, one.high) for one in robot.joints if one.kind != "fixed"}
    # what follows them is not as before after a turn
    geared = {
        one.coordinate
        for one in robot.joints
        if one.follows is not None and (one.kind == "prismatic" or one.factor % 1 != 0)
    }
    endless = {one.name for one in robot.joints if one.kind == "continuous"}
    found: dict[str, Mapping[str, float]] = {}
    for (title, group), element in last.items():
        positions: dict[str, float] = {}
        for joint in element.all("joint"):
            name = joint.text("name")
            if name not in limits or len(joint.text("value").split()) != 1:
                continue
            position, (low, high) = joint.number("value", None, -math.inf, math.inf), limits[name]
            beyond = name in endless and math.isfinite(position) and not low <= position <= high
            if beyond and name in geared:
                root.told.setdefault(_UNREACHED, []).append(title)
                positions = {}
                break
            if beyond:
                position -= TURN * round(position / TURN)
                root.told.setdefault(_TURNED, []).append(f"{name} of {title}")
            positions[name] = min(max(position, low), high)
            if abs(positions[name] - position) > _PAST:
                root.told.setdefault(_BEYOND, []).append(f"{name} of {title}")
        if title and positions:
            full = title if count[title] == 1 else f"{group}/{title}"
            full = full if full not in found else f"{len(found) + 1}/{full}"
            found[full] = MappingProxyType(positions)
    return found
