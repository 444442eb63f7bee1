"""Colours that a URDF gives its visuals, directly or by the name of a material.

The format: http://wiki.ros.org/urdf/XML/link. A colour that cannot be read is ignored.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from lxml import etree

from abi.arrays import ByteArray, read_only

NO_COLOURS: ByteArray = read_only(np.empty((0, 3), dtype=np.uint8))
"""Colours of a visual without any."""


def materials(root: etree._Element) -> Mapping[str, ByteArray]:
    """Colours (1, 3) of a robot's materials by name; those of the robot element take precedence."""
    found: dict[str, ByteArray] = {}
    for material in (*root.iterfind("material"), *root.iterfind("link/visual/material")):
        colour, name = _colour(material), str(material.get("name", ""))
        if len(colour) and name:
            found.setdefault(name, colour)
    return found


def colour_of(visual: etree._Element, named: Mapping[str, ByteArray]) -> ByteArray:
    """Colour (1, 3) of a visual's material; (0, 3) if it gives none.

    Args:
        visual: the element.
        named: colours of materials by their names.
    """
    material = visual.find("material")
    if material is None:
        return NO_COLOURS
    own = _colour(material)
    return own if len(own) else named.get(str(material.get("name", "")), NO_COLOURS)


def _colour(material: etree._Element) -> ByteArray:
    element = material.find("color")
    words = [] if element is None else str(element.get("rgba", "")).split()
    try:
        numbers = np.array([float(word) for word in words[:3]])
    except ValueError:
        return NO_COLOURS
    if len(words) not in (3, 4) or not ((numbers >= 0) & (numbers <= 1)).all():
        return NO_COLOURS
    return read_only(np.rint(255 * numbers).astype(np.uint8)[None])
