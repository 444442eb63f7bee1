"""Reader of PLY files, as text or binary (Turk, The PLY polygon file format, 1994)."""

from __future__ import annotations

import re
from collections import Counter

import numpy as np

from abi.arrays import ByteArray, FloatArray, IntArray
from abi.obstacles.mesh_files.parts import NO_COLOURS, MeshFile, Parts, check_count, loose_points
from abi.obstacles.mesh_files.ply_tables import Table, binary_tables, header, text_tables
from abi.obstacles.mesh_files.polygons import flatness_notes, triangulate
from abi.obstacles.mesh_files.units import commented
from abi.obstacles.mesh_files.words import counted, lines_of, shown

_END = re.compile(rb"(?<=[\r\n])end_header[ \t]*(?:\r\n|\n|\r)")
_MOST_HEADER = 100_000
_CORNERS = ("vertex_indices", "vertex_index")
_COMMENTS = (["comment"], ["obj_info"])
_COLOUR = ("red", "green", "blue")


def read(data: bytes, most_faces: int) -> MeshFile:
    """Vertices, polygons and triangle strips; colours of faces or else of vertices.

    Raises:
        ValueError: says what it ought to be.
    """
    end = _END.search(data, 0, _MOST_HEADER)
    if not data.startswith(b"ply") or end is None:
        raise ValueError("a PLY file, whose header ends with a line end_header")
    lines = lines_of(data[: end.start()].decode("utf-8", "replace"))[:-1]
    order, elements = header(lines)
    body = data[end.end() :]
    if order is None:
        tables, left = text_tables(body, elements)
    else:
        tables, left = binary_tables(body, elements, order)
    if left:
        raise ValueError(f"a PLY file that ends with its last row, {left:,} bytes follow")
    by_name = {element.name: table for element, table in zip(elements, tables, strict=True)}
    if "vertex" not in by_name or not {"face", "tristrips"} & by_name.keys():
        raise ValueError("a PLY file with vertices and faces")
    vertices = _vertices(by_name["vertex"])
    faces, colours, notes = _polygons(by_name.get("face", {}), by_name["vertex"], vertices)
    strips = _strips(by_name.get("tristrips", {}), len(vertices))
    if len(strips):
        faces, colours = np.concatenate([faces, strips]), NO_COLOURS
    check_count(len(faces), most_faces)
    left_out = [e for e in elements if e.name not in ("vertex", "face", "tristrips") and e.rows]
    notes += [f"Its {e.rows:,} rows of {shown(e.name)} are left out." for e in left_out]
    parts = Parts(vertices, faces, colours)
    comments = "\n".join(line for line in lines if line.split()[:1] in _COMMENTS)
    said, unknown_units = commented(comments)
    notes += [*loose_points(parts), *unknown_units]
    return MeshFile(parts, notes=tuple(notes), commented=said)


def _vertices(table: Table) -> FloatArray:
    axes = [table.get(axis) for axis in "xyz"]
    if any(not isinstance(axis, np.ndarray) for axis in axes):
        raise ValueError("a PLY file whose vertices have x, y and z")
    return np.stack([axis for axis in axes if isinstance(axis, np.ndarray)], axis=1)


def _polygons(
    faces: Table, vertex: Table, vertices: FloatArray
) -> tuple[IntArray, ByteArray, list[str]]:
    lists = next((faces[name] for name in _CORNERS if name in faces), None)
    if lists is None and not faces:
        return np.empty((0, 3), np.int32), NO_COLOURS, []
    if not isinstance(lists, tuple):
        raise ValueError("a PLY file whose faces have a list vertex_indices")
    counts, values = lists
    corners = _ids(values, len(vertices))
    is_area = counts >= 3
    kept = corners[np.repeat(is_area, counts)]
    rows = np.flatnonzero(is_area)
    sizes, tally = counts[is_area], Counter[str]()
    triangles = triangulate(vertices, kept, sizes, lambda k: f"face {rows[k] + 1:,}", tally)
    notes = [*flatness_notes(tally)]
    if lines := int((~is_area).sum()):
        notes.append(f"{counted(lines, 'face')} of fewer than three corners left out.")
    own, points = _rgb(faces), _rgb(vertex)
    if len(own):
        return triangles, np.repeat(own[rows], sizes - 2, axis=0), notes
    colours = points[triangles].mean(axis=1).astype(np.uint8) if len(points) else NO_COLOURS
    return triangles, colours, notes


def _rgb(table: Table) -> ByteArray:
    """Colours (n, 3) of the rows; (0, 3) if there are none or they are not bytes."""
    parts = [one for name in _COLOUR if isinstance(one := table.get(name), np.ndarray)]
    if len(parts) < 3 or any((part != part.astype(np.uint8)).any() for part in parts):
        return NO_COLOURS
    return np.stack(parts, axis=1).astype(np.uint8)


def _strips(table: Table, vertices: int) -> IntArray:
    """Triangles (m, 3) of strips separated by index -1, with every second one reversed."""
    lists = next((table[name] for name in _CORNERS if name in table), None)
    if not isinstance(lists, tuple):
        return np.empty((0, 3), np.int32)
    counts, values = lists
    ids = values.astype(np.int64)
    _ids(ids[ids != -1].astype(np.float64), vertices)
    ends = np.cumsum(counts)
    starts = np.unique(np.concatenate([[0], ends, np.flatnonzero(ids == -1) + 1]))
    place = np.arange(len(ids))
    within = place - starts[np.searchsorted(starts, place, side="right") - 1]
    windows = np.stack([ids[:-2], ids[1:-1], ids[2:]], 1) if len(ids) > 2 else np.empty((0, 3))
    whole = (windows != -1).all(axis=1) & (within[2:] >= 2)
    odd = within[2:][whole] % 2 == 1
    triangles = windows[whole].astype(np.int32)
    triangles[odd] = triangles[odd][:, [1, 0, 2]]
    return np.asarray(triangles)


def _ids(values: FloatArray, count: int) -> IntArray:
    if len(values) and not (values.min() >= 0 and values.max() < count):
        raise ValueError(f"a PLY file whose faces have vertices, there are {count:,}")
    if (values != np.floor(values)).any():
        raise ValueError("a PLY file whose faces count their vertices in whole numbers")
    return values.astype(np.int32)
