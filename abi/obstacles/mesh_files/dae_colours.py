"""Colours of the materials of a DAE file; unsupported ones are left out."""

from __future__ import annotations

from collections.abc import Mapping
from urllib.parse import unquote

import numpy as np
from lxml import etree

from abi.arrays import ByteArray
from abi.obstacles.mesh_files.dae_geometry import Primitive
from abi.obstacles.mesh_files.parts import NO_COLOURS, Parts
from abi.obstacles.mesh_files.words import float_words
from abi.obstacles.mesh_files.xml_document import name_of

_WHITE = np.full((1, 3), 255, dtype=np.uint8)
"""Colour of a material with a texture, which is not read."""


class Colours:
    """Colours (1, 3) of the materials, found by the symbols of primitives."""

    def __init__(self, root: etree._Element) -> None:
        self._by_material: dict[str, ByteArray] = {}
        effects = {str(one.get("id")): one for one in root.iter("{*}effect")}
        for material in root.iter("{*}material"):
            instance = material.find("{*}instance_effect")
            url = "" if instance is None else str(instance.get("url", ""))
            effect = effects.get(unquote(url.removeprefix("#")))
            if effect is not None:
                self._by_material[f"#{material.get('id')}"] = _diffuse(effect)

    def bound(self, instance: etree._Element) -> Mapping[str, ByteArray]:
        """Colours by the symbols that a geometry's instance binds."""
        return {
            str(one.get("symbol")): self._by_material[target]
            for one in instance.iter("{*}instance_material")
            if (target := unquote(str(one.get("target")))) in self._by_material
        }

    def painted(self, primitive: Primitive, bound: Mapping[str, ByteArray]) -> Parts:
        """The triangles in the colour of their symbol."""
        colour = bound.get(primitive.material, NO_COLOURS)
        if not len(colour):
            return primitive.parts
        return primitive.parts._replace(colours=np.repeat(colour, len(primitive.parts.faces), 0))


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
