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


class PlyElement(NamedTuple):
    """An element and its properties.

    Attributes:
        name: of the element.
        rows: their number.
        kinds: type of each property, or of a list's values, by the property's name.
        lengths: type of the lengths of each property that is a list.
    """

    name: str
    rows: int
    kinds: Mapping[str, str]
    lengths: Mapping[str, str]


Table = Mapping[str, FloatArray | tuple[IntArray, FloatArray]]
"""Properties (n,) of an element by name; of lists their lengths (n,), and all their values."""


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
                elements.append(PlyElement(name, int(rows), {}, {}))
            case ["property", "list", count, kind, name] if elements and _are_types(count, kind):
                elements[-1] = _with(elements[-1], name, kind)
                lengths = {**elements[-1].lengths, name: _TYPES[count]}
                elements[-1] = elements[-1]._replace(lengths=lengths)
            case ["property", kind, name] if elements and _are_types(kind):
                elements[-1] = _with(elements[-1], name, kind)
            case _:
                raise ValueError(f"a PLY header, its line {number} is {line.strip()[:40]!r}")
    if not known:
        raise ValueError("a PLY header with a line such as format ascii 1.0")
    return order, elements


def _are_types(*names: str) -> bool:
    return all(name in _TYPES for name in names)


def _with(element: PlyElement, name: str, kind: str) -> PlyElement:
    if name in element.kinds:
        raise ValueError(f"properties of different names, {shown(name)} is there twice")
    return element._replace(kinds={**element.kinds, name: _TYPES[kind]})


def text_tables(body: bytes, elements: Sequence[PlyElement]) -> tuple[list[Table], int]:
    """The rows of all elements, and the number of words after them."""
    numbers = float_words(body.split(), "a PLY text of numbers")
    tables, at = [], 0
    for element in elements:
        table, at = _text_table(numbers, at, element)
        tables.append(table)
    return tables, len(numbers) - at


def _text_table(numbers: FloatArray, at: int, element: PlyElement) -> tuple[Table, int]:
    width = len(element.kinds)
    if not element.rows or not width:
        return _columns(element, np.empty((0, width)), {}), at
    if not element.lengths:
        end = at + element.rows * width
        if end > len(numbers):
            raise _cut_off(element)
        return _columns(element, numbers[at:end].reshape(-1, width), {}), end
    if uniform := _uniform_text(numbers, at, element):
        return uniform
    if element.rows * width > len(numbers) - at:
        raise _cut_off(element)
    plain = np.empty((element.rows, width))
    found: dict[str, list[FloatArray]] = {name: [] for name in element.lengths}
    for row in range(element.rows):
        for k, name in enumerate(element.kinds):
            if at >= len(numbers):
                raise _cut_off(element)
            value = numbers[at]
            plain[row, k] = value
            at += 1
            if name in found:
                length = _length(float(value), element)
                found[name].append(numbers[at : at + length])
                at += length
    if at > len(numbers):
        raise _cut_off(element)
    lists = {name: np.concatenate(values) for name, values in found.items()}
    return _columns(element, plain, lists), at


def _uniform_text(numbers: FloatArray, at: int, element: PlyElement) -> tuple[Table, int] | None:
    """The rows of an element whose lists all have the first row's lengths; otherwise None."""
    starts: dict[str, int] = {}
    counts: dict[str, int] = {}
    width = 0
    for name in element.kinds:
        starts[name] = width
        if name in element.lengths and at + width < len(numbers):
            counts[name] = _length(float(numbers[at + width]), element)
        width += 1 + counts.get(name, 0)
    end = at + element.rows * width
    if end > len(numbers):
        return None
    rows = numbers[at:end].reshape(-1, width)
    if any((rows[:, starts[name]] != count).any() for name, count in counts.items()):
        return None
    lists = {
        name: rows[:, starts[name] + 1 : starts[name] + 1 + count].reshape(-1)
        for name, count in counts.items()
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
    if not element.rows or not element.kinds:
        return _columns(element, np.empty((0, len(element.kinds))), {}), at
    lengths = _first_lengths(body, at, element, order)
    row = _row_type(element, order, lengths)
    end = at + element.rows * row.itemsize
    if end <= len(body) or not lengths:
        if end > len(body):
            raise _cut_off(element)
        rows = np.frombuffer(body, row, element.rows, at)
        if all((rows[f"n{name}"] == length).all() for name, length in lengths.items()):
            firsts = [f"n{name}" if name in lengths else f"v{name}" for name in element.kinds]
            plain = np.stack([rows[first] for first in firsts], axis=1).astype(np.float64)
            values = {name: rows[f"v{name}"].reshape(-1).astype(np.float64) for name in lengths}
            return _columns(element, plain, values), end
    return _mixed_table(body, at, element, order)


def _first_lengths(body: bytes, at: int, element: PlyElement, order: str) -> dict[str, int]:
    """Length of each list in the first row."""
    lengths = {}
    for name, kind in element.kinds.items():
        count = 1
        if name in element.lengths:
            lengths[name], at = _binary_length(body, at, element, name, order)
            count = lengths[name]
        at += count * np.dtype(kind).itemsize
    return lengths


def _binary_length(
    body: bytes, at: int, element: PlyElement, name: str, order: str
) -> tuple[int, int]:
    kind = np.dtype(order + element.lengths[name])
    size = kind.itemsize
    if at + size > len(body):
        raise _cut_off(element)
    value = float(np.frombuffer(body, kind, 1, at)[0])
    return _length(value, element), at + size


def _row_type(element: PlyElement, order: str, lengths: Mapping[str, int]) -> np.dtype[np.void]:
    fields: list[tuple[str, str] | tuple[str, str, int]] = []
    for name, kind in element.kinds.items():
        if name in lengths:
            fields.append((f"n{name}", order + element.lengths[name]))
            fields.append((f"v{name}", order + kind, lengths[name]))
        else:
            fields.append((f"v{name}", order + kind))
    return np.dtype(fields)


def _mixed_table(body: bytes, at: int, element: PlyElement, order: str) -> tuple[Table, int]:
    """Rows whose lists differ in length."""
    # a list may be empty: each row has its length at least
    least = sum(np.dtype(kind).itemsize for kind in {**element.kinds, **element.lengths}.values())
    if element.rows * least > len(body) - at:
        raise _cut_off(element)
    plain = np.empty((element.rows, len(element.kinds)))
    found: dict[str, list[FloatArray]] = {name: [] for name in element.lengths}
    for row in range(element.rows):
        for k, (name, type_of_values) in enumerate(element.kinds.items()):
            count = 1
            if name in found:
                count, at = _binary_length(body, at, element, name, order)
            kind = np.dtype(order + type_of_values)
            if at + count * kind.itemsize > len(body):
                raise _cut_off(element)
            values = np.frombuffer(body, kind, count, at)
            at += count * kind.itemsize
            plain[row, k] = count if name in found else values[0]
            if name in found:
                found[name].append(values)
    values_of = {name: np.concatenate(rows).astype(np.float64) for name, rows in found.items()}
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


def _columns(element: PlyElement, plain: FloatArray, lists: Mapping[str, FloatArray]) -> Table:
    return {
        name: (plain[:, k].astype(np.int32), lists.get(name, np.empty(0)))
        if name in element.lengths
        else plain[:, k]
        for k, name in enumerate(element.kinds)
    }
