"""Lengths of units by the names that mesh files have for them."""

from __future__ import annotations

import re
from collections.abc import Mapping

from abi.obstacles.mesh_files.words import shown

METRES: Mapping[str, float] = {
    **{"micron": 1e-6, "millimeter": 1e-3, "centimeter": 1e-2, "meter": 1.0},
    **{"inch": 0.0254, "foot": 0.3048},
}
_OTHERS: Mapping[str, float] = {
    **{"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254, "ft": 0.3048, "feet": 0.3048},
    **{"inches": 0.0254, "micrometer": 1e-6, "um": 1e-6, "yard": 0.9144, "kilometer": 1e3},
    **{"yd": 0.9144, "km": 1e3, "dm": 0.1, "decimeter": 0.1, "nm": 1e-9, "nanometer": 1e-9},
    **{"thou": 2.54e-5, "mil": 2.54e-5, "mile": 1609.344},
}
_COMMENT = re.compile(
    r"\bunits?[ \t]*[=:][ \t]*([a-z]{1,20})[ \t\0]*$", re.IGNORECASE | re.MULTILINE
)


def length_of(name: str) -> float | None:
    """Length of the unit of a name such as ``inches``, [m]; None if it is not known."""
    word = name.strip().lower().replace("metre", "meter")
    singular = word if word in _OTHERS else word.removesuffix("s")
    return METRES.get(singular, _OTHERS.get(singular))


def commented(text: str) -> tuple[float | None, tuple[str, ...]]:
    """Unit that comments name, as in ``File units = inches``.

    Returns:
        Its length, [m], None for none; and a sentence on each name that is not known.

    Raises:
        ValueError: they name several.
    """
    lengths = {word: length_of(word) for word in _COMMENT.findall(text)}
    found = set(lengths.values()) - {None}
    if len(found) > 1:
        raise ValueError("a mesh of one unit, its comments name several")
    unknown = [word for word, length in lengths.items() if length is None]
    notes = tuple(f"The unit {shown(word)} that a comment names is not known." for word in unknown)
    return found.pop() if found else None, notes
