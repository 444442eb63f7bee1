"""Joints of a URDF, and the single tree of links that they must form."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import cast

import numpy as np

from abi.arrays import FloatArray, read_only
from abi.robot.urdf.joint import Joint, JointKind
from abi.robot.urdf.joint_limits import read_range, read_rates
from abi.robot.urdf.strict_xml import XmlElement

_MOVING = ("revolute", "continuous", "prismatic")
_X = read_only(np.array([1.0, 0.0, 0.0]))
_LEAST_AXIS = 1e-6
_LONG = 1e-2
"""Difference from 1 of an axis's length that is no rounding."""
_HELD = ("floating", "planar", "spherical")
"""Kinds with more than one coordinate, which are held at their origin."""


def read_joint(element: XmlElement) -> Joint:
    """Read a joint with its limits, ignoring what its kind does not use.

    Raises:
        SceneError: its kind is unknown, or one of its numbers makes no sense.
    """
    kind = element.text("type")
    if kind not in (*_MOVING, "fixed", *_HELD):
        raise element.refuse("type", kind, f"one of {', '.join((*_MOVING, 'fixed', *_HELD))}")
    moves = kind in _MOVING
    speed, effort = read_rates(element) if moves else (math.inf, math.inf)
    low, high = read_range(element, kind) if moves else (0.0, 0.0)
    if kind in _HELD:
        element.tell(f"Held at the origin, as its kind is {kind}:")
    follows, factor, offset = _followed(element) if moves else (None, 1.0, 0.0)
    return Joint(
        name=element.text("name"),
        kind=cast(JointKind, kind if moves else "fixed"),
        parent=element.needed("parent").text("link"),
        child=element.needed("child").text("link"),
        origin=element.origin(),
        axis=_axis(element) if moves else _X,
        low=low,
        high=high,
        speed=speed,
        effort=effort,
        follows=follows,
        factor=factor,
        offset=offset,
    )


def some_of(names: Sequence[str], most: int = 4) -> str:
    """List the first of some names, and how many more there are."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return f"{', '.join(names[:most])}{more}"


def _axis(element: XmlElement) -> FloatArray:
    """Direction of a joint's axis, a unit vector (3,)."""
    given = element.child("axis")
    axis = _X if given is None else np.array(given.vector("xyz", (1.0, 0.0, 0.0)))
    if not np.linalg.norm(axis) > _LEAST_AXIS:
        raise element.refuse("axis", tuple(axis.tolist()), "a direction, as it moves about it")
    if element.text("type") == "prismatic" and abs(np.linalg.norm(axis) - 1) > _LONG:
        element.tell("Slides by its position, however long its axis is:")
    return read_only(axis / np.linalg.norm(axis))


def _followed(element: XmlElement) -> tuple[str | None, float, float]:
    """Name of the joint that one follows, None for none, its factor and its offset."""
    mimic = element.child("mimic")
    if mimic is None:
        return None, 1.0, 0.0
    factor = mimic.number("multiplier", 1.0, -1e3, 1e3)
    return mimic.text("joint"), factor, mimic.number("offset", 0.0, -1e3, 1e3)


def in_order(
    root: XmlElement, links: Collection[str], joints: Sequence[Joint]
) -> tuple[tuple[Joint, ...], str]:
    """Sort the joints, parents first, and find the root link of the tree that they form.

    Raises:
        SceneError: they form no tree, or name a missing link.
    """
    names = [joint.name for joint in joints]
    for joint in joints:
        if names.count(joint.name) > 1:
            raise root.refuse("joints", joint.name, "every name once")
        for side, link in (("parent", joint.parent), ("child", joint.child)):
            if link not in links:
                raise root.refuse(f"joint {joint.name}, {side}", link, "the name of a link")
    carried = [joint.child for joint in joints]
    for link in carried:
        if carried.count(link) > 1:
            raise root.refuse(f"link {link}", f"child of {carried.count(link)} joints", "of one")
    roots = [name for name in links if name not in carried]
    if len(roots) != 1:
        expected = "one link that is no joint's child"
        raise root.refuse("roots", ", ".join(roots[:4]) or "none, a cycle", expected)
    ordered: list[Joint] = []
    reached = [roots[0]]
    for parent in reached:
        for joint in joints:
            if joint.parent == parent:
                ordered.append(joint)
                reached.append(joint.child)
    if len(reached) < len(links):
        lost = next(name for name in links if name not in reached)
        raise root.refuse("links", lost, f"a tree from {roots[0]}, but this is in a cycle")
    return tuple(ordered), roots[0]
