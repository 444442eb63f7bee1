"""Elements of a PLY file as tables: the header, and the rows after it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.obstacles.mesh_files.words import float_words, shown

_TYPES = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"},
    **{"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"},
    **{"float": "f4", "float32": "f4", "double": "f8", "float64": "f8"},
}
_FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_MOST_ROWS = 20_000_000


class Property(NamedTuple):
    """Name and type of a property; ``length`` is the type of a list's length, else empty."""

    name: str
    kind: str
    length: str


class PlyElement(NamedTuple):
    """Name, rows and properties of an element."""

    name: str
    rows: int
    properties: tuple[Property, ...]


class PlyLists(NamedTuple):
    """A list property: the lengths (n,), and all values concatenated."""

    counts: IntArray
    values: FloatArray


Table = Mapping[str, FloatArray | PlyLists]


def header(lines: Sequence[str]) -> tuple[str | None, list[PlyElement]]:
    """Byte order, None for text, and the elements."""
    order: str | None = ""
    known = False
    elements: list[PlyElement] = []
    for number, line in enumerate(lines[1:], 2):
        match line.split():
            case [] | ["comment" | "obj_info", *_]:
                continue
            case ["format", kind, _] if kind in _FORMATS and not known:
                order, known = _FORMATS[kind] or None, True
            case ["element", name, rows] if rows.isascii() and rows.isdigit() and len(rows) < 10:
                if any(one.name == name for one in elements) or int(rows) > _MOST_ROWS:
                    raise ValueError(f"elements once and of a modest number, not {line[:60]!r}")
                elements.append(PlyElement(name, int(rows), ()))
            case ["property", "list", count, kind, name] if elements and _are_types(count, kind):
                added = Property(name, _TYPES[kind], _TYPES[count])
                elements[-1] = _with(elements[-1], added)
            case ["property", kind, name] if elements and _are_types(kind):
                elements[-1] = _with(elements[-1], Property(name, _TYPES[kind], ""))
            case _:
                raise ValueError(f"a PLY header, its line {number} is {line.strip()[:40]!r}")
    if not known:
        raise ValueError("a PLY header with a line such as format ascii 1.0")
    return order, elements


def _are_types(*names: str) -> bool:
    return all(name in _TYPES for name in names)


def _with(element: PlyElement, added: Property) -> PlyElement:
    if any(one.name == added.name for one in element.properties):
        raise ValueError(f"properties of different names, {shown(added.name)} is there twice")
    return element._replace(properties=(*element.properties, added))


def text_tables(body: bytes, elements: Sequence[PlyElement]) -> tuple[list[Table], int]:
    """The rows of all elements, and the number of words after them."""
    numbers = float_words(body.split(), "a PLY text of numbers")
    tables, at = [], 0
    for element in elements:
        table, at = _text_table(numbers, at, element)
        tables.append(table)
    return tables, len(numbers) - at


def _text_table(numbers: FloatArray, at: int, element: PlyElement) -> tuple[Table, int]:
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
    if element.rows * width > len(numbers) - at:
        raise _cut_off(element)
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


def _uniform_text(numbers: FloatArray, at: int, element: PlyElement) -> tuple[Table, int] | None:
    """The rows of an element whose lists all have the first row's lengths; otherwise None."""
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


def binary_tables(
    body: bytes, elements: Sequence[PlyElement], order: str
) -> tuple[list[Table], int]:
    """The rows of all elements, and the number of bytes after them."""
    tables, at = [], 0
    for element in elements:
        table, at = _binary_table(body, at, element, order)
        tables.append(table)
    return tables, len(body[at:].strip(b"\0 \r\n"))


def _binary_table(body: bytes, at: int, element: PlyElement, order: str) -> tuple[Table, int]:
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


def _first_lengths(body: bytes, at: int, element: PlyElement, order: str) -> dict[int, int]:
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
    body: bytes, at: int, element: PlyElement, one: Property, order: str
) -> tuple[int, int]:
    size = np.dtype(one.length).itemsize
    if at + size > len(body):
        raise _cut_off(element)
    value = float(np.frombuffer(body, order + one.length, 1, at)[0])
    return _length(value, element), at + size


def _row_type(element: PlyElement, order: str, lengths: Mapping[int, int]) -> np.dtype[np.void]:
    fields: list[tuple[str, str] | tuple[str, str, int]] = []
    for k, one in enumerate(element.properties):
        if one.length:
            fields += [(f"n{k}", order + one.length), (f"v{k}", order + one.kind, lengths[k])]
        else:
            fields.append((f"v{k}", order + one.kind))
    return np.dtype(fields)


def _mixed_table(body: bytes, at: int, element: PlyElement, order: str) -> tuple[Table, int]:
    """Rows whose lists differ in length."""
    least = sum(np.dtype(one.length or one.kind).itemsize for one in element.properties)
    if element.rows * least > len(body) - at:
        raise _cut_off(element)
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


def _length(value: float, element: PlyElement) -> int:
    if not 0 <= value <= 1e7 or value != int(value):
        raise ValueError(f"whole numbers of corners in its rows of {shown(element.name)}")
    return int(value)


def _cut_off(element: PlyElement) -> ValueError:
    return ValueError(
        f"a whole PLY file, its header announces {element.rows:,} rows of {shown(element.name)} "
        "and not all are there"
    )


def _columns(element: PlyElement, plain: FloatArray, lists: Mapping[int, FloatArray]) -> Table:
    return {
        one.name: PlyLists(plain[:, k].astype(np.int32), lists.get(k, np.empty(0)))
        if one.length
        else plain[:, k]
        for k, one in enumerate(element.properties)
    }
