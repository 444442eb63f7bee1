"""Names of links that mean something else beside a link's name: the floor, and all obstacles."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

from lxml import etree

OF_THE_WORLD = frozenset(("floor", "obstacles"))
"""Names by which plans and certificates mean parts of the world, and never a link."""
_REFERENCES = ("link", "link1", "link2", "base_link", "tip_link", "parent_link", "child_link")


def names_anew(urdf: etree._Element) -> dict[str, str]:
    """New names of the links of a URDF that are called as a part of the world is, by their own.

    ``floor`` becomes ``floor_link``, or the first of ``floor_link_2``, ... that no link has. Else a
    pair of a link and ``floor`` would have two meanings.
    """
    taken = {link.get("name", "").strip() for link in urdf.iterfind("link")}
    found = {}
    for name in sorted(OF_THE_WORLD & taken):
        usual = f"{name}_link"
        more = (f"{usual}_{k}" for k in itertools.count(2))
        found[name] = next(new for new in itertools.chain([usual], more) if new not in taken)
    return found


def rename_links(root: etree._Element, names: Mapping[str, str]) -> None:
    """Rename links of a URDF, or of its SRDF, in the tree itself, wherever they are named.

    Args:
        root: of the file.
        names: the new names, as :func:`names_anew` finds them in the URDF.
    """
    for element in root.iter("*"):
        references = ("name", *_REFERENCES) if element.tag == "link" else _REFERENCES
        for reference in references:
            new = names.get(element.get(reference, "").strip())
            if new is not None:
                element.set(reference, new)
