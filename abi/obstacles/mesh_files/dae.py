"""Reader of DAE files (Khronos, COLLADA 1.4.1 and 1.5 specifications).

It reads what the visual scene places, in the file's own axes. Whatever is posed by a controller, or
is a surface of another kind than polygons, is refused; lines, other scenes and what no node places
are left out with a note.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from urllib.parse import unquote

import numpy as np
from lxml import etree

from abi.arrays import FloatArray
from abi.obstacles.mesh_files.dae_colours import bound, colours_of, painted
from abi.obstacles.mesh_files.dae_geometry import Primitive, geometry_notes, read_geometry
from abi.obstacles.mesh_files.dae_pose import node_pose
from abi.obstacles.mesh_files.parts import MeshFile, Parts, check_count, joined, placed
from abi.obstacles.mesh_files.units import length_of
from abi.obstacles.mesh_files.words import counted, float_words, shown
from abi.obstacles.mesh_files.xml_document import child, children, name_of, parse, where

_MOST_NODES, _DEEPEST = 10_000, 200
_LARGEST_UNIT = 1e4
_AXES = {"X_UP": "x", "Y_UP": "y", "Z_UP": "z"}


def read(data: bytes, most_faces: int) -> MeshFile:
    """Triangles of a DAE file where its scene places them, with the colours of their materials.

    Raises:
        ValueError: says what it ought to be.
    """
    document = _Document(parse(data, "COLLADA"))
    tally, known = Counter[str](), dict[etree._Element, tuple[Primitive, ...]]()
    colours = colours_of(document.root)
    parts: list[Parts] = []
    count = 0
    for instance, pose in document.placed():
        kind = name_of(instance)
        if kind != "instance_geometry":
            raise ValueError(
                f"a DAE without skin and morph controllers, {where(instance)} is one: apply the "
                "armature in the program that wrote it"
            )
        by_symbol = bound(instance, colours)
        geometry = document.target(instance, "geometry")
        if geometry not in known:
            known[geometry] = read_geometry(geometry, most_faces, tally)
        for one, symbol in known[geometry]:
            count += len(one.faces)
            if count > most_faces:
                check_count(count, most_faces)
            parts.append(placed(painted(one, by_symbol.get(symbol)), pose))
    check_count(count, most_faces)
    notes = (*geometry_notes(tally), *document.left_out())
    return MeshFile(joined(parts), document.metres(), notes, document.up())


class _Document:
    """A parsed file, with every reference checked before it is followed."""

    def __init__(self, root: etree._Element) -> None:
        self.root = root
        self._ids: dict[tuple[str, str], etree._Element] = {}
        self._repeated: set[tuple[str, str]] = set()
        self._placed: set[etree._Element] = set()
        for element in root.iter(etree.Element):
            if (name := element.get("id")) is not None:
                key = (name_of(element), str(name))
                if key in self._ids:
                    self._repeated.add(key)
                self._ids.setdefault(key, element)

    def metres(self) -> float:
        """Length of the file's unit, [m]; one metre by default."""
        lengths = {_metres(one) for one in self._units()}
        if len(lengths) > 1:
            raise ValueError("a DAE of one unit, its parts have several")
        return lengths.pop() if lengths else 1.0

    def up(self) -> str:
        """Axis that points up in the file; y by default."""
        axes = {"".join(one.itertext()).strip() for one in self.root.iter("{*}up_axis")}
        if len(axes) > 1:
            raise ValueError("a DAE of one up_axis, its parts have several")
        up = axes.pop() if axes else "Y_UP"
        if up not in _AXES:
            raise ValueError(f"a DAE whose up_axis is X_UP, Y_UP or Z_UP, not {shown(up)}")
        return _AXES[up]

    def target(self, element: etree._Element, kind: str) -> etree._Element:
        """Element that the url of an instance refers to."""
        url = str(element.get("url", "")).strip()
        key = (kind, url.removeprefix("#"))
        if key not in self._ids:
            key = (kind, unquote(key[1]))
        if not url.startswith("#"):
            raise ValueError(f"a mesh in one file, {where(element)} refers to {shown(url)}")
        if key not in self._ids or key in self._repeated:
            raise ValueError(f"one {kind} {shown(url)} for {where(element)}")
        return self._ids[key]

    def placed(self) -> Iterator[tuple[etree._Element, FloatArray]]:
        """Instances of geometries and controllers, and their poses (4, 4) in the scene."""
        waiting = [(node, np.eye(4), 0) for node in children(self._scene(), "node")]
        steps = 0
        while waiting:
            node, outer, depth = waiting.pop()
            steps += 1
            if steps > _MOST_NODES or depth > _DEEPEST:
                raise ValueError("a DAE of at most 10,000 nodes that do not contain themselves")
            pose = outer @ node_pose(node)
            for instance in children(node, "instance_geometry", "instance_controller"):
                self._placed.add(instance)
                yield instance, pose
            inner = children(node, "node")
            inner += [self.target(one, "node") for one in children(node, "instance_node")]
            waiting += [(one, pose, depth + 1) for one in inner]

    def left_out(self) -> tuple[str, ...]:
        """Sentences on what no node of the file places."""
        instances = list(self.root.iter("{*}instance_geometry", "{*}instance_controller"))
        urls = {str(one.get("url", "")).strip() for one in instances}
        geometries = [key for kind, key in self._ids if kind == "geometry"]
        notes = [*self._misnamed()]
        urls |= set(map(unquote, urls))
        if unused := sum(f"#{key}" not in urls for key in geometries):
            noun = counted(unused, "geometry", "geometries")
            notes.append(f"{noun} left out: no node places it.")
        if elsewhere := sum(one not in self._placed for one in instances):
            notes.append(f"{counted(elsewhere, 'instance')} left out: not in the file's scene.")
        if scenes := sum(kind == "visual_scene" for kind, _ in self._ids) - 1:
            notes.append(f"{counted(scenes, 'scene')} left out: the file opens with another.")
        for scene in children(self.root, "scene"):
            others = {name_of(one) for one in scene} - {"instance_visual_scene", "extra"}
            notes += [f"What its <{name[:40]}> says is left out." for name in sorted(others)]
        if next(self.root.iter("{*}animation"), None) is not None:
            notes.append("Its animations are left out.")
        return tuple(notes)

    def _misnamed(self) -> Iterator[str]:
        """A sentence on each unit that is not as long as its name says."""
        for name, metres in {(str(k.get("name", "")), _metres(k)) for k in self._units()}:
            if not math.isclose(metres, length_of(name) or metres, rel_tol=1e-3):
                yield f"Its unit is named {shown(name)}, but is {metres:g} m long, which counts."

    def _units(self) -> list[etree._Element]:
        units = [one for one in self.root.iter("{*}unit") if one.getparent() is not None]
        return [one for one in units if name_of(one.getparent()) == "asset"]

    def _scene(self) -> etree._Element:
        scene = child(self.root, "scene")
        instance = None if scene is None else child(scene, "instance_visual_scene")
        if instance is None:
            raise ValueError("a DAE with a scene, it places nothing")
        return self.target(instance, "visual_scene")


def _metres(element: etree._Element) -> float:
    try:
        metres = float(float_words([str(element.get("meter", "1")).strip().encode()], "")[0])
    except ValueError:
        metres = 0.0
    if not 0 < metres <= _LARGEST_UNIT:
        raise ValueError(f"a DAE whose unit is a length, {where(element)} is none")
    return metres
