"""Reader of 3MF files (3MF Core Specification 1.3, Production Extension 1.1).

It reads what the build section places: objects, their components, and those of other model parts in
the archive. What could add surfaces that are not triangles, such as beams, is refused.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from urllib.parse import unquote

import numpy as np
from lxml import etree

from abi.arrays import FloatArray
from abi.obstacles.mesh_files.parts import MeshFile, Parts, check_count, joined, placed
from abi.obstacles.mesh_files.units import METRES
from abi.obstacles.mesh_files.words import counted, float_words, shown
from abi.obstacles.mesh_files.xml_document import (
    affine,
    check_items,
    child,
    children,
    integer,
    name_of,
    parse,
    where,
)
from abi.obstacles.mesh_files.zip_archive import unpacked

_MOST_PLACED, _DEEPEST = 10_000, 32
_PLAIN = {
    "http://schemas.microsoft.com/3dmanufacturing/core/2015/02",
    "http://schemas.microsoft.com/3dmanufacturing/material/2015/02",
    "http://schemas.microsoft.com/3dmanufacturing/production/2015/06",
    "http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07",
}
"""Extensions that add no surfaces of their own, or that are read here."""
_PATH = "{http://schemas.microsoft.com/3dmanufacturing/production/2015/06}path"
_ROOT = "3d/3dmodel.model"
_MODEL = re.compile(r"(?!__macosx/)(.*/)?(?!\._)[^/]*\.model")
"""Names of models, but not of what a file manager writes beside them."""
_PARTS = ("metadata", "resources", "build")

_Key = tuple[str, int]
"""Path of a model part, and id of an object in it."""


_Placed = tuple[_Key, FloatArray]
"""An object with its pose (4, 4)."""


def read(data: bytes, most_faces: int) -> MeshFile:
    """Triangles of a 3MF file where its build section places them.

    Raises:
        ValueError: says what it ought to be.
    """
    files = unpacked(data)
    check_items(content for name, content in files.items() if name.endswith((".model", ".rels")))
    package = _Package(files)
    meshes: dict[_Key, Parts] = {}
    parts: list[Parts] = []
    count, steps = 0, 0
    waiting = [(*one, 0) for one in package.items()]  # with depths of nesting as components
    while waiting:
        key, pose, depth = waiting.pop()
        steps += 1
        if steps > _MOST_PLACED or depth > _DEEPEST:
            raise ValueError("a 3MF file of at most 10,000 objects that do not contain themselves")
        element = package.object(key)
        if (mesh := child(element, "mesh")) is not None:
            if key not in meshes:
                meshes[key] = _mesh(mesh)
            count += len(meshes[key].faces)
            if count > most_faces:
                check_count(count, most_faces)
            parts.append(placed(meshes[key], pose))
        waiting += [(one, pose @ inner, depth + 1) for one, inner in package.components(key)]
    check_count(count, most_faces)
    return MeshFile(joined(parts), package.metres, package.left_out())


def root_model(files: Mapping[str, bytes]) -> str:
    """Name of the root model part of an archive.

    Raises:
        ValueError: there is none.
    """
    name = _ROOT
    if "_rels/.rels" in files:
        for one in children(parse(files["_rels/.rels"], "Relationships"), "Relationship"):
            if str(one.get("Type", "")).lower().endswith("/3dmodel"):
                name = part_name(str(one.get("Target", "")), files)
                break
    if name not in files:
        raise ValueError(f"a 3MF file with its model {shown(name)}")
    return name


def part_name(path: str, files: Mapping[str, bytes]) -> str:
    """Name in the archive of a part's path, in which letters may be percent-encoded."""
    name = path.strip().lstrip("/").lower()
    return name if name in files else unquote(name)


