"""Names of links that mean something else beside a link's name: the floor, and all obstacles."""

from __future__ import annotations

from lxml import etree

OF_THE_WORLD = frozenset(("floor", "obstacles"))
"""Names by which plans and certificates mean parts of the world, and never a link."""
_REFERENCES = ("link", "link1", "link2", "base_link", "tip_link", "parent_link", "child_link")


def rename_links(root: etree._Element) -> tuple[str, ...]:
    """Rename the links of a URDF or SRDF that are called as a part of the world is.

    ``floor`` becomes ``floor_link``, in the tree itself, wherever it is named. Else a pair of a
    link and ``floor`` would have two meanings.

    Returns:
        Sentences on links of the file with such a name.
    """
    notes = []
    for element in root.iter("*"):
        if element.tag == "link" and element.get("name", "").strip() in OF_THE_WORLD:
            name = element.get("name", "").strip()
            element.set("name", f"{name}_link")
            if element.getparent() is root:
                notes.append(f"Link {name} is called {name}_link here, for {name} is the world's.")
        for reference in _REFERENCES:
            if element.get(reference, "").strip() in OF_THE_WORLD:
                element.set(reference, f"{element.get(reference, '').strip()}_link")
    return tuple(notes)
