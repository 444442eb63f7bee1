"""URDF files of other people's arms: read strictly, from bytes alone.

Nothing that a file names is opened: meshes come from the same folder or upload. Every file that is
damaged, ambiguous or too large is refused in one sentence.
"""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import PurePosixPath
from types import MappingProxyType

import numpy as np
import scipy
from lxml import etree

from abi.arrays import ByteArray, FloatArray, IntArray, read_only
from abi.errors import SceneError
from abi.obstacles.pose import Vec3
from abi.robot.materials import NO_COLOURS, colour_of, materials
from abi.robot.robot import Joint, JointKind, Link, Mimic, Robot, Shape

MAX_BYTES = 2_000_000
MAX_LINKS, MAX_SHAPES, MAX_ELEMENTS = 150, 50, 20_000

_NAMED = 5
"""Links that a sentence names, at most."""

Meshes = Callable[[str], tuple[FloatArray, IntArray, ByteArray]]
"""Vertices, faces and their colours of the mesh file of that name."""

_NUMBER = re.compile(r"[+-]?(\d{1,30}(\.\d{0,30})?|\.\d{1,30})([eE][+-]?\d{1,3})?", re.ASCII)
_NAME = re.compile(r"[\w.+-][\w .:+-]{0,98}", re.ASCII)
_MARKUP = re.compile(r"<!(DOCTYPE|ENTITY|ELEMENT|ATTLIST|NOTATION)")
_DECLARATION = re.compile(r"\A\s*<\?xml[^>]{0,200}\?>")
_KINDS: tuple[JointKind, ...] = ("revolute", "continuous", "prismatic", "fixed")
_TURN = 2 * math.pi
_ZERO: Vec3 = (0.0, 0.0, 0.0)


def read_urdf(content: bytes, name: str, meshes: Meshes) -> Robot:
    """The robot of a URDF's content.

    Args:
        content: of the file.
        name: of the file, for the sentences.
        meshes: source of the mesh files that it names, by their names in the file.

    Raises:
        SceneError: it is no URDF, cut off, not one tree, or a number of it cannot be meant.
    """
    root = _Element(_parse(content, name), name, "robot")
    links: dict[str, Link] = {}
    for element in root.all("link"):
        link = _link(element.called(), meshes)
        if link.name in links:
            raise element.refuse("name", link.name, "a name that no link before it has")
        links[link.name] = link
    if not links or len(links) > MAX_LINKS:
        raise root.refuse("links", len(links), f"1 to {MAX_LINKS}")
    joints = [_joint(element.called()) for element in root.all("joint")]
    ordered, base = _ordered(root, links, joints)
    notes = _add_visuals(root, links, meshes)
    _add_colours(root, links)
    title = root.text("name", "robot")
    return Robot(title, base, MappingProxyType(links), ordered, notes)


