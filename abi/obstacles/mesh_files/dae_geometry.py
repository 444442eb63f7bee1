"""Polygons of the geometries of a DAE file."""

from __future__ import annotations

from collections import Counter

import numpy as np
from lxml import etree

from abi.arrays import FloatArray, IntArray
from abi.obstacles.mesh_files.parts import Parts, check_count, check_points
from abi.obstacles.mesh_files.polygons import add_pairs, cut, flatness_notes, is_bent, triangulate
from abi.obstacles.mesh_files.words import counted, shown
from abi.obstacles.mesh_files.xml_document import (
    child,
    children,
    floats,
    integer,
    name_of,
    refers,
    where,
)

_LINES = ("lines", "linestrips")
_NO_SURFACE = ("source", "vertices", "extra")
_POLYGONS = ("triangles", "trifans", "tristrips", "polylist", "polygons")


Primitive = tuple[Parts, str]
"""Triangles of one element of a geometry, and the symbol of their material."""


def read_geometry(
    geometry: etree._Element, most_faces: int, tally: Counter[str]
) -> tuple[Primitive, ...]:
    """Triangles of a geometry.

    Args:
        geometry: the geometry.
        most_faces: refused are more.
        tally: of the file, as that of :func:`abi.obstacles.mesh_files.polygons.triangulate`;
            ``lines`` and elements that are not known, as ``<mesh>``, are added to it, too.

    Raises:
        ValueError: it is damaged, or has surfaces that are no polygons.
    """
    mesh = child(geometry, "mesh")
    if len(children(geometry, "mesh")) > 1:
        raise ValueError(f"a DAE with one mesh in {where(geometry)}")
    if mesh is None:
        if child(geometry, "spline") is not None:
            tally["lines"] += 1
            return ()
        raise ValueError(f"a DAE of polygons, {where(geometry)} has none: export a mesh")
    found = []
    for element in mesh:
        kind = name_of(element)
        if kind in _LINES:
            tally["lines"] += integer(element, "count")
        elif kind in _POLYGONS and child(element, "p", "ph") is not None:
            found.append(_primitive(mesh, element, kind, tally))
        elif kind not in (*_POLYGONS, *_NO_SURFACE):
            tally[f"<{kind}>"] += 1
    check_count(sum(len(parts.faces) for parts, _ in found) or 1, most_faces)
    return tuple(found)


def _primitive(
    mesh: etree._Element, element: etree._Element, kind: str, tally: Counter[str]
) -> Primitive:
    points, places = _corner_points(mesh, element)
    _check_rows(element, kind)
    rows = [_corners(p, places, len(points)) for p in children(element, "p")]
    if kind in ("triangles", "polylist"):
        ids = np.concatenate(rows) if rows else np.empty(0, dtype=np.int32)
        if kind == "triangles":
            faces = _triples(ids, element)
        else:
            faces = _polylist(ids, points, element, tally)
    elif kind == "polygons":
        faces = _polygons(rows, points, places, element, tally)
    else:
        faces = np.concatenate([np.empty((0, 3), np.int32), *(_run(r, kind) for r in rows)])
    return Parts(points, faces), str(element.get("material", ""))


def _polylist(
    ids: IntArray, points: FloatArray, element: etree._Element, tally: Counter[str]
) -> IntArray:
    lengths = child(element, "vcount")
    counts = np.empty(0, dtype=np.int32)
    if lengths is not None:
        counts = _whole(floats(lengths), element)
    if counts.sum() != len(ids):
        raise ValueError(f"as many corners as vcount says in {where(element)}")
    is_area = counts >= 3
    tally["lines"] += int((~is_area).sum())
    kept = ids[np.repeat(is_area, counts)]
    rows = np.flatnonzero(is_area)
    return triangulate(
        points,
        kept,
        counts[is_area],
        lambda k: f"polygon {rows[k] + 1:,} of {where(element)}",
        tally,
    )


def _polygons(
    rows: list[IntArray],
    points: FloatArray,
    places: slice,
    element: etree._Element,
    tally: Counter[str],
) -> IntArray:
    """Triangles of polygons, first those without holes."""
    sizes = np.array([len(row) for row in rows], dtype=np.int32)
    tally["lines"] += int((sizes < 3).sum())
    whole = [row for row in rows if len(row) >= 3]
    ids = np.concatenate(whole) if whole else np.empty(0, dtype=np.int32)
    numbers = np.flatnonzero(sizes >= 3)
    found = triangulate(
        points,
        ids,
        sizes[sizes >= 3],
        lambda k: f"polygon {numbers[k] + 1:,} of {where(element)}",
        tally,
    )
    faces = [found]
    for holed in children(element, "ph"):
        rings = [_corners(one, places, len(points)) for one in children(holed, "p", "h")]
        if not rings or min(map(len, rings)) < 3 or name_of(holed[0]) != "p":
            raise ValueError(f"rings of three corners or more in {where(holed)}")
        add_pairs(tally, sum(map(len, rings)) ** 2)
        outlines = [points[ring] for ring in rings]
        tally["bent"] += is_bent(outlines)
        triangles = cut(outlines, where(holed))
        faces.append(np.concatenate(rings)[triangles])
    return np.concatenate(faces)


