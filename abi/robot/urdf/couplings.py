"""Loops and followers that a URDF has for other programs, in elements that planning does not use.

A robot is posed from its tree of joints and their ``<mimic>``. Where Gazebo closes a loop, or
ros2_control lets a joint follow another, links beside the planned joints may in truth move although
they are posed as if they stood still. So no motion of such a robot is planned or certified, unless
the coupling holds whatever is planned.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np
import scipy
from lxml import etree

from abi.arrays import FloatArray
from abi.errors import SceneError
from abi.robot.urdf.held_joints import positions_held
from abi.robot.urdf.joint import Joint
from abi.robot.urdf.robot import Coupling, Robot
from abi.robot.urdf.strict_xml import XmlElement
from abi.robot.urdf.urdf_joints import some_of

_WORLD = "world"
_WITH_AXIS = ("revolute", "continuous", "hinge", "prismatic")
_POSES, _BEYOND = 12, 1.0
"""Random poses, and least positions on both sides of 0 that joints take in them, [rad] or [m]."""
_OPEN, _SMALL = 1e-3, 0.01
"""Accepted gap of a loop, over how far its ends are apart and 1 cm, but at most 1 m."""
_UNLIMITED = 1e5
"""Limits of a joint from which on it has none, [rad] or [m]."""
_LISTS = ("group", "group_state")


def read_couplings(root: XmlElement, joints: Sequence[Joint], base: str) -> tuple[Coupling, ...]:
    """Loops and followers that the joints and their ``<mimic>`` do not tell of.

    Args:
        root: the robot's element.
        joints: its joints, with the masters that the file gives them.
        base: name of its root link.
    """
    found: dict[str, Coupling] = {}
    by_name = {joint.name: joint for joint in joints}
    above = {joint.child: joint for joint in joints}
    for one in root.xml.iter(etree.Element):
        tag, joint = re.sub(".*[}:]", "", str(one.tag)), one.get("name") or ""
        told = one.getparent()
        if tag == "joint" and told is not None and told.tag in _LISTS and joint in by_name:
            continue  # a joint of the tree is named, as in an SRDF, and none is closed
        if tag == "mimicJoint":
            fault = _following(by_name, str(one.text or "").strip(), told.findtext("joint"), told)
        elif tag == "param" and joint == "mimic":
            fault = _following(by_name, told.get("name") or "", one.text, told)
        elif tag in ("loop_joint", "ball_constraint") or (
            tag == "joint" and "type" in one.attrib and told is not root.xml
        ):
            fault = _closing(above, base, joint.strip(), _ends(one))
            if fault is not None and tag != "joint":  # it need not be closed where all are at 0
                fault = fault._replace(rests=False)
            elif fault is not None:
                kind = one.get("type", "").strip()
                fault = fault._replace(anchor=_anchor(one), kind=kind, axis=_axis(one))
                fault = fault._replace(limited=_is_limited(one))
        elif tag == "linear_bushing_rpy":  # Drake's, between frames that need not be links
            fault = Coupling(tag, (), closes=True, rests=False)
        elif tag == "parent_link" and told is not None and told.find("child_link") is not None:
            name = told.get("name") or ""  # Gazebo's detachable joint, of where links are at first
            ends = [str(end or "").strip() for end in (one.text, told.findtext("child_link"))]
            known = all(end == base or end in above for end in ends)
            fault = _closing(above, base, name, ends) if known else None
            fault = fault and fault._replace(rests=False)
        elif tag == "mimic" and told is not None and told.getparent() is not root.xml:
            fault = Coupling(told.get("name") or "", (), closes=False, rests=False)
        else:
            continue
        if fault is not None:
            found.setdefault(fault.name or f"{len(found)}", fault)
    return tuple(found.values())


def _following(
    by_name: Mapping[str, Joint], name: str, master: str | None, element: etree._Element
) -> Coupling | None:
    """A joint that follows another; None if it does so by the same ``<mimic>``."""
    master = str(master or "").strip()
    numbers = {"multiplier": 1.0, "offset": 0.0}
    for one in element.iter(etree.Element):
        key = one.get("name") if one.tag == "param" else str(one.tag)
        if key in numbers:
            try:
                numbers[key] = float(one.text or "")
            except ValueError:
                return Coupling(name, (), closes=False, rests=False)
    told = master, numbers["multiplier"], numbers["offset"]
    own = by_name.get(name)
    if (
        own is not None
        and own.follows is not None
        and (own.follows, own.factor, own.offset) == told
    ):
        return None
    known = name in by_name and master in by_name
    rests = known and numbers["offset"] == 0
    return Coupling(name, (name, master) if known else (), closes=False, rests=rests)


def _ends(element: etree._Element) -> list[str]:
    """Names of the links that a joint which closes a loop joins, its child last."""
    found: dict[str, list[str]] = {"parent": [], "link1": [], "child": [], "link2": []}
    for one in element.iter(etree.Element):
        tag = re.sub(".*[}:]", "", str(one.tag))
        if tag in found:
            found[tag].append((one.get("link") or one.text or "").strip().rpartition("::")[2])
    return [*itertools.chain(*found.values())]


def _anchor(element: etree._Element) -> tuple[float, ...] | None:
    """Where an SDF joint that closes a loop is in its child's frame, [m]; None if it is not told.

    It is at the frame's origin where no pose says otherwise.
    """
    poses = _own(element, "pose")
    if len(poses) > 1 or any(one.attrib for one in poses):
        return None
    place = _numbers(poses[0].text if poses else "0 0 0 0 0 0")
    return tuple(place[:3]) if len(place) == 6 else None


def _axis(element: etree._Element) -> tuple[float, ...] | None:
    """Axis of an SDF joint that closes a loop in its child's frame; None if it is not told."""
    poses, axes = _own(element, "pose"), _own(element, "axis")
    ways = [one for axis in axes for one in _own(axis, "xyz")]
    frames = [one for axis in axes for one in _own(axis, "use_parent_model_frame")]
    if len(axes) != 1 or len(ways) != 1 or frames or ways[0].attrib:
        return None
    angles, axis = _numbers(poses[0].text if poses else "0 0 0 0 0 0")[3:], _numbers(ways[0].text)
    if len(angles) != 3 or len(axis) != 3 or not any(axis):
        return None
    rotation = scipy.spatial.transform.Rotation.from_euler("xyz", angles)
    return tuple(rotation.apply(np.array(axis) / np.linalg.norm(axis)).tolist())


