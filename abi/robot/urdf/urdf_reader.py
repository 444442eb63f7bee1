"""Strict reader of URDF files from bytes.

Nothing that a file names is opened: meshes come from the same folder or upload. A file that is
damaged, ambiguous or too large is refused with one sentence.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from abi.errors import MISSING
from abi.robot.urdf.couplings import coupling_notes, read_couplings, unfollowed_notes
from abi.robot.urdf.joint import Joint
from abi.robot.urdf.link import Link
from abi.robot.urdf.link_names import names_anew, rename_links
from abi.robot.urdf.mimic import with_masters
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.strict_xml import XmlElement, parse
from abi.robot.urdf.unused_elements import unused
from abi.robot.urdf.urdf_joints import in_order, read_joint, some_of
from abi.robot.urdf.urdf_links import Meshes, add_colours, add_visuals, read_link
from abi.robot.urdf.urdf_masses import has_sense

MAX_LINKS = 150


def read_urdf(content: bytes, name: str, meshes: Meshes) -> Robot:
    """Read the robot of a URDF's content.

    Args:
        content: of the file.
        name: of the file, for the sentences.
        meshes: source of the mesh files that it names, by their names in the file.

    Raises:
        SceneError: it is no URDF, truncated, not a single tree, or has a number without sense.
    """
    root = XmlElement(parse(content, name), name, "robot")
    renamed = names_anew(root.xml)
    rename_links(root.xml, renamed)
    elements = [element.called() for element in root.all("link")]
    weightless = [one.text("name") for one in elements if not has_sense(one)]
    links: dict[str, Link] = {}
    for element in elements:
        link = read_link(element, meshes, not weightless)
        if link.name in links:
            raise element.refuse("name", link.name, "a name that no link before it has")
        links[link.name] = link
    if not links:
        raise root.refuse("link", MISSING, "one or more, as a file without links holds no robot")
    if len(links) > MAX_LINKS:
        raise root.refuse("links", len(links), f"1 to {MAX_LINKS}")
    joints = [read_joint(element.called()) for element in root.all("joint")]
    ordered, base = in_order(root, links, joints)
    couplings = read_couplings(root, ordered, base)
    ordered = with_masters(root, ordered)
    notes = [*add_visuals(root, links, meshes)]
    notes += [f"{note} {some_of(named)}." for note, named in root.told.items()]
    if weightless:
        notes.append(f"No torques, as masses make no sense: {some_of(weightless)}.")
    notes += _bare_links(links, ordered)
    notes += [
        f"Link {name} is called {new} here, for {name} is the world's."
        for name, new in renamed.items()
    ]
    notes += [*unused(root), *coupling_notes(couplings), *unfollowed_notes(root, ordered)]
    add_colours(root, links)
    title = root.text("name", "robot")
    return Robot(title, base, links, ordered, tuple(notes), couplings=couplings)


def _bare_links(links: Mapping[str, Link], joints: Sequence[Joint]) -> list[str]:
    """A sentence on joints that move no shape before the next joint; none if all move one.

    Args:
        links: by name.
        joints: parents first.
    """
    moved_by: dict[str, str] = {}
    for joint in joints:
        if joint.kind != "fixed":
            moved_by[joint.child] = joint.child
        elif joint.parent in moved_by:
            moved_by[joint.child] = moved_by[joint.parent]
    shaped = {first for name, first in moved_by.items() if links[name].shapes}
    bare = [first for name, first in moved_by.items() if name == first and first not in shaped]
    if not shaped:
        slides = [one.name for one in joints if one.kind == "prismatic" and one.low < one.high]
        but = f", but none where a slide goes: {some_of(slides)}" if slides else ""
        return [f"No link that moves has a shape: lines from joint to joint stand for them{but}."]
    return [f"Nothing is proven of links without a shape: {some_of(bare)}."] if bare else []
