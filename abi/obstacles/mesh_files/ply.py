"""Reader of PLY files, as text or binary (Turk, The PLY polygon file format, 1994)."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from abi.arrays import ByteArray, FloatArray, IntArray
from abi.obstacles.mesh_files.parts import NO_COLOURS, MeshFile, Parts, check_count
from abi.obstacles.mesh_files.polygons import triangulate
from abi.obstacles.mesh_files.words import counted, float_words, shown

_TYPES = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"},
    **{"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"},
    **{"float": "f4", "float32": "f4", "double": "f8", "float64": "f8"},
}
_FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_END = re.compile(rb"^end_header[ \t]*(?:\r\n|\n|\r)", re.MULTILINE)
_MOST_HEADER = 100_000
_MOST_ROWS = 20_000_000
_CORNERS = ("vertex_indices", "vertex_index")
_COLOUR = ("red", "green", "blue")


class _Property(NamedTuple):
    """Name and type of a property; ``length`` is the type of a list's length, else empty."""

    name: str
    kind: str
    length: str


class _Element(NamedTuple):
    """Name, rows and properties of an element."""

    name: str
    rows: int
    properties: tuple[_Property, ...]


class Lists(NamedTuple):
    """A list in each row of an element: the lengths (n,), and all values in a row."""

    counts: IntArray
    values: FloatArray


Table = Mapping[str, FloatArray | Lists]


def read(data: bytes, most_faces: int) -> MeshFile:
    """Vertices, polygons and triangle strips; colours of faces or else of vertices.

    Raises:
        ValueError: says what it ought to be.
    """
    end = _END.search(data, 0, _MOST_HEADER)
    if not data.startswith(b"ply") or end is None:
        raise ValueError("a PLY file, whose header ends with a line end_header")
    order, elements = _header(data[: end.start()].decode("utf-8", "replace").splitlines())
    body = data[end.end() :]
    if order is None:
        tables, left = _text_tables(body, elements)
    else:
        tables, left = _binary_tables(body, elements, order)
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
    return MeshFile(Parts(vertices, faces, colours), notes=tuple(notes))


def _header(lines: Sequence[str]) -> tuple[str | None, list[_Element]]:
    """Byte order, None for text, and the elements."""
    order: str | None = ""
    known = False
    elements: list[_Element] = []
    for number, line in enumerate(lines[1:], 2):
        match line.split():
            case [] | ["comment" | "obj_info", *_]:
                continue
            case ["format", kind, _] if kind in _FORMATS and not known:
                order, known = _FORMATS[kind] or None, True
            case ["element", name, rows] if rows.isascii() and rows.isdigit() and len(rows) < 10:
                if any(one.name == name for one in elements) or int(rows) > _MOST_ROWS:
                    raise ValueError(f"elements once and of a modest number, not {line[:60]!r}")
                elements.append(_Element(name, int(rows), ()))
            case ["property", "list", count, kind, name] if elements and _are_types(count, kind):
                added = _Property(name, _TYPES[kind], _TYPES[count])
                elements[-1] = _with(elements[-1], added)
            case ["property", kind, name] if elements and _are_types(kind):
                elements[-1] = _with(elements[-1], _Property(name, _TYPES[kind], ""))
            case _:
                raise ValueError(f"a PLY header, its line {number} is {line.strip()[:40]!r}")
    if not known:
        raise ValueError("a PLY header with a line such as format ascii 1.0")
    return order, elements


def _are_types(*names: str) -> bool:
    return all(name in _TYPES for name in names)


def _with(element: _Element, added: _Property) -> _Element:
    if any(one.name == added.name for one in element.properties):
        raise ValueError(f"properties of different names, {shown(added.name)} is there twice")
    return element._replace(properties=(*element.properties, added))


def _text_tables(body: bytes, elements: Sequence[_Element]) -> tuple[list[Table], int]:
    """The rows of all elements, and the number of words behind them."""
    numbers = float_words(body.split(), "a PLY text of numbers")
    tables, at = [], 0
    for element in elements:
        table, at = _text_table(numbers, at, element)
        tables.append(table)
    return tables, len(numbers) - at


