"""A robot as its URDF describes it: links, joints, shapes and inertias, checked and in order.

A part of it hangs from one of its links, as an arm on a column or one of two.

The format: http://wiki.ros.org/urdf/XML. Lengths in [m], angles in [rad], masses in [kg].
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple

from abi.arrays import ShortRepr
from abi.errors import SceneError
from abi.robot.urdf.joint import Joint
from abi.robot.urdf.link import Link

MOST_JOINTS = 16
"""Most joints between root and tip."""


class Coupling(NamedTuple):
    """A loop that an element for other programs closes, or a joint that it lets follow another.

    Attributes:
        name: of the joint that closes the loop or follows.
        joints: names of the joints in the loop, or of follower and followed; empty where the file
            does not tell.
        closes: whether it closes a loop.
        rests: whether it holds where all these joints are at 0.
        ends: links that it joins; empty where it closes no loop, or the file does not tell.
        anchor: place of that joint in the frame of the second of these, [m]; None where that is not
            told.
        kind: of that joint, as the file says; empty where it does not.
        axis: about which it turns, or along which it slides, in that frame, of length 1; None where
            that is not told.
        limited: whether that joint has limits of its own.
    """

    name: str
    joints: tuple[str, ...]
    closes: bool
    rests: bool
    ends: tuple[str, ...] = ()
    anchor: tuple[float, ...] | None = None
    kind: str = ""
    axis: tuple[float, ...] | None = None
    limited: bool = False


@dataclass(frozen=True, eq=False, repr=False)
class Robot(ShortRepr):
    """A robot: links joined into a tree; compares by its files, its root and what it holds.

    Attributes:
        name: of the robot.
        root: name of the link that has no parent, or that was chosen as the base.
        links: links by name.
        joints: parents before children.
        notes: sentences on what was left out.
        archive: the whole URDF and its meshes, as a zip.
        may_touch: pairs of links that its SRDF, if there is one, excludes from collision checks.
        groups: names of joints that move together, by the names of groups in its SRDF.
        states: positions of joints within their limits, [rad] or [m], by the names that its SRDF
            gives them, such as ``home`` or ``open``, with those of groups where they need them.
        attached: name of the link that stands for the object that it holds, and that is in none of
            its files; empty where it holds none.
        attached_key: what tells that object, and how it is held, from others; it has a hash.
        couplings: loops and followers that ``<mimic>`` does not tell of.
    """

    name: str
    root: str
    links: Mapping[str, Link]
    joints: tuple[Joint, ...]
    notes: tuple[str, ...] = ()
    archive: bytes = b""
    may_touch: frozenset[frozenset[str]] = frozenset()
    groups: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    states: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    attached: str = ""
    attached_key: Any = None
    couplings: tuple[Coupling, ...] = ()

    def __post_init__(self) -> None:
        """Let nobody change its mappings."""
        for name in ("links", "groups", "states"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))

    @cached_property
    def digest(self) -> str:
        """Hash of its archive."""
        return hashlib.sha256(self.archive).hexdigest()

    @property
    def _key(self) -> tuple[bytes | int, str, str, Any]:
        # without an archive nothing but itself says what it is
        return self.archive or id(self), self.root, self.attached, self.attached_key

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Robot) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    def __getstate__(self) -> dict[str, Any]:
        """State for ``pickle`` and ``copy``, which cannot handle a view of a dict."""
        states = {name: dict(positions) for name, positions in self.states.items()}
        views = {"links": dict(self.links), "groups": dict(self.groups), "states": states}
        return {**vars(self), **views}


def require_motion(robot: Robot) -> None:
    """Refuse a robot none of whose joints can move.

    Raises:
        SceneError: every joint is fixed, or has but one position; or there is none.
    """
    if not any(joint.kind != "fixed" and joint.high > joint.low for joint in robot.joints):
        value = f"{len(robot.links)} links and {len(robot.joints)} joints that all stand still"
        raise SceneError(
            "arm.urdf", value, "a robot with a joint that moves, of a range to move in"
        )


def joints_to(robot: Robot, tip: str) -> tuple[Joint, ...]:
    """Joints from the root to a link, fixed ones too.

    Raises:
        SceneError: there is no such link, no joint moves it, or too many joints do.
    """
    if tip not in robot.links:
        names = ", ".join([*robot.links][-6:])
        raise SceneError("arm.tip", tip, f"the name of a link, as {names}")
    by_child = {joint.child: joint for joint in robot.joints}
    way: list[Joint] = []
    link = tip
    while link in by_child:
        way.append(by_child[link])
        link = by_child[link].parent
    if not 1 <= sum(joint.kind != "fixed" for joint in way) <= MOST_JOINTS:
        raise SceneError("arm.tip", tip, f"a link that 1 to {MOST_JOINTS} joints move")
    return tuple(reversed(way))


def meet(robot: Robot, first: str, second: str) -> bool:
    """Check whether one of two links carries the other by one joint that can move.

    Between them are links without collision shapes alone, and no joint that is held. Links that a
    third one carries do not meet, whether or not that has a shape: a post that stands beside a rail
    is as far from the carriage as its author puts it.
    """
    above = {joint.child: joint for joint in robot.joints}
    for link, other in ((first, second), (second, first)):
        moving = 0
        while link in above:
            moving += _can_move(above[link])
            link = above[link].parent
            if link == other:
                return moving <= 1
            if robot.links[link].shapes:
                break
    return False


def joints_between(robot: Robot, first: str, second: str) -> tuple[Joint, ...]:
    """Joints that can move, held ones too, on the way from one link to another."""
    above = {joint.child: joint for joint in robot.joints}
    ways: list[dict[str, Joint]] = [{}, {}]
    for link, way in zip((first, second), ways, strict=True):
        while link in above:
            way |= {link: above[link]}
            link = above[link].parent
    apart = ways[0].keys() ^ ways[1].keys()
    return tuple(one for one in robot.joints if one.child in apart and _can_move(one))


def _can_move(joint: Joint) -> bool:
    """Check that a joint is not locked; own limits of one that follows another do not count."""
    return joint.kind != "fixed" and (joint.follows is not None or joint.low < joint.high)


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
    names, own = {base, *(joint.child for joint in joints)}, {joint.name for joint in joints}
    links = {name: link for name, link in robot.links.items() if name in names}
    # what is coupled to a joint or a link that is left out does not hold in this part alone
    couplings = tuple(
        one
        if own.issuperset(one.joints) and names.issuperset(one.ends)
        else one._replace(rests=False, anchor=None)
        for one in robot.couplings
        if not one.joints or not own.isdisjoint(one.joints)
    )
    return replace(robot, root=base, links=links, joints=joints, couplings=couplings)


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
    return all(joint.follows is None or joint.follows in names for joint in joints)
