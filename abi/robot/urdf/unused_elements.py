"""Elements and attributes of a URDF that planning does not use, named once."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping

from abi.robot.urdf.strict_xml import XmlElement
from abi.robot.urdf.urdf_joints import some_of

_SHAPE = frozenset(("origin", "geometry", "material"))
_SOLIDS = frozenset(("box", "sphere", "cylinder", "capsule", "mesh"))
_ELEMENTS: Mapping[str, frozenset[str]] = {
    "robot": frozenset(("link", "joint", "material")),
    "link": frozenset(("inertial", "visual", "collision")),
    "joint": frozenset(
        ("origin", "parent", "child", "axis", "limit", "mimic", "safety_controller")
    ),
    **{"collision": _SHAPE, "visual": _SHAPE, "geometry": _SOLIDS},
}
"""Names of the elements that are read, by that of the one that they are in."""
_ATTRIBUTES: Mapping[str, frozenset[str]] = {
    **{"origin": frozenset(("xyz", "rpy", "quat_xyzw")), "axis": frozenset(("xyz",))},
    **{"parent": frozenset(("link",)), "child": frozenset(("link",))},
    **{"box": frozenset(("size",)), "sphere": frozenset(("radius",))},
    **{kind: frozenset(("radius", "length")) for kind in ("cylinder", "capsule")},
    **{"mesh": frozenset(("filename", "scale")), "geometry": frozenset()},
    "mimic": frozenset(("joint", "multiplier", "offset")),
    "limit": frozenset(("lower", "upper", "velocity", "effort")),
}
"""The same of attributes, where another could move or change something."""
_NAMED = 6


def unused(root: XmlElement) -> tuple[str, ...]:
    """Sentences on what is not used of a robot, its links, their shapes and its joints, if any."""
    found: dict[str, None] = {}
    waiting = deque([root.xml])
    while waiting:
        parent = waiting.popleft()
        tag = str(parent.tag)
        for name in map(str, parent.attrib):
            if tag in _ATTRIBUTES and name not in (*_ATTRIBUTES[tag], "name"):
                found[f"{name} of <{tag}>"] = None
        for element in parent:
            if element.tag in _ELEMENTS.get(tag, ()):
                if element.tag != "visual" or parent.find("collision") is None:
                    waiting.append(element)
            elif tag in ("material", "inertial", "safety_controller"):
                continue
            else:
                found[str(element.tag)] = None
    return (f"Not used: {some_of([*found], _NAMED)}.",) if found else ()