def _text_table(numbers: FloatArray, at: int, element: _Element) -> tuple[Table, int]:
    lists = [k for k, one in enumerate(element.properties) if one.length]
    width = len(element.properties)
    if not element.rows or not width:
        return _columns(element, np.empty((0, width)), {}), at
    if not lists:
        end = at + element.rows * width
        if end > len(numbers):
            raise _cut_off(element)
        return _columns(element, numbers[at:end].reshape(-1, width), {}), end
    if uniform := _uniform_text(numbers, at, element):
        return uniform
    plain = np.empty((element.rows, width))
    found: dict[int, list[FloatArray]] = {k: [] for k in lists}
    for row in range(element.rows):
        for k, one in enumerate(element.properties):
            if at >= len(numbers):
                raise _cut_off(element)
            value = numbers[at]
            plain[row, k] = value
            at += 1
            if one.length:
                length = _length(float(value), element)
                found[k].append(numbers[at : at + length])
                at += length
    if at > len(numbers):
        raise _cut_off(element)
    return _columns(element, plain, {k: np.concatenate(found[k]) for k in lists}), at


def _uniform_text(numbers: FloatArray, at: int, element: _Element) -> tuple[Table, int] | None:
    """The rows of an element whose lists are all as long as in its first row; else None."""
    starts: dict[int, int] = {}
    counts: dict[int, int] = {}
    width = 0
    for k, one in enumerate(element.properties):
        starts[k] = width
        if one.length and at + width < len(numbers):
            counts[k] = _length(float(numbers[at + width]), element)
        width += 1 + counts.get(k, 0)
    end = at + element.rows * width
    if end > len(numbers):
        return None
    rows = numbers[at:end].reshape(-1, width)
    if any((rows[:, starts[k]] != count).any() for k, count in counts.items()):
        return None
    lists = {
        k: rows[:, starts[k] + 1 : starts[k] + 1 + count].reshape(-1) for k, count in counts.items()
    }
    return _columns(element, rows[:, list(starts.values())], lists), end


def _binary_tables(
    body: bytes, elements: Sequence[_Element], order: str
) -> tuple[list[Table], int]:
    """The rows of all elements, and the number of bytes behind them."""
    tables, at = [], 0
    for element in elements:
        table, at = _binary_table(body, at, element, order)
        tables.append(table)
    return tables, len(body[at:].strip(b"\0 \r\n"))


def _binary_table(body: bytes, at: int, element: _Element, order: str) -> tuple[Table, int]:
    width = len(element.properties)
    if not element.rows or not width:
        return _columns(element, np.empty((0, width)), {}), at
    lengths = _first_lengths(body, at, element, order)
    row = _row_type(element, order, lengths)
    end = at + element.rows * row.itemsize
    if end <= len(body) or not lengths:
        if end > len(body):
            raise _cut_off(element)
        rows = np.frombuffer(body, row, element.rows, at)
        if all((rows[f"n{k}"] == length).all() for k, length in lengths.items()):
            plain = np.stack(
                [rows[f"n{k}" if k in lengths else f"v{k}"] for k in range(width)], axis=1
            ).astype(np.float64)
            values = {k: rows[f"v{k}"].reshape(-1).astype(np.float64) for k in lengths}
            return _columns(element, plain, values), end
    return _mixed_table(body, at, element, order)


def _first_lengths(body: bytes, at: int, element: _Element, order: str) -> dict[int, int]:
    """Length of each list in the first row."""
    lengths = {}
    for k, one in enumerate(element.properties):
        if one.length:
            lengths[k], at = _binary_length(body, at, element, one, order)
            at += lengths[k] * np.dtype(one.kind).itemsize
        else:
            at += np.dtype(one.kind).itemsize
    return lengths


