"""A robot as its URDF describes it: links, joints, shapes and inertias, checked and in order.

A part of it hangs from one of its links, as an arm on a column or one of two.

The format: http://wiki.ros.org/urdf/XML. Lengths in [m], angles in [rad], masses in [kg].
"""

from __future__ import annotations

import hashlib
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, Literal, NamedTuple, get_args

import numpy as np
import scipy

from abi import arguments
from abi.arrays import ByteArray, FloatArray, IntArray, ShortRepr
from abi.errors import ArgumentError, SceneError
from abi.obstacles.pose import Vec3

MOST_JOINTS = 16
"""Most joints between root and tip."""

JointKind = Literal["revolute", "continuous", "prismatic", "fixed"]

_SIZES = {"box": 3, "sphere": 1, "cylinder": 2, "mesh": 0}
"""Kinds of solids, and how many of their sizes are lengths."""


@dataclass(frozen=True, eq=False, repr=False)
class LinkShape(ShortRepr):
    """A solid of a link.

    Attributes:
        kind: ``box``, ``sphere``, ``cylinder`` or ``mesh``.
        size: edges of a box; radius, 0, 0 of a sphere; radius, length, 0 of a cylinder about its z;
            scale of a mesh.
        pose: link from shape, shape (4, 4).
        vertices: of a mesh, scaled, shape (n, 3) in the shape's frame; empty otherwise.
        faces: of a mesh, shape (m, 3).
        colours: red, green and blue of each face, (m, 3), of all, (1, 3), or (0, 3) if not given.
    """

    kind: Literal["box", "sphere", "cylinder", "mesh"]
    size: Vec3
    pose: FloatArray
    vertices: FloatArray
    faces: IntArray
    colours: ByteArray

    def __post_init__(self) -> None:
        """Check the data that proofs are based on.

        Raises:
            ArgumentError: an array has another shape or type, or makes no sense.
        """
        if self.kind not in _SIZES:
            raise ArgumentError("kind", self.kind, f"one of {', '.join(_SIZES)}")
        size = arguments.numbers("size", self.size, (3,))
        if not (size[: _SIZES[self.kind]] > 0).all():
            raise ArgumentError("size", self.size, "lengths above 0")
        vertices = arguments.points("vertices", self.vertices)
        arguments.keep(
            self,
            pose=arguments.pose("pose", self.pose),
            vertices=vertices,
            faces=arguments.ids("faces", self.faces, (-1, 3), len(vertices)),
        )


@dataclass(frozen=True, eq=False, repr=False)
class Link(ShortRepr):
    """A link: a body of a robot.

    Attributes:
        name: of the link.
        shapes: collision shapes; none for a frame.
        visuals: what it is drawn with; none if it is drawn by its shapes.
        mass: [kg], 0 if the file gives none.
        centre: centre of mass in the link's frame, shape (3,).
        inertia: about that centre along the link's axes, shape (3, 3).
    """

    name: str
    shapes: tuple[LinkShape, ...]
    mass: float
    centre: FloatArray
    inertia: FloatArray
    visuals: tuple[LinkShape, ...] = ()

    def __post_init__(self) -> None:
        """Check the data that torques are computed from.

        Raises:
            ArgumentError: a number makes no sense, or an array has another shape.
        """
        arguments.number("mass", self.mass, 0.0)
        arguments.keep(
            self,
            centre=arguments.numbers("centre", self.centre, (3,)),
            inertia=arguments.numbers("inertia", self.inertia, (3, 3)),
        )

    @property
    def drawn(self) -> tuple[LinkShape, ...]:
        """Shapes with which it is drawn."""
        return self.visuals or self.shapes


class Mimic(NamedTuple):
    """A joint that follows another: its position is ``factor`` times the other's + ``offset``."""

    joint: str
    factor: float
    offset: float