def _is_limited(element: etree._Element) -> bool:
    """Whether a joint that closes a loop has limits of its own; very large ones are none."""
    for name, sign in (("lower", -1), ("upper", 1)):
        limits = [one for axis in _own(element, "axis") for one in _own(axis, "limit")]
        for number in itertools.chain(*(_numbers(limit.findtext(name)) for limit in limits)):
            if sign * number < _UNLIMITED:
                return True
    return False


def _own(element: etree._Element, name: str) -> list[etree._Element]:
    """Elements of that name right below one, whatever their namespace."""
    return [one for one in element if re.sub(".*[}:]", "", str(one.tag)) == name]


def _numbers(text: str | None) -> list[float]:
    """Numbers of a text; none if it holds anything else."""
    try:
        found = [*map(float, (text or "").split())]
    except ValueError:
        return []
    return found if all(map(math.isfinite, found)) else []


def _closing(
    above: Mapping[str, Joint], base: str, name: str, ends: Sequence[str]
) -> Coupling | None:
    """A loop between two links; None if no joint of it can move."""
    ends = [base if end == _WORLD and end not in above else end for end in ends]
    if len(ends) != 2 or any(end != base and end not in above for end in ends):
        return Coupling(name, (), closes=True, rests=False)
    ways: list[dict[str, None]] = []
    for end in ends:
        way: dict[str, None] = {}
        while end in above:
            if above[end].kind != "fixed":
                way[above[end].name] = None
            end = above[end].parent
        ways.append(way)
    joints = tuple(one for one in {**ways[0], **ways[1]} if (one in ways[0]) != (one in ways[1]))
    if not joints:
        return None
    return Coupling(name, joints, closes=True, rests=True, ends=tuple(ends))


def coupling_notes(couplings: Sequence[Coupling]) -> list[str]:
    """A sentence on loops and followers; none without any."""
    if not couplings:
        return []
    names, limited = (
        [f"joint {one.name or 'without a name'}" for one in chosen]
        for chosen in (couplings, [one for one in couplings if one.limited])
    )
    told = f"Limits of joints that close a loop are not looked at: {some_of(limited)}."
    return [
        *([told] if limited else []),
        f"Loops and couplings are followed from <mimic> alone, not: {some_of(names)}.",
    ]


def unfollowed_notes(root: XmlElement, joints: Sequence[Joint]) -> list[str]:
    """A sentence on joints whose ``<mimic>`` ros2_control says not to follow; none without any.

    Args:
        root: the robot's element.
        joints: its joints.
    """
    free = {one.get("name") for one in root.xml.iter("joint") if one.get("mimic") == "false"}
    names = [one.name for one in joints if one.follows is not None and one.name in free]
    told = f"Moved by <mimic>, though ros2_control says otherwise: joint {some_of(names)}."
    return [told] if names else []


