"""Random robots as URDF text: trees of joints of all kinds, of which some follow others.

Their links' poses are worked out here, too, by products of quaternions, to compare with.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from abi.arrays import FloatArray

KINDS = ("revolute", "continuous", "prismatic", "fixed")
_MOST_LINKS = 14


@dataclass(frozen=True)
class RandomJoint:
    """A joint as its file gives it: ``axis`` of any length; it may follow any, but in no ring."""

    name: str
    kind: str
    parent: str
    child: str
    xyz: FloatArray
    rpy: FloatArray
    axis: FloatArray
    low: float
    high: float
    follows: str = ""
    factor: float = 1.0
    offset: float = 0.0

    def text(self) -> str:
        """Its element."""
        limit = f'<limit lower="{self.low!r}" upper="{self.high!r}" velocity="2" effort="9"/>'
        follows = ""
        if self.follows:
            numbers = f'multiplier="{self.factor!r}" offset="{self.offset!r}"'
            follows = f'<mimic joint="{self.follows}" {numbers}/>'
        return (
            f'<joint name="{self.name}" type="{self.kind}"><parent link="{self.parent}"/>'
            f'<child link="{self.child}"/><origin xyz="{_words(self.xyz)}" '
            f'rpy="{_words(self.rpy)}"/><axis xyz="{_words(self.axis)}"/>{limit}{follows}</joint>'
        )


@dataclass(frozen=True)
class RandomRobot:
    """A robot: its text, its joints, parents before children, and the limits of each by name."""

    text: str
    root: str
    joints: tuple[RandomJoint, ...]

    @property
    def limits(self) -> dict[str, tuple[float, float]]:
        """Lowest and highest position of each joint by name."""
        turn = 2 * np.pi
        return {
            one.name: (-turn, turn) if one.kind == "continuous" else (one.low, one.high)
            for one in self.joints
        }


def random_robot(random: np.random.Generator, prefix: str = "") -> RandomRobot:
    """A robot of 3 to 14 links with at least one joint that moves by itself.

    Args:
        random: source of its numbers.
        prefix: beginning of all names.
    """
    count = int(random.integers(3, _MOST_LINKS + 1))
    order = random.permutation(count).tolist()
    joints: list[RandomJoint] = []
    for number in range(1, count):
        kind = "revolute" if number == 1 else str(random.choice(KINDS, p=(0.45, 0.15, 0.2, 0.2)))
        masters = [one.name for one in joints]
        follows, factor, offset = "", 1.0, 0.0
        if number > 1 and random.random() < 0.45:
            factor, offset = random.uniform(-1.5, 1.5, 2).tolist()
            follows = str(random.choice(masters))
        low = float(random.uniform(-2, 0.5))
        # mostly a long chain, and at times a bush
        parent = number - 1 if random.random() < 0.6 else int(random.integers(number))
        joints.append(
            RandomJoint(
                name=f"{prefix}j{order[number]}",
                kind=kind,
                parent=f"{prefix}l{order[parent]}",
                child=f"{prefix}l{order[number]}",
                xyz=random.uniform(-0.6, 0.6, 3),
                rpy=random.uniform(-3, 3, 3),
                axis=random.normal(size=3),
                low=low,
                high=low + float(random.uniform(0.1, 3)),
                follows=follows,
                factor=factor,
                offset=offset,
            )
        )
    links = [
        f'<link name="{prefix}l{k}"><collision><origin xyz="0 0 0.1"/><geometry>'
        f'<box size="0.05 0.06 0.2"/></geometry></collision></link>'
        for k in order
    ]
    parts = [*links, *(one.text() for one in joints)]
    text = f'<robot name="random">{"".join(random.permutation(parts).tolist())}</robot>'
    return RandomRobot(text, f"{prefix}l{order[0]}", tuple(joints))


def robot_of(content: bytes) -> RandomRobot:
    """The robot of a URDF, read by Python's own parser; other kinds of joints are fixed."""
    xml = ElementTree.fromstring(content)
    read = [_joint_of(one) for one in xml.findall("joint")]
    children = {one.child for one in read}
    (root,) = {one.get("name", "") for one in xml.findall("link")} - children
    joints: list[RandomJoint] = []
    reached = [root]
    for link in reached:
        joints += (below := [one for one in read if one.parent == link])
        reached += [one.child for one in below]
    return RandomRobot(content.decode(errors="replace"), root, tuple(joints))


