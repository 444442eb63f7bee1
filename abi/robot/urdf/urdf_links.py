"""Links of a URDF: their collision shapes, visuals, colours and masses.

The format: http://wiki.ros.org/urdf/XML/link. A colour that cannot be read is ignored.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from lxml import etree

from abi.arrays import ByteArray, FloatArray, read_only
from abi.errors import MISSING, SceneError
from abi.obstacles.mesh_files.parts import NO_COLOURS, Parts
from abi.robot.urdf.link import Link, LinkShape
from abi.robot.urdf.strict_xml import XmlElement
from abi.robot.urdf.urdf_joints import some_of
from abi.robot.urdf.urdf_masses import WEIGHTLESS, read_inertial
from abi.robot.urdf.urdf_meshes import file_name

MAX_SHAPES = 50
_KINDS = ("box", "sphere", "cylinder", "capsule", "mesh")
_LARGEST = 1000.0
"""Largest coordinate or size of a shape, [m]."""

Meshes = Callable[[str], Parts]
"""Function from the name of a mesh file to its vertices, faces and colours."""


def read_link(element: XmlElement, meshes: Meshes, masses: bool = True) -> Link:
    """Read a link with its mass and its collision shapes.

    Args:
        element: the link.
        meshes: source of the mesh files that it names.
        masses: whether its mass counts.

    Raises:
        SceneError: one of its numbers or meshes makes no sense.
    """
    kind = "visual" if next(element.all("collision"), None) is None else "collision"
    inertial = read_inertial(element) if masses else WEIGHTLESS
    return Link(element.text("name"), _shapes(element, kind, meshes), *inertial)


def add_visuals(root: XmlElement, links: dict[str, Link], meshes: Meshes) -> tuple[str, ...]:
    """Add visuals to the links, and return a sentence on what was left out.

    Visuals come after all shapes, so that they take no triangles from these.
    """
    plain: list[str] = []
    for element in root.all("link"):
        link = links[element.text("name")]
        if next(element.all("collision"), None) is not None:
            try:
                visuals = _shapes(element, "visual", meshes)
                if not _are_same(visuals, link.shapes):
                    links[link.name] = replace(link, visuals=visuals)
            except SceneError:
                plain.append(link.name)
    if not plain:
        return ()
    return (f"Drawn by collision shapes, as visuals cannot be read: {some_of(plain)}.",)


def _are_same(first: Sequence[LinkShape], second: Sequence[LinkShape]) -> bool:
    """Check whether shapes are the same solids at the same places."""
    return len(first) == len(second) and all(
        (a.kind, a.size) == (b.kind, b.size)
        and np.array_equal(a.pose, b.pose)
        and np.array_equal(a.vertices, b.vertices)
        for a, b in zip(first, second, strict=True)
    )


def add_colours(root: XmlElement, links: dict[str, Link]) -> None:
    """Colour visuals by their materials, which take precedence over a mesh's colours.

    Shapes that stand for visuals take the first visual's colour.
    """
    named = _materials(root.xml)
    for element in root.all("link"):
        link = links[element.text("name")]
        given = [_colour_of(visual.xml, named) for visual in element.all("visual")]
        if not any(map(len, given)):
            continue
        if len(given) != len(link.drawn):
            given = [given[0]] * len(link.drawn)
        drawn = tuple(
            replace(shape, colours=colour) if len(colour) else shape
            for shape, colour in zip(link.drawn, given, strict=True)
        )
        changed = replace(link, visuals=drawn) if link.visuals else replace(link, shapes=drawn)
        links[link.name] = changed


def _shapes(element: XmlElement, kind: str, meshes: Meshes) -> tuple[LinkShape, ...]:
    shapes = list(element.all(kind))
    if len(shapes) > MAX_SHAPES:
        raise element.refuse("shapes", len(shapes), f"at most {MAX_SHAPES}")
    return tuple(solid for shape in shapes for solid in _solids(shape, meshes))


def _solids(element: XmlElement, meshes: Meshes) -> Iterator[LinkShape]:
    """Solids of a shape; of a capsule its cylinder and both its balls."""
    geometry = element.needed("geometry")
    solids = [str(x.tag) for one in element.all("geometry") for x in one.xml if x.tag in _KINDS]
    if len(solids) > 1:
        raise element.refuse("geometry", " and ".join(solids[:4]), "one solid; give each its own")
    part = next(
        (XmlElement(x, element.file, element.title, element.told) for x in geometry.xml), None
    )
    kind = None if part is None else part.xml.tag
    if part is None or kind not in _KINDS:
        raise element.refuse("geometry", kind, f"{', '.join(_KINDS[:-1])} or {_KINDS[-1]}")
    if kind != "capsule":
        yield _shape(part, str(kind), element.origin(), meshes)
        return
    yield _shape(part, "cylinder", element.origin(), meshes)
    for end in (-0.5, 0.5):
        pose = element.origin().copy()
        pose[:3, 3] += end * part.number("length", None, 1e-9, _LARGEST) * pose[:3, 2]
        yield _shape(part, "sphere", read_only(pose), meshes)


def _shape(part: XmlElement, kind: str, pose: FloatArray, meshes: Meshes) -> LinkShape:
    vertices, faces, colours = np.empty((0, 3)), np.empty((0, 3), dtype=np.int32), NO_COLOURS
    if kind == "box":
        size = part.vector("size", (0.0, 0.0, 0.0), 1e-9, _LARGEST)
    elif kind == "sphere":
        size = (part.number("radius", None, 1e-9, _LARGEST), 0.0, 0.0)
    elif kind == "cylinder":
        size = (
            part.number("radius", None, 1e-9, _LARGEST),
            part.number("length", None, 1e-9, _LARGEST),
            0.0,
        )
    else:
        size = part.vector("scale", (1.0, 1.0, 1.0), -1e4, 1e4)
        if not all(size):
            raise part.refuse("scale", size, "three numbers other than 0")
        vertices, faces, colours = meshes(file_name(part))
        vertices = vertices * size
        if not np.isfinite(vertices).all() or np.abs(vertices).max(initial=0) > _LARGEST:
            raise part.refuse("scale", size, f"a mesh of at most {_LARGEST:g} m")
        if math.prod(size) < 0:
            faces = faces[:, ::-1]
    if kind == "box" and not all(size):
        raise part.refuse("size", MISSING, "three numbers above 0")
    return LinkShape(
        kind,  # type: ignore[arg-type]
        size,
        pose,
        read_only(np.ascontiguousarray(vertices)),
        read_only(np.ascontiguousarray(faces, dtype=np.int32)),
        read_only(colours),
    )


def _materials(root: etree._Element) -> Mapping[str, ByteArray]:
    """Colours (1, 3) of a robot's materials by name; those of the robot element take precedence."""
    found: dict[str, ByteArray] = {}
    for material in (*root.iterfind("material"), *root.iterfind("link/visual/material")):
        colour, name = _colour(material), str(material.get("name", ""))
        if len(colour) and name:
            found.setdefault(name, colour)
    return found


def _colour_of(visual: etree._Element, named: Mapping[str, ByteArray]) -> ByteArray:
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