def require_followed(robot: Robot, planned: Collection[str], wanted: Mapping[str, float]) -> None:
    """Refuse a robot with links that a loop or a coupling moves otherwise than they are posed.

    They are posed right where no joint of it moves and all are at 0, at which the file closes it;
    and, in a loop, where ``<mimic>`` tells how its other joints follow those that are planned, so
    that it stays closed.

    Args:
        robot: the robot.
        planned: names of the joints that move.
        wanted: positions of joints that are held, [rad] or [m].

    Raises:
        SceneError: there is such a loop or coupling; names it and what would work.
    """
    if not robot.couplings:
        return
    joints = {joint.name: joint for joint in robot.joints if joint.kind != "fixed"}
    held = positions_held(robot, planned, wanted)
    for one in robot.couplings:
        there = [joints[name] for name in one.joints if name in joints]
        # a joint that is fixed after all may be so anywhere
        rests = one.rests and all(held.get(name) == 0 for name in one.joints)
        follows = any(joint.follows is not None for joint in there)
        told = one.closes and follows and _stays_closed(robot, one)
        if not rests and not told:
            does = "closes a loop" if one.closes else "follows another"
            name = one.name or "without a name"
            expected = "a <mimic> for each joint that moves with the planned ones"
            if one.closes and follows:
                expected += (
                    " and keeps the loop closed as it is where all are at 0, by a hinge, slide, "
                    "ball or weld whose <pose> is told in its child's frame, and its <axis> in one "
                    "that is not turned beside the robot's, as files differ in which they mean"
                )
            raise SceneError(
                "arm.urdf",
                f"joint {name}, which {does} for other programs alone",
                f"{expected}, as links that move otherwise than they are drawn cannot be proven "
                "clear",
            )


def _stays_closed(robot: Robot, loop: Coupling) -> bool:
    """Check whether both ends of a loop stay joined at random positions of its joints.

    Then the joint that closes it stays where it is in both, with its axis if it turns about one;
    or they slide along one line. So it is where all joints are at 0, where the file closes it, and
    beyond limits, which a motion from elsewhere may pass.
    """
    random = np.random.default_rng(0)
    joints = [joint for joint in robot.joints if joint.kind != "fixed"]
    above = {joint.child: joint for joint in robot.joints}
    at = {one.name: 0.0 for one in joints}
    unmoved = {
        one.child: replace(one, follows=None, factor=1.0, offset=0.0) for one in robot.joints
    }
    beside = [_beside(unmoved, loop.ends, at)]
    for _ in range(_POSES):
        for one in joints:
            at[one.name] = random.uniform(min(one.low, -_BEYOND), max(one.high, _BEYOND))
        beside.append(_beside(above, loop.ends, at))
    turns, places = np.array(beside)[:, :3, :3], np.array(beside)[:, :3, 3]
    room = _OPEN * min(float(np.abs(places).max()) + _SMALL, 1.0)
    turned = scipy.spatial.transform.Rotation.from_matrix(turns[0].T @ turns).as_rotvec()
    ways = (places - places[0]) @ turns[0]  # as seen from the second link
    if loop.anchor is None:
        return False
    if loop.kind in _WITH_AXIS:
        still = _pose(unmoved, loop.ends[1], {one.name: 0.0 for one in joints})[:3, :3]
        # in old files it is told in the frame of the whole robot
        if loop.axis is None or np.abs(np.cross(still @ loop.axis, loop.axis)).max() > _OPEN:
            return False
        moved = ways if loop.kind == "prismatic" else turned
        if _off(moved, loop.axis) > (room if loop.kind == "prismatic" else _OPEN * _POSES):
            return False
    elif loop.kind not in ("fixed", "ball"):
        return False
    if loop.kind in ("fixed", "prismatic") and np.abs(turned).max() > _OPEN:
        return False
    joined = turns @ np.array(loop.anchor) + places
    return loop.kind == "prismatic" or bool(np.abs(joined - joined[0]).max() <= room)


def _beside(above: Mapping[str, Joint], ends: Sequence[str], at: Mapping[str, float]) -> FloatArray:
    """Pose of the second of two links in the frame of the first, (4, 4), [m]."""
    first, second = (_pose(above, end, at) for end in ends)
    return np.asarray(np.linalg.inv(first) @ second)


def _off(vectors: FloatArray, axis: Sequence[float]) -> float:
    """Largest distance of vectors (k, 3) from a line through 0, along an axis of length 1."""
    along = np.outer(vectors @ np.array(axis), axis)
    return float(np.linalg.norm(vectors - along, axis=1).max())


def _pose(above: Mapping[str, Joint], link: str, at: Mapping[str, float]) -> FloatArray:
    """Pose of a link in its robot's root, (4, 4), [m], at positions of the joints by name."""
    pose = np.eye(4)
    while link in above:
        joint = above[link]
        if joint.kind != "fixed":
            pose = joint.motion(joint.position(at.get(joint.coordinate, 0.0))) @ pose
        pose, link = joint.origin @ pose, joint.parent
    return pose