def _binary_length(
    body: bytes, at: int, element: _Element, one: _Property, order: str
) -> tuple[int, int]:
    size = np.dtype(one.length).itemsize
    if at + size > len(body):
        raise _cut_off(element)
    value = float(np.frombuffer(body, order + one.length, 1, at)[0])
    return _length(value, element), at + size


def _row_type(element: _Element, order: str, lengths: Mapping[int, int]) -> np.dtype[np.void]:
    fields: list[tuple[str, str] | tuple[str, str, int]] = []
    for k, one in enumerate(element.properties):
        if one.length:
            fields += [(f"n{k}", order + one.length), (f"v{k}", order + one.kind, lengths[k])]
        else:
            fields.append((f"v{k}", order + one.kind))
    return np.dtype(fields)


def _mixed_table(body: bytes, at: int, element: _Element, order: str) -> tuple[Table, int]:
    """Rows whose lists differ in length."""
    plain = np.empty((element.rows, len(element.properties)))
    found: dict[int, list[FloatArray]] = {
        k: [] for k, one in enumerate(element.properties) if one.length
    }
    for row in range(element.rows):
        for k, one in enumerate(element.properties):
            count = 1
            if one.length:
                count, at = _binary_length(body, at, element, one, order)
            kind = np.dtype(order + one.kind)
            if at + count * kind.itemsize > len(body):
                raise _cut_off(element)
            values = np.frombuffer(body, kind, count, at)
            at += count * kind.itemsize
            plain[row, k] = count if one.length else values[0]
            if one.length:
                found[k].append(values)
    values_of = {k: np.concatenate(rows).astype(np.float64) for k, rows in found.items()}
    return _columns(element, plain, values_of), at


def _length(value: float, element: _Element) -> int:
    if not 0 <= value <= 1e7 or value != int(value):
        raise ValueError(f"whole numbers of corners in its rows of {shown(element.name)}")
    return int(value)


def _cut_off(element: _Element) -> ValueError:
    return ValueError(
        f"a whole PLY file, its header announces {element.rows:,} rows of {shown(element.name)} "
        "and not all are there"
    )


def _columns(element: _Element, plain: FloatArray, lists: Mapping[int, FloatArray]) -> Table:
    return {
        one.name: Lists(plain[:, k].astype(np.int32), lists.get(k, np.empty(0)))
        if one.length
        else plain[:, k]
        for k, one in enumerate(element.properties)
    }


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
    if not isinstance(lists, Lists):
        raise ValueError("a PLY file whose faces have a list vertex_indices")
    corners = _ids(lists.values, len(vertices))
    is_area = lists.counts >= 3
    kept = corners[np.repeat(is_area, lists.counts)]
    rows = np.flatnonzero(is_area)
    cut = triangulate(vertices, kept, lists.counts[is_area], lambda k: f"face {rows[k] + 1:,}")
    notes = [*cut.notes]
    if lines := int((~is_area).sum()):
        notes.append(f"{counted(lines, 'face')} of fewer than three corners left out.")
    own, points = _rgb(faces), _rgb(vertex)
    if len(own):
        return cut.faces, own[rows][cut.polygons], notes
    colours = points[cut.faces].mean(axis=1).astype(np.uint8) if len(points) else NO_COLOURS
    return cut.faces, colours, notes


def _rgb(table: Table) -> ByteArray:
    """Colours (n, 3) of the rows; (0, 3) without any, or where they are not bytes."""
    parts = [one for name in _COLOUR if isinstance(one := table.get(name), np.ndarray)]
    if len(parts) < 3 or any((part != part.astype(np.uint8)).any() for part in parts):
        return NO_COLOURS
    return np.stack(parts, axis=1).astype(np.uint8)


def _strips(table: Table, vertices: int) -> IntArray:
    """Triangles (m, 3) of strips, between which an id is -1; every second one is turned."""
    lists = next((table[name] for name in _CORNERS if name in table), None)
    if not isinstance(lists, Lists):
        return np.empty((0, 3), np.int32)
    ids = lists.values.astype(np.int64)
    _ids(ids[ids != -1].astype(np.float64), vertices)
    ends = np.cumsum(lists.counts)
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