@dataclass(frozen=True, eq=False, repr=False)
class Joint(ShortRepr):
    """A joint between two links.

    Attributes:
        name: of the joint.
        kind: how it moves.
        parent, child: names of its links.
        origin: parent link from joint, shape (4, 4).
        axis: unit vector in the joint's frame, shape (3,).
        low, high: limits, [rad] or [m]; those of a continuous joint are ±2π.
        speed: largest at which those that follow it keep their own limits, too, [rad/s] or [m/s];
            inf where the file gives none.
        effort: largest torque or force, [N·m] or [N]; inf where the file gives none.
        mimic: the joint that it follows; None for one that moves by itself.
    """

    name: str
    kind: JointKind
    parent: str
    child: str
    origin: FloatArray
    axis: FloatArray
    low: float
    high: float
    speed: float
    effort: float
    mimic: Mimic | None

    def __post_init__(self) -> None:
        """Check its pose and its numbers.

        Raises:
            ArgumentError: a number makes no sense, or an array has another shape.
        """
        if self.kind not in get_args(JointKind):
            raise ArgumentError("kind", self.kind, f"one of {', '.join(get_args(JointKind))}")
        arguments.ranges("low and high", [[self.low, self.high]], 1)
        arguments.number("speed", self.speed, 0.0, infinite=True)
        arguments.number("effort", self.effort, 0.0, infinite=True)
        if self.mimic is not None:
            arguments.number("mimic.factor", self.mimic.factor)
            arguments.number("mimic.offset", self.mimic.offset)
        arguments.keep(
            self,
            origin=arguments.pose("origin", self.origin),
            axis=arguments.direction("axis", self.axis),
        )

    @property
    def coordinate(self) -> str:
        """Name of the joint whose position moves it: its own, or the one that it follows."""
        return self.name if self.mimic is None else self.mimic.joint

    def motion(self, position: float) -> FloatArray:
        """Pose of its child beside that at position 0, (4, 4), [m].

        Args:
            position: of the joint, [rad] or [m].
        """
        pose = np.eye(4)
        if self.kind == "prismatic":
            pose[:3, 3] = self.axis * position
        elif self.kind != "fixed":
            turn = scipy.spatial.transform.Rotation.from_rotvec(position * self.axis)
            pose[:3, :3] = turn.as_matrix()
        return pose


class NamedState(NamedTuple):
    """Named positions of joints from an SRDF, such as ``home`` or ``open``.

    Attributes:
        name: of the state.
        group: name of the group of joints that it belongs to.
        positions: by the names of joints, within their limits, [rad] or [m].
    """

    name: str
    group: str
    positions: Mapping[str, float]


class Coupling(NamedTuple):
    """A loop that an element for other programs closes, or a joint that it lets follow another.

    Attributes:
        name: of the joint that closes the loop or follows.
        joints: names of the joints in the loop, or of follower and followed; empty where the file
            does not tell.
        closes: whether it closes a loop.
        rests: whether it holds where all these joints are at 0.
    """

    name: str
    joints: tuple[str, ...]
    closes: bool
    rests: bool


class AttachedObject(NamedTuple):
    """An object held by a robot: a link that is in none of its files.

    Attributes:
        link: name of that link.
        tip: name of the link that holds it.
        key: what tells it from others: its shape and unit.
    """

    link: str
    tip: str
    key: Hashable


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
        states: positions of joints that its SRDF gives a name.
        attached: the object that it holds.
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
    states: tuple[NamedState, ...] = ()
    attached: AttachedObject | None = None
    couplings: tuple[Coupling, ...] = ()

    def __post_init__(self) -> None:
        """Let nobody change its mappings."""
        for name in ("links", "groups"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))

    @cached_property
    def digest(self) -> str:
        """Hash of its archive."""
        return hashlib.sha256(self.archive).hexdigest()

    @property
    def _key(self) -> tuple[bytes | int, str, AttachedObject | None]:
        # without an archive nothing but itself says what it is
        return self.archive or id(self), self.root, self.attached

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Robot) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    def __getstate__(self) -> dict[str, Any]:
        """State for ``pickle`` and ``copy``, which cannot handle a view of a dict."""
        states = tuple(one._replace(positions=dict(one.positions)) for one in self.states)
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
    """Check whether one of two links carries the other, by links without collision shapes alone.

    Links that a third one carries do not meet, whether or not that has a shape: a post that stands
    beside a rail is as far from the carriage as its author puts it.
    """
    above = {joint.child: joint.parent for joint in robot.joints}
    for link, other in ((first, second), (second, first)):
        while link in above:
            link = above[link]
            if link == other:
                return True
            if robot.links[link].shapes:
                break
    return False


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
    return replace(robot, root=base, links=links, joints=joints)


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