class _Package:
    """The model parts of an archive, parsed at their first use."""

    def __init__(self, files: Mapping[str, bytes]) -> None:
        self._files = files
        self._objects: dict[str, dict[int, etree._Element]] = {}
        self._used: set[_Key] = set()
        self._unknown: dict[str, None] = {}
        self._root_name = root_model(files)
        self._root = self._part(self._root_name)
        self.metres = self._unit(self._root)

    def items(self) -> Iterator[_Placed]:
        """The items of the build section."""
        build = child(self._root, "build")
        for item in self._known(build, "item") if build is not None else ():
            yield self._reference(item, self._root_name)

    def object(self, key: _Key) -> etree._Element:
        """Find an object all of whose parts can be read."""
        path, number = key
        if path not in self._objects:
            self._part(path)
        found = self._objects[path].get(number)
        if found is None:
            raise ValueError(f"a whole 3MF file, object {number} is not in {shown(path)}")
        self._used.add(key)
        for one in found:
            _refuse_unknown(one, ("mesh", "components", "metadatagroup"))
        if child(found, "mesh", "components") is None:
            raise ValueError(f"3MF objects with triangles, {where(found)} has none")
        return found

    def components(self, key: _Key) -> list[_Placed]:
        """Components of an object, each posed in it."""
        group = child(self._objects[key[0]][key[1]], "components")
        if group is None:
            return []
        return [self._reference(one, key[0]) for one in self._known(group, "component")]

    def _known(self, group: etree._Element, name: str) -> list[etree._Element]:
        """Children of that name; the names of others are kept for a note."""
        self._unknown |= dict.fromkeys(
            {name_of(one): None for one in group if name_of(one) != name}
        )
        return children(group, name)

    def left_out(self) -> tuple[str, ...]:
        """Sentences on the objects that the build section does not place."""
        notes = [f"What its <{name[:40]}> says is left out." for name in self._unknown]
        if unplaced := sum(map(len, self._objects.values())) - len(self._used):
            notes.append(f"{counted(unplaced, 'object')} left out: not in the build.")
        models = [name for name in self._files if _MODEL.fullmatch(name)]
        if unread := len(set(models) - self._objects.keys()):
            notes.append(f"{counted(unread, 'model part')} left out: nothing refers there.")
        return tuple(notes)

    def _part(self, name: str) -> etree._Element:
        if name not in self._files:
            raise ValueError(f"a whole 3MF file, {shown(name)} is missing")
        root = parse(self._files[name], "model")
        parts = (name_of(one) for one in root)
        self._unknown |= {one: None for one in parts if one not in _PARTS}
        for prefix in str(root.get("requiredextensions", "")).split():
            space = root.nsmap.get(prefix, prefix)
            if space not in _PLAIN:
                raise ValueError(f"a 3MF file without extensions, it needs {shown(space[-40:])}")
        resources = child(root, "resources")
        found = children(resources, "object") if resources is not None else []
        objects = {integer(one, "id"): one for one in found}
        if len(objects) < len(found):
            raise ValueError(f"3MF objects with different ids in {shown(name)}")
        self._objects[name] = objects
        if self._objects.keys() - {name} and self._unit(root) != self.metres:
            raise ValueError(f"a 3MF file of one unit, {shown(name)} has another")
        return root

    def _unit(self, root: etree._Element) -> float:
        unit = str(root.get("unit", "millimeter"))
        if unit not in METRES:
            raise ValueError(f"a 3MF unit such as millimeter or inch, not {shown(unit)}")
        return METRES[unit]

    def _reference(self, element: etree._Element, path: str) -> _Placed:
        other = element.get(_PATH)
        key = (part_name(str(other), self._files) if other else path, integer(element, "objectid"))
        return key, _pose(element)


def _refuse_unknown(element: etree._Element, known: tuple[str, ...]) -> None:
    if re.sub(r"^\{.*\}", "", str(element.tag)) not in known:
        raise ValueError(
            f"a 3MF of plain triangles, {where(element)} is of another kind: export it as a mesh"
        )


def _mesh(mesh: etree._Element) -> Parts:
    for one in mesh:
        _refuse_unknown(one, ("vertices", "triangles", "trianglesets"))
    vertices, triangles = child(mesh, "vertices"), child(mesh, "triangles")
    if vertices is None or triangles is None:
        raise ValueError(f"3MF meshes with vertices and triangles, {where(mesh)} has not both")
    for group, name in ((vertices, "vertex"), (triangles, "triangle")):
        for one in group:
            _refuse_unknown(one, (name,))
    points = _attributes(vertices, "vertex", ("x", "y", "z"))
    ids = _attributes(triangles, "triangle", ("v1", "v2", "v3"))
    if len(ids) and not (ids.min() >= 0 and ids.max() < len(points) and (ids % 1 == 0).all()):
        raise ValueError(f"triangles of the {len(points):,} vertices, not all are: {where(mesh)}")
    return Parts(points, ids.astype(np.int32))


def _attributes(group: etree._Element, name: str, names: tuple[str, ...]) -> FloatArray:
    rows = children(group, name)
    words = [str(row.get(one, "")).strip().encode() for row in rows for one in names]
    return float_words(words, f"numbers in {where(group)}").reshape(-1, len(names))


def _pose(element: etree._Element) -> FloatArray:
    """Pose (4, 4) of a transform, whose twelve numbers are for rows of points."""
    pose = np.eye(4)
    if (text := element.get("transform")) is not None:
        numbers = float_words(str(text).encode().split(), f"numbers in {where(element)}")
        if len(numbers) != 12:
            raise ValueError(f"transforms of 12 numbers, that of {where(element)} is none")
        pose[:3] = affine(numbers.reshape(4, 3).T, where(element))
    return pose
