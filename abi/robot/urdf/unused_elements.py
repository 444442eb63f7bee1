"""Elements of a URDF that planning does not use, named once."""

from __future__ import annotations

from collections.abc import Mapping

from abi.robot.urdf.strict_xml import XmlElement
from abi.robot.urdf.urdf_joints import some_of

_USED: Mapping[str, frozenset[str]] = {
    "robot": frozenset(("link", "joint", "material")),
    "link": frozenset(("inertial", "visual", "collision")),
    "joint": frozenset(
        ("origin", "parent", "child", "axis", "limit", "mimic", "safety_controller")
    ),
    "collision": frozenset(("origin", "geometry")),
}
"""Names of the elements that are read, by that of the one that they are in."""
_NAMED = 6


def unused(root: XmlElement) -> tuple[str, ...]:
    """A sentence on what is not used of a robot, its links, their shapes and its joints, if any."""
    found: dict[str, None] = {}
    links = list(root.all("link"))
    shapes = (shape for link in links for shape in link.all("collision"))
    for parent in (root, *links, *shapes, *root.all("joint")):
        for element in parent.xml:
            if element.tag not in _USED[str(parent.xml.tag)]:
                found[str(element.tag)] = None
    if not found:
        return ()
    return (f"Not used: {some_of([*found], _NAMED)}.",)
