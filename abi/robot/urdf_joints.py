"""Joints of a URDF, and the single tree of links that they must form."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence

import numpy as np

from abi.arrays import read_only
from abi.errors import Missing
from abi.robot.robot import Joint, JointKind, Mimic
from abi.robot.strict_xml import Element

_KINDS: tuple[JointKind, ...] = ("revolute", "continuous", "prismatic", "fixed")
_TURN = 2 * math.pi
_NAMED = 4
"""Joints that a note names, at most."""


def read_joint(element: Element) -> Joint:
    """Read a joint with its limits.

    Raises:
        SceneError: its kind is unknown, or one of its numbers makes no sense.
    """
    kind = element.text("type")
    if kind not in _KINDS:
        raise element.refuse("type", kind, f"one of {', '.join(_KINDS)}")
    axis_of, limit = element.child("axis"), element.child("limit")
    axis = np.array((1.0, 0.0, 0.0) if axis_of is None else axis_of.vector("xyz", (1.0, 0.0, 0.0)))
    if not np.linalg.norm(axis) > 1e-6:
        raise element.refuse("axis", tuple(axis.tolist()), "a direction")
    if kind in ("revolute", "prismatic") and limit is None:
        raise element.refuse("limit", Missing(), "<limit> with lower and upper")
    low, high = (-_TURN, _TURN) if kind == "continuous" else (0.0, 0.0)
    speed = effort = math.inf
    if limit is not None and kind != "fixed":
        if kind != "continuous":
            low, high = (limit.number(side, 0.0, -1e3, 1e3) for side in ("lower", "upper"))
        if low > high:
            raise element.refuse("limit", (low, high), "lower at most upper")
        # many files have 0 where they mean no limit
        speed, effort = (
            limit.number(name, 0.0, 0, 1e9) or math.inf for name in ("velocity", "effort")
        )
    return Joint(
        name=element.text("name"),
        kind=kind,
        parent=element.needed("parent").text("link"),
        child=element.needed("child").text("link"),
        origin=element.origin(),
        axis=read_only(axis / np.linalg.norm(axis)),
        low=low,
        high=high,
        speed=speed,
        effort=effort,
        mimic=_mimic(element),
    )


def unlimited(elements: Iterable[Element]) -> tuple[str, ...]:
    """A sentence on joints that stand still because no limit says how far they go, if any."""
    names = [
        element.text("name")
        for element in elements
        if element.text("type") in ("revolute", "prismatic")
        and element.child("mimic") is None
        and (limit := element.child("limit")) is not None
        and not (limit.text("lower") or limit.text("upper"))
    ]
    if not names:
        return ()
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return (
        "Joints that stand still, as their <limit> has no lower and upper: "
        f"{', '.join(names[:_NAMED])}{more}.",
    )


def _mimic(element: Element) -> Mimic | None:
    mimic = element.child("mimic")
    if mimic is None:
        return None
    factor = mimic.number("multiplier", 1.0, -1e3, 1e3)
    return Mimic(mimic.text("joint"), factor, mimic.number("offset", 0.0, -1e3, 1e3))


def in_order(
    root: Element, links: Collection[str], joints: Sequence[Joint]
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