def _joint_of(xml: ElementTree.Element) -> RandomJoint:
    origin, axis, mimic = (xml.find(name) for name in ("origin", "axis", "mimic"))
    return RandomJoint(
        name=xml.get("name", ""),
        kind=kind if (kind := xml.get("type", "")) in KINDS else "fixed",
        parent=_link_of(xml, "parent"),
        child=_link_of(xml, "child"),
        xyz=_numbers(origin, "xyz", "0 0 0"),
        rpy=_numbers(origin, "rpy", "0 0 0"),
        axis=_numbers(axis, "xyz", "1 0 0"),
        low=0.0,
        high=0.0,
        follows="" if mimic is None else mimic.get("joint", ""),
        factor=1.0 if mimic is None else float(mimic.get("multiplier", 1)),
        offset=0.0 if mimic is None else float(mimic.get("offset", 0)),
    )


def _link_of(xml: ElementTree.Element, side: str) -> str:
    found = xml.find(side)
    return "" if found is None else found.get("link", "").strip()


def _numbers(xml: ElementTree.Element | None, name: str, default: str) -> FloatArray:
    text = default if xml is None else xml.get(name, default)
    return np.array(text.replace(", ", " ").split()[:3], dtype=float)


def link_poses(
    robot: RandomRobot, states: Mapping[str, float] | Mapping[str, FloatArray]
) -> dict[str, FloatArray]:
    """Pose of every link in the root by name: (4, 4), or (k, 4, 4) at k states.

    Args:
        robot: the robot.
        states: positions of all joints that move and follow no other, or (k,) of each, [rad] or
            [m].
    """
    by_name = {one.name: one for one in robot.joints}
    found = {robot.root: np.eye(4)}
    for joint in robot.joints:
        x, y, z = joint.rpy
        own = np.eye(4)
        own[:3, :3] = _turn((0, 0, z)) @ _turn((0, y, 0)) @ _turn((x, 0, 0))
        own[:3, 3] = joint.xyz
        way = np.multiply.outer(_position(by_name, joint, states), _unit(joint.axis))
        moved = np.zeros((*way.shape[:-1], 4, 4)) + np.eye(4)
        if joint.kind == "prismatic":
            moved[..., :3, 3] = way
        elif joint.kind != "fixed":
            moved[..., :3, :3] = _turn(way)
        found[joint.child] = found[joint.parent] @ own @ moved
    return found


def _position(
    joints: Mapping[str, RandomJoint],
    joint: RandomJoint,
    states: Mapping[str, float] | Mapping[str, FloatArray],
) -> float | FloatArray:
    if joint.kind == "fixed":
        return 0.0
    if not joint.follows:
        return states[joint.name]
    followed = _position(joints, joints[joint.follows], states)
    return joint.factor * followed + joint.offset


def _unit(axis: FloatArray) -> FloatArray:
    """The direction of an axis; an axis of zeros, which fixed joints may have, stays it."""
    return np.asarray(axis / max(float(np.linalg.norm(axis)), 1e-300))


def _turn(vectors: object) -> FloatArray:
    """Rotation by each vector's length about it, (..., 3, 3), by the matrix of its quaternion."""
    way = np.asarray(vectors, dtype=float)
    angle = np.linalg.norm(way, axis=-1, keepdims=True)
    # sin(a / 2) / a, which is 1 / 2 at 0
    x, y, z = np.moveaxis(way * np.sinc(angle / (2 * np.pi)) / 2, -1, 0)
    w = np.cos(angle[..., 0] / 2)
    left = np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]])
    right = np.array([[w, x, y, z], [-x, w, -z, y], [-y, z, w, -x], [-z, -y, x, w]])
    turns = np.moveaxis(left, (0, 1), (-2, -1)) @ np.moveaxis(right, (0, 1), (-2, -1))
    return np.asarray(turns[..., 1:, 1:])


def _words(numbers: FloatArray) -> str:
    return " ".join(repr(float(number)) for number in numbers)