def geometry_notes(tally: Counter[str]) -> tuple[str, ...]:
    """Sentences on what of the geometries is not read, or only by assumption."""
    unknown = [name[1:-1] for name in tally if name.startswith("<")]
    notes = [f"What its <{name[:40]}> says is left out." for name in unknown]
    notes += flatness_notes(tally)
    if tally["lines"]:
        notes.append(f"{counted(tally['lines'], 'line')} left out: no surface.")
    return tuple(notes)


def _check_rows(element: etree._Element, kind: str) -> None:
    """Refuse polygons, strips or fans of which some are not there."""
    if kind in ("polygons", "trifans", "tristrips"):
        announced, there = integer(element, "count", "0"), len(children(element, "p", "ph"))
        if there < announced:
            raise ValueError(f"{announced:,} lists in {where(element)}, it has {there:,}")


def _corner_points(mesh: etree._Element, element: etree._Element) -> tuple[FloatArray, slice]:
    """Positions of a primitive, and the places of their ids among its interleaved indices."""
    inputs = children(element, "input")
    offsets = [integer(one, "offset", "0") for one in inputs]
    found = [k for k, one in enumerate(inputs) if one.get("semantic") == "VERTEX"]
    if len(found) != 1:
        raise ValueError(f"one input VERTEX in {where(element)}")
    vertices = _local(mesh, inputs[found[0]], "vertices")
    positions = [one for one in children(vertices, "input") if one.get("semantic") == "POSITION"]
    if len(positions) != 1:
        raise ValueError(f"one input POSITION in {where(vertices)}")
    places = slice(offsets[found[0]], None, max(offsets) + 1)
    return _points(_local(mesh, positions[0], "source")), places


def _local(mesh: etree._Element, element: etree._Element, kind: str) -> etree._Element:
    """The element that an input's source refers to."""
    url = str(element.get("source", "")).strip()
    found = [one for one in children(mesh, kind) if refers(url, one.get("id"))]
    if len(found) != 1:
        raise ValueError(f"one {kind} {shown(url)} for {where(element)}")
    return found[0]


def _points(source: etree._Element) -> FloatArray:
    """Positions (n, 3) of a source, by the accessor of its array."""
    common = child(source, "technique_common")
    accessor = None if common is None else child(common, "accessor")
    if accessor is None:
        raise ValueError(f"an accessor in {where(source)}")
    url = str(accessor.get("source", ""))
    array = next((one for one in source if refers(url, one.get("id"))), None)
    if array is None or name_of(array) not in ("float_array", "int_array"):
        raise ValueError(f"numbers in the file itself for {where(accessor)}")
    numbers = floats(array)
    named = {k: str(one.get("name", "")) for k, one in enumerate(children(accessor, "param"))}
    columns = [k for k, name in named.items() if name]
    if sorted(named[k] for k in columns) == ["X", "Y", "Z"]:  # in any order
        columns.sort(key=named.__getitem__)
    count, stride = integer(accessor, "count"), integer(accessor, "stride", "1")
    offset = integer(accessor, "offset", "0")
    if len(columns) != 3 or max(columns) >= stride:
        raise ValueError(f"positions of three numbers in {where(accessor)}")
    if offset + count * stride > len(numbers) or integer(array, "count") != len(numbers):
        raise ValueError(f"as many numbers as {where(array)} announces, it has {len(numbers):,}")
    rows = numbers[offset : offset + count * stride].reshape(count, stride)
    points = np.ascontiguousarray(rows[:, columns])
    check_points(points)
    return points


def _corners(element: etree._Element, places: slice, count: int) -> IntArray:
    """Ids of positions, of which there are ``count``, in a list of interleaved indices."""
    numbers = _whole(floats(element), element)
    if len(numbers) % places.step:
        raise ValueError(f"{places.step} numbers for each corner in {where(element)}")
    ids = numbers[places]
    if len(ids) and ids.max() >= count:
        raise ValueError(f"corners of the {count:,} vertices, {where(element)} has {ids.max():,}")
    return ids


def _whole(numbers: FloatArray, element: etree._Element) -> IntArray:
    if not ((numbers >= 0) & (numbers < 2**31) & (numbers % 1 == 0)).all():
        raise ValueError(f"whole numbers in {where(element)}")
    return numbers.astype(np.int32)


def _triples(ids: IntArray, element: etree._Element) -> IntArray:
    if len(ids) % 3:
        raise ValueError(f"three corners for each triangle in {where(element)}")
    return ids.reshape(-1, 3)


def _run(ids: IntArray, kind: str) -> IntArray:
    """Triangles of a strip or a fan."""
    if len(ids) < 3:
        return np.empty((0, 3), dtype=np.int32)
    if kind == "trifans":
        return np.stack([np.full(len(ids) - 2, ids[0]), ids[1:-1], ids[2:]], axis=1)
    faces = np.stack([ids[:-2], ids[1:-1], ids[2:]], axis=1)
    faces[1::2] = faces[1::2, [1, 0, 2]]
    return faces
