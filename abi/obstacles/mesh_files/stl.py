"""Reader of binary and text STL files, and writer of binary ones."""

from __future__ import annotations

import re

import numpy as np

from abi.arrays import ByteArray, FloatArray, IntArray
from abi.obstacles.mesh_files.parts import NO_COLOURS, MeshFile, Parts, check_count
from abi.obstacles.mesh_files.units import commented
from abi.obstacles.mesh_files.words import float_table, lines_of

_HEADER = b"abi".ljust(80)
_COLOURED = 1 << 15
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_FACET = b"facet normal _ _ _ outer loop vertex _ _ _ vertex _ _ _ vertex _ _ _ endloop endfacet"


def write(vertices: FloatArray, faces: IntArray, colours: ByteArray = NO_COLOURS) -> bytes:
    """Binary STL of vertices (n, 3), triangles (m, 3) and their colours (m, 3) or (0, 3).

    Colours are stored as many programs do: five bits each in the attribute, with bit 16 set.
    """
    table = np.zeros(len(faces), _TRIANGLE)
    table["corners"] = vertices[faces]
    if len(colours):
        red, green, blue = (colours.T >> 3).astype(np.uint16)
        table["attribute"] = _COLOURED | red << 10 | green << 5 | blue
    return _HEADER + len(table).to_bytes(4, "little") + table.tobytes()


def read(data: bytes, most_faces: int) -> MeshFile:
    """Triangles of an STL; binary when the length fits the count in its header.

    Args:
        data: the whole file.
        most_faces: triangles that it may have.

    Raises:
        ValueError: says what it ought to be.
    """
    colours = NO_COLOURS
    count = int.from_bytes(data[80:84], "little") if len(data) >= 84 else 0
    length = 84 + _TRIANGLE.itemsize * count
    if len(data) >= 84 and len(data) == length:
        check_count(count, most_faces)
        corners = np.frombuffer(data, _TRIANGLE, count, 84)["corners"]
        colours = _colours(data)
    elif data.lstrip()[:5].lower() == b"solid" and b"\0" not in data:
        corners = _text_facets(data, most_faces)
    elif len(data) < 84:
        raise ValueError(f"an STL file, but this is cut off after {len(data)} bytes")
    else:
        state = "is cut off" if len(data) < length else "goes on"
        raise ValueError(
            f"a whole STL file, its header announces {count:,} triangles ({length:,} bytes) and it "
            f"{state} at {len(data):,} bytes"
        )
    vertices = corners.reshape(-1, 3).astype(np.float64)
    faces = np.arange(len(vertices), dtype=np.int32).reshape(-1, 3)
    title = lines_of(data[:80].decode("latin-1"))[0]  # of text its first line, with its name
    metres, notes = commented(title)
    return MeshFile(Parts(vertices, faces, colours), notes=notes, commented=metres)


def _colours(data: bytes) -> ByteArray:
    """Colours of the triangles of an STL that :func:`write` has made, (m, 3); else (0, 3)."""
    count = int.from_bytes(data[80:84], "little")
    attributes = np.frombuffer(data, _TRIANGLE, count, 84)["attribute"]
    if not data.startswith(_HEADER) or not (attributes & _COLOURED).all():
        return NO_COLOURS
    parts = np.stack([attributes >> shift & 31 for shift in (10, 5, 0)], axis=1)
    return (parts << 3 | parts >> 2).astype(np.uint8)


def _text_facets(data: bytes, most_faces: int) -> FloatArray:
    lines = data.lower().replace(b"\r", b"\n").rstrip()
    if not lines.rpartition(b"\n")[2].lstrip().startswith(b"endsolid"):
        raise ValueError("a whole STL text, but it is cut off: endsolid is missing at its end")
    words = re.sub(rb"(?m)^[ \t]*(?:end)?solid\b[^\n]*$", b"", lines).split()
    if crowded := re.search(rb"(?m)^[ \t]*(?:end)?solid\b[^\n]*\bouter[ \t]+loop\b", lines):
        number = lines.count(b"\n", 0, crowded.start()) + 1
        raise ValueError(f"an STL text whose facets begin in lines of their own, see line {number}")
    pattern = _FACET.split()
    count, surplus = divmod(len(words), len(pattern))
    if max(map(len, words), default=0) > 40:
        raise ValueError("a whole STL text, one of its words is too long")
    table = np.array(words[: len(words) - surplus], dtype="S40").reshape(count, len(pattern))
    numbers = [k for k, word in enumerate(pattern) if word == b"_"]
    keywords = [k for k, word in enumerate(pattern) if word != b"_"]
    wrong = (table[:, keywords] != np.array(pattern)[keywords]).any(axis=1)
    if wrong.any() or surplus:
        facet = int(wrong.argmax()) if wrong.any() else count
        raise ValueError(f"an STL text of facets with three vertices, facet {facet + 1:,} is not")
    check_count(count, most_faces)
    try:
        return float_table(table[:, numbers[3:]]).reshape(-1, 3, 3)
    except ValueError:
        raise ValueError("an STL text, one of its coordinates is not a number") from None
