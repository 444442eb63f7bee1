"""Colours of the materials of a DAE file; unsupported ones are left out."""

from __future__ import annotations

from collections.abc import Mapping
from urllib.parse import unquote

import numpy as np
from lxml import etree

from abi.arrays import ByteArray
from abi.obstacles.mesh_files.parts import Parts
from abi.obstacles.mesh_files.words import float_words
from abi.obstacles.mesh_files.xml_document import name_of

_WHITE = np.full((1, 3), 255, dtype=np.uint8)
"""Colour of a material with a texture, which is not read."""


def colours_of(root: etree._Element) -> dict[str, ByteArray]:
    """Colours (1, 3) of a file's materials, by their urls."""
    found: dict[str, ByteArray] = {}
    effects = {str(one.get("id")): one for one in root.iter("{*}effect")}
    for material in root.iter("{*}material"):
        instance = material.find("{*}instance_effect")
        url = "" if instance is None else str(instance.get("url", ""))
        effect = effects.get(unquote(url.removeprefix("#")))
        if effect is not None:
            found[f"#{material.get('id')}"] = _diffuse(effect)
    return found


def bound(instance: etree._Element, colours: Mapping[str, ByteArray]) -> dict[str, ByteArray]:
    """Colours by the symbols that a geometry's instance binds."""
    return {
        str(one.get("symbol")): colours[target]
        for one in instance.iter("{*}instance_material")
        if (target := unquote(str(one.get("target")))) in colours
    }


def painted(parts: Parts, colour: ByteArray | None) -> Parts:
    """Triangles in a colour (1, 3), if there is one."""
    return (
        parts if colour is None else parts._replace(colours=np.repeat(colour, len(parts.faces), 0))
    )


def _diffuse(effect: etree._Element) -> ByteArray:
    """Diffuse colour (1, 3) of an effect."""
    diffuse = next(effect.iter("{*}diffuse"), None)
    if diffuse is None or not len(diffuse):
        return _WHITE
    element = diffuse[0]
    if name_of(element) == "param":
        wanted = [one for one in effect.iter("{*}newparam") if one.get("sid") == element.get("ref")]
        element = next((child for one in wanted for child in one), element)
    try:
        numbers = float_words("".join(element.itertext()).encode().split(), "")[:3]
    except ValueError:
        return _WHITE
    if len(numbers) != 3 or not np.isfinite(numbers).all():
        return _WHITE
    return np.rint(255 * np.clip(numbers, 0, 1)).astype(np.uint8)[None]