def mesh_names(content: bytes, name: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of the mesh files of a URDF, as it is to find them: needed ones, and those for looks.

    Raises:
        SceneError: as :func:`read_urdf`.
    """
    root = _parse(content, name)
    needed: list[str] = []
    looks: list[str] = []
    for link in root.iterfind("link"):
        shape = "visual" if link.find("collision") is None else "collision"
        needed += [
            _file_name(_Element(mesh, name, "mesh")) for mesh in link.iterfind(f"{shape}//mesh")
        ]
        for mesh in link.iterfind("visual//mesh"):
            with contextlib.suppress(SceneError):
                looks.append(_file_name(_Element(mesh, name, "mesh")))
    return tuple(dict.fromkeys(needed)), tuple(k for k in dict.fromkeys(looks) if k not in needed)


def read_srdf(content: bytes, name: str) -> frozenset[frozenset[str]]:
    """Pairs of links that an SRDF takes out of the checks for collisions.

    The format: http://wiki.ros.org/srdf. Nothing else of it is looked at, and a link that the URDF
    does not have counts for nothing.

    Raises:
        SceneError: it is no SRDF, or cut off.
    """
    root = _Element(_parse(content, name), name, "robot")
    pairs = (
        frozenset((pair.text("link1"), pair.text("link2")))
        for pair in root.all("disable_collisions")
    )
    return frozenset(pair for pair in pairs if len(pair) == 2 and all(pair))


class _Element:
    """An XML element, and what it is called in sentences."""

    def __init__(self, element: etree._Element, file: str, title: str) -> None:
        self.xml, self.file, self.title = element, file, title

    def refuse(self, what: str, value: object, expected: str) -> SceneError:
        return SceneError(f"arm.urdf {self.file}: {self.title}, {what}", value, expected)

    def called(self) -> _Element:
        """The same under its own name."""
        name = self.xml.get("name", "")
        tag = str(self.xml.tag)
        if not _NAME.fullmatch(name):
            raise _Element(self.xml, self.file, tag).refuse("name", name, "a plain name")
        return _Element(self.xml, self.file, f"{tag} {name}")

    def all(self, tag: str) -> Iterator[_Element]:
        for element in self.xml.iterfind(tag):
            yield _Element(element, self.file, self.title)

    def child(self, tag: str) -> _Element | None:
        return next(self.all(tag), None)

    def needed(self, tag: str) -> _Element:
        found = self.child(tag)
        if found is None:
            raise self.refuse(tag, None, f"one <{tag}>")
        return found

    def text(self, attribute: str, default: str = "") -> str:
        return str(self.xml.get(attribute, default)).strip()

    def number(self, attribute: str, default: float | None, low: float, high: float) -> float:
        text = self.xml.get(attribute)
        if text is None and default is not None:
            return default
        return self._number(attribute, str(text or ""), low, high)

    def vector(self, attribute: str, default: Vec3, low: float = -100, high: float = 100) -> Vec3:
        text = self.xml.get(attribute)
        if text is None:
            return default
        words = str(text).split()
        if len(words) != 3:
            raise self.refuse(attribute, text, "three numbers")
        x, y, z = (self._number(attribute, word, low, high) for word in words)
        return (x, y, z)

    def _number(self, attribute: str, text: str, low: float, high: float) -> float:
        word = text.strip()
        if len(word) > 40 or not _NUMBER.fullmatch(word) or not low <= float(word) <= high:
            raise self.refuse(attribute, text, f"a number from {low:g} to {high:g}")
        return float(word)


def _parse(content: bytes, name: str) -> etree._Element:
    """Root of the XML, without document types, entities or what only xacro understands."""
    field = f"arm.urdf {name}"
    if len(content) > MAX_BYTES:
        raise SceneError(field, f"{len(content):,} bytes", f"at most {MAX_BYTES // 10**6} MB")
    try:
        wide = content[:2] in (b"\xff\xfe", b"\xfe\xff")
        text = content.decode("utf-16" if wide else "utf-8-sig")
    except UnicodeDecodeError:
        raise SceneError(field, content[:20], "URDF text in UTF-8") from None
    if _MARKUP.search(text):
        raise SceneError(field, _MARKUP.search(text)[0], "no document type and no entities")  # type: ignore[index]
    parser = etree.XMLParser(
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        huge_tree=False,
        recover=False,
        remove_comments=True,
        remove_pis=True,
        encoding="utf-8",
    )
    try:
        # the encoding that the text declares must not matter any more
        root = etree.fromstring(_DECLARATION.sub("", text).encode(), parser)
    except (etree.XMLSyntaxError, ValueError) as error:
        raise SceneError(field, str(error)[:90], "a whole XML text") from None
    for count, element in enumerate(root.iter()):
        values = [str(value) for value in element.attrib.values()]
        if count >= MAX_ELEMENTS:
            raise SceneError(field, f"{count} elements", f"at most {MAX_ELEMENTS:,}")
        if "xacro" in str(element.tag) or any("${" in v or "$(" in v for v in values):
            raise SceneError(field, "xacro", "URDF; write it with: xacro FILE.xacro > FILE.urdf")
    if root.tag != "robot":
        raise SceneError(field, f"<{root.tag}>"[:60], "<robot>, as a URDF begins")
    return root


def _link(element: _Element, meshes: Meshes) -> Link:
    kind = "visual" if element.child("collision") is None else "collision"
    mass, centre, inertia = 0.0, np.zeros(3), np.zeros((3, 3))
    inertial = element.child("inertial")
    if inertial is not None:
        pose = _origin(inertial)
        mass = inertial.needed("mass").number("value", None, 0, 1e5)
        centre, turn = pose[:3, 3], pose[:3, :3]
        inertia = turn @ _tensor(inertial) @ turn.T
    return Link(
        element.text("name"),
        _shapes(element, kind, meshes),
        mass,
        read_only(centre.copy()),
        read_only(inertia),
    )


def _add_visuals(root: _Element, links: dict[str, Link], meshes: Meshes) -> tuple[str, ...]:
    """Give links what they are drawn with beside their shapes; the sentence on what was left out.

    It comes after all shapes, so that looks take no triangles from them.
    """
    plain: list[str] = []
    for element in root.all("link"):
        link = links[element.text("name")]
        if element.child("collision") is not None:
            try:
                visuals = _shapes(element, "visual", meshes)
                if not _are_same(visuals, link.shapes):
                    links[link.name] = replace(link, visuals=visuals)
            except SceneError:
                plain.append(link.name)
    if not plain:
        return ()
    names = ", ".join(plain[:_NAMED])
    more = f" and {len(plain) - _NAMED} more" if len(plain) > _NAMED else ""
    return (f"Drawn by collision shapes, as visuals cannot be read: {names}{more}.",)


def _are_same(first: Sequence[Shape], second: Sequence[Shape]) -> bool:
    """Whether shapes are the same solids at the same places."""
    return len(first) == len(second) and all(
        (a.kind, a.size) == (b.kind, b.size)
        and np.array_equal(a.pose, b.pose)
        and np.array_equal(a.vertices, b.vertices)
        for a, b in zip(first, second, strict=True)
    )


def _add_colours(root: _Element, links: dict[str, Link]) -> None:
    """Give what links are drawn with the colours of their materials, which go before a mesh's own.

    Shapes that stand for visuals take the first one's.
    """
    named = materials(root.xml)
    for element in root.all("link"):
        link = links[element.text("name")]
        given = [colour_of(visual.xml, named) for visual in element.all("visual")]
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


def _shapes(element: _Element, kind: str, meshes: Meshes) -> tuple[Shape, ...]:
    shapes = list(element.all(kind))
    if len(shapes) > MAX_SHAPES:
        raise element.refuse("shapes", len(shapes), f"at most {MAX_SHAPES}")
    return tuple(_shape(shape, meshes) for shape in shapes)


def _tensor(inertial: _Element) -> FloatArray:
    part = inertial.needed("inertia")
    xx, yy, zz = (part.number(name, None, 0, 1e6) for name in ("ixx", "iyy", "izz"))
    xy, xz, yz = (part.number(name, 0.0, -1e6, 1e6) for name in ("ixy", "ixz", "iyz"))
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _shape(element: _Element, meshes: Meshes) -> Shape:
    geometry = element.needed("geometry")
    pose = _origin(element)
    vertices, faces, colours = np.empty((0, 3)), np.empty((0, 3), dtype=np.int32), NO_COLOURS
    part = next((_Element(x, element.file, element.title) for x in geometry.xml), None)
    kind = None if part is None else part.xml.tag
    if part is None or kind not in ("box", "sphere", "cylinder", "mesh"):
        raise element.refuse("geometry", kind, "box, sphere, cylinder or mesh")
    if kind == "box":
        size = part.vector("size", _ZERO, 1e-9, 100)
    elif kind == "sphere":
        size = (part.number("radius", None, 1e-9, 100), 0.0, 0.0)
    elif kind == "cylinder":
        size = (part.number("radius", None, 1e-9, 100), part.number("length", None, 1e-9, 100), 0.0)
    else:
        size = part.vector("scale", (1.0, 1.0, 1.0), -1e4, 1e4)
        vertices, faces, colours = meshes(_file_name(part))
        vertices = vertices * size
        if not np.isfinite(vertices).all() or np.abs(vertices).max(initial=0) > 100:
            raise part.refuse("scale", size, "a mesh of at most 100 m")
        if math.prod(size) < 0:
            faces = faces[:, ::-1]
    if kind == "box" and not all(size):
        raise part.refuse("size", None, "three numbers above 0")
    return Shape(
        str(kind),  # type: ignore[arg-type]
        size,
        pose,
        read_only(np.ascontiguousarray(vertices)),
        read_only(np.ascontiguousarray(faces, dtype=np.int32)),
        read_only(colours),
    )


def _file_name(mesh: _Element) -> str:
    """Name of a mesh file without its scheme; only a place inside the upload is one."""
    text = mesh.text("filename")
    path = re.sub(r"\Apackage://[^/]*/", "", text)
    parts = PurePosixPath(path).parts
    if not path or "://" in path or path.startswith("/") or ".." in parts or "\\" in path:
        raise mesh.refuse("mesh filename", text, "a file beside the URDF or below it")
    return path


def _joint(element: _Element) -> Joint:
    kind = element.text("type")
    if kind not in _KINDS:
        raise element.refuse("type", kind, f"one of {', '.join(_KINDS)}")
    axis_of, limit = element.child("axis"), element.child("limit")
    axis = np.array((1.0, 0.0, 0.0) if axis_of is None else axis_of.vector("xyz", (1.0, 0.0, 0.0)))
    if not np.linalg.norm(axis) > 1e-6:
        raise element.refuse("axis", tuple(axis.tolist()), "a direction")
    if kind in ("revolute", "prismatic") and limit is None:
        raise element.refuse("limit", None, "<limit> with lower and upper")
    low, high = (-_TURN, _TURN) if kind == "continuous" else (0.0, 0.0)
    speed = effort = math.inf
    if limit is not None and kind != "fixed":
        if kind != "continuous":
            low, high = (limit.number(side, 0.0, -1e3, 1e3) for side in ("lower", "upper"))
        if low > high:
            raise element.refuse("limit", (low, high), "lower at most upper")
        # many files have 0 where they mean no limit
        speed, effort = (
            limit.number(name, 0.0, 0, 1e9) or math.inf for name in ("velocity", "effort")
        )
    return Joint(
        name=element.text("name"),
        kind=kind,
        parent=element.needed("parent").text("link"),
        child=element.needed("child").text("link"),
        origin=_origin(element),
        axis=read_only(axis / np.linalg.norm(axis)),
        low=low,
        high=high,
        speed=speed,
        effort=effort,
        mimic=_mimic(element),
    )


def _mimic(element: _Element) -> Mimic | None:
    mimic = element.child("mimic")
    if mimic is None:
        return None
    factor = mimic.number("multiplier", 1.0, -1e3, 1e3)
    return Mimic(mimic.text("joint"), factor, mimic.number("offset", 0.0, -1e3, 1e3))


def _origin(element: _Element) -> FloatArray:
    pose = np.eye(4)
    origin = element.child("origin")
    if origin is not None:
        pose[:3, 3] = origin.vector("xyz", _ZERO)
        # about the fixed axes x, y and z in that order
        turn = scipy.spatial.transform.Rotation.from_euler("xyz", origin.vector("rpy", _ZERO))
        pose[:3, :3] = turn.as_matrix()
    return read_only(pose)


def _ordered(
    root: _Element, links: dict[str, Link], joints: Sequence[Joint]
) -> tuple[tuple[Joint, ...], str]:
    """The joints, parents first, and the root link of the one tree that they make."""
    names = [joint.name for joint in joints]
    for joint in joints:
        if names.count(joint.name) > 1:
            raise root.refuse("joints", joint.name, "every name once")
        for side, link in (("parent", joint.parent), ("child", joint.child)):
            if link not in links:
                raise root.refuse(f"joint {joint.name}, {side}", link, "the name of a link")
    carried = [joint.child for joint in joints]
    for link in carried:
        if carried.count(link) > 1:
            raise root.refuse(f"link {link}", f"child of {carried.count(link)} joints", "of one")
    roots = [name for name in links if name not in carried]
    if len(roots) != 1:
        expected = "one link that is no joint's child"
        raise root.refuse("roots", ", ".join(roots[:4]) or "none, a cycle", expected)
    ordered: list[Joint] = []
    reached = [roots[0]]
    for parent in reached:
        for joint in joints:
            if joint.parent == parent:
                ordered.append(joint)
                reached.append(joint.child)
    if len(reached) < len(links):
        lost = next(name for name in links if name not in reached)
        raise root.refuse("links", lost, f"a tree from {roots[0]}, this is in a cycle")
    _check_mimics(root, ordered)
    return tuple(ordered), roots[0]


def _check_mimics(root: _Element, joints: Sequence[Joint]) -> None:
    """Refuse what follows a joint that there is not, or that itself follows another."""
    free = {joint.name for joint in joints if joint.mimic is None and joint.kind != "fixed"}
    for joint in joints:
        if joint.mimic is not None and joint.mimic.joint not in free:
            expected = "a joint that moves by itself"
            raise root.refuse(f"joint {joint.name}, mimic", joint.mimic.joint, expected)
