"""Triangle meshes from the bytes of a file: STL, OBJ, GLB and others, read strictly.

Common loaders turn a file that is cut off or not a mesh at all into an empty mesh, and a missing
obstacle is the worst mistake a planner can make. So here lengths must fit to the byte,
and nothing but the bytes given is ever opened: textures, materials and other files a mesh may name
are not looked for.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from pathlib import PurePosixPath

import numpy as np

from abi.arrays import ByteArray, FloatArray, IntArray, read_only
from abi.errors import SceneError
from abi.obstacles.pose import LARGEST
from abi.obstacles.triangle_mesh import glb, trimesh_formats

MAX_BYTES = 50_000_000
MAX_FACES = 500_000
SUFFIXES = (".stl", ".obj", ".glb", *trimesh_formats.SUFFIXES)

_OTHER_FORMATS = (
    (b"version https://git-lfs", "the mesh itself, this is its Git LFS pointer (git lfs pull)"),
    (b"\x89PNG", "a mesh, this is a PNG image"),
    (b"\xff\xd8\xff", "a mesh, this is a JPEG image"),
    (b"PK\x03\x04", "an unpacked mesh, this is a zip archive"),
    (b"\x1f\x8b", "an unpacked mesh, this is a gzip archive"),
    (b"%PDF", "a mesh, this is a PDF document"),
    (b"<", "a mesh, this is a web page or XML"),
    (b"{", "a mesh in one file, this is text in JSON (save glTF as .glb)"),
    (b"ply", "another ending, this is a PLY file"),
)
_OWN = {b"PK\x03\x04": ".3mf", b"<": ".dae", b"ply": ".ply"}
"""Endings of files that may begin so."""

_Mesh = tuple[FloatArray, IntArray, ByteArray]
_INDEX = re.compile(r"-?[0-9]{1,9}").fullmatch
_USUAL_FACE = re.compile("f" + 3 * r"\s+([0-9]{1,9})(?:/\S*)?" + r"\s*").fullmatch
"""A triangle's line, in all but a few files; it takes a third of the time."""
_NO_COLOURS: ByteArray = read_only(np.empty((0, 3), dtype=np.uint8))
_HEADER = b"abi".ljust(80)
_COLOURED = 1 << 15
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_FACET = b"facet normal _ _ _ outer loop vertex _ _ _ vertex _ _ _ vertex _ _ _ endloop endfacet"


def read(data: bytes, name: str) -> tuple[FloatArray, IntArray]:
    """Vertices (n, 3) and triangles (m, 3) of a mesh file, as they stand there.

    Args:
        data: the whole content, at most 50 MB and 500,000 triangles.
        name: the file's name; its ending tells the format. It is not opened.

    Raises:
        SceneError: empty, cut off, damaged, too large or not a mesh; says which.
    """
    vertices, faces, _ = read_coloured(data, name)
    return vertices, faces


def read_coloured(data: bytes, name: str) -> tuple[FloatArray, IntArray, ByteArray]:
    """Vertices and triangles as of :func:`read`, and colours (m, 3) of these.

    Without colours, which :mod:`abi.obstacles.triangle_mesh.trimesh_formats` alone and the STL of
    :func:`stl` give, the last are (0, 3).
    """
    if len(data) > MAX_BYTES:
        raise SceneError("file", name, f"a file of at most {MAX_BYTES // 1_000_000} MB")
    if not data.strip(b"\0 \t\r\n"):
        raise SceneError("file", name, "a mesh, the file is empty")
    start = data[:64].lstrip(b"\xef\xbb\xbf \t\r\n")
    suffix = PurePosixPath(name).suffix.lower()
    for signature, expected in _OTHER_FORMATS:
        if start.startswith(signature) and suffix != _OWN.get(signature):
            raise SceneError("file", name, expected)
    try:
        with np.errstate(invalid="ignore", over="ignore"):  # NaN and inf are looked for below
            vertices, faces, colours = _READERS[suffix](data)
    except ValueError as error:
        raise SceneError("file", name, str(error)) from None
    if not np.isfinite(vertices).all():
        raise SceneError("file", name, "finite coordinates, some are NaN or infinite")
    if np.abs(vertices).max() > LARGEST:
        raise SceneError("file", name, f"coordinates of at most {LARGEST:g}")
    return vertices, faces, colours


def stl(vertices: FloatArray, faces: IntArray, colours: ByteArray = _NO_COLOURS) -> bytes:
    """A binary STL of vertices (n, 3), triangles (m, 3) and their colours (m, 3) or (0, 3).

    Colours are where many programs have them: five bits each in the attribute, the sixteenth set.
    """
    table = np.zeros(len(faces), _TRIANGLE)
    table["corners"] = vertices[faces]
    if len(colours):
        red, green, blue = (colours.T >> 3).astype(np.uint16)
        table["attribute"] = _COLOURED | red << 10 | green << 5 | blue
    return _HEADER + len(table).to_bytes(4, "little") + table.tobytes()


def _stl_colours(data: bytes) -> ByteArray:
    """Colours of the triangles of an STL that :func:`stl` has made, (m, 3); else (0, 3)."""
    count = int.from_bytes(data[80:84], "little")
    attributes = np.frombuffer(data, _TRIANGLE, count, 84)["attribute"]
    if not data.startswith(_HEADER) or not (attributes & _COLOURED).all():
        return _NO_COLOURS
    parts = np.stack([attributes >> shift & 31 for shift in (10, 5, 0)], axis=1)
    return (parts << 3 | parts >> 2).astype(np.uint8)


def _read_stl(data: bytes) -> _Mesh:
    """Triangles of an STL; binary when the length fits the count in its header."""
    colours = _NO_COLOURS
    count = int.from_bytes(data[80:84], "little") if len(data) >= 84 else 0
    length = 84 + _TRIANGLE.itemsize * count
    if len(data) >= 84 and len(data) == length:
        _refuse_count(count)
        corners = np.frombuffer(data, _TRIANGLE, count, 84)["corners"]
        colours = _stl_colours(data)
    elif data.lstrip()[:5].lower() == b"solid" and b"\0" not in data:
        corners = _text_facets(data)
    elif len(data) < 84:
        raise ValueError(f"an STL file, this is cut off after {len(data)} bytes")
    else:
        state = "is cut off" if len(data) < length else "goes on"
        raise ValueError(
            f"a whole STL file, its header announces {count:,} triangles ({length:,} bytes) and it "
            f"{state} at {len(data):,} bytes"
        )
    vertices = corners.reshape(-1, 3).astype(np.float64)
    return vertices, np.arange(len(vertices), dtype=np.int32).reshape(-1, 3), colours


def _text_facets(data: bytes) -> FloatArray:
    lines = data.lower().rstrip()
    if not lines.rpartition(b"\n")[2].lstrip().startswith(b"endsolid"):
        raise ValueError("a whole STL text, it is cut off: endsolid is missing at its end")
    words = re.sub(rb"(?m)^[ \t]*(?:end)?solid\b[^\n]*$", b"", lines).split()
    pattern = _FACET.split()
    count, surplus = divmod(len(words), len(pattern))
    if surplus or max(map(len, words), default=0) > 40:
        raise ValueError("a whole STL text, a facet of it is not complete")
    _refuse_count(count)
    table = np.array(words, dtype="S40").reshape(count, len(pattern))
    numbers = [k for k, word in enumerate(pattern) if word == b"_"]
    keywords = [k for k, word in enumerate(pattern) if word != b"_"]
    if (table[:, keywords] != np.array(pattern)[keywords]).any():
        raise ValueError("an STL text of facets with three vertices each")
    try:
        return table[:, numbers[3:]].astype(np.float64).reshape(-1, 3, 3)
    except ValueError:
        raise ValueError("an STL text, one of its coordinates is not a number") from None


def _read_obj(data: bytes) -> _Mesh:
    """Vertices and faces alone; a polygon becomes a fan of triangles."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError("an OBJ text, this is not text in UTF-8") from None
    if "\0" in text:
        raise ValueError("an OBJ text, this is a binary file")
    vertices: list[list[float]] = []
    faces: list[tuple[int, int, int]] = []
    for number, line in enumerate(text.replace("\\\n", " ").split("\n"), 1):
        if len(faces) > MAX_FACES:
            break
        if usual := _USUAL_FACE(line):
            a, b, c = int(usual[1]), int(usual[2]), int(usual[3])
            if min(a, b, c) > 0 and max(a, b, c) <= len(vertices):
                faces.append((a - 1, b - 1, c - 1))
                continue
        words = line.split()
        if not words:
            continue
        if words[0] == "v":
            vertices.append(_numbers(words[1:4], number))
        elif words[0] == "f":
            corners = [_corner(word, len(vertices), number) for word in words[1:]]
            if not 3 <= len(corners) <= 1000:
                raise ValueError(f"faces of 3 to 1000 corners, line {number} has {len(corners)}")
            faces += [(corners[0], b, c) for b, c in pairwise(corners[1:])]
        elif words[0] in ("call", "csh"):
            raise ValueError(f"an OBJ on its own, line {number} calls another file")
        elif words[0] == "mtllib" and not re.fullmatch(r"[^/\\:]+", " ".join(words[1:])):
            raise ValueError(f"an OBJ on its own, line {number} names a file in another folder")
    _refuse_count(len(faces))
    return np.array(vertices, dtype=np.float64), np.array(faces, dtype=np.int32), _NO_COLOURS


def _numbers(words: list[str], line: int) -> list[float]:
    try:
        if len(words) == 3 and max(map(len, words)) <= 40:
            return [float(word) for word in words]
    except ValueError:
        pass
    raise ValueError(f"vertices of three numbers, line {line} has {' '.join(words)[:40]!r}")


def _corner(word: str, vertices: int, line: int) -> int:
    """Index from 0 of a corner such as ``7``, ``7/1/2`` or ``-1``, which counts from the end."""
    index = word.partition("/")[0]
    if _INDEX(index):
        value = int(index)
        if 1 <= value <= vertices:
            return value - 1
        if -vertices <= value <= -1:
            return vertices + value
    raise ValueError(
        f"faces of vertices that stand before them, line {line} has {word[:20]!r} where there are "
        f"{vertices}"
    )


def _read_glb(data: bytes) -> _Mesh:
    return *glb.read(data, MAX_FACES), _NO_COLOURS


def _read_other(data: bytes, suffix: str) -> _Mesh:
    vertices, faces, colours = trimesh_formats.read(data, suffix)
    _refuse_count(len(faces))
    return vertices, faces, colours


def _refuse_count(faces: int) -> None:
    if faces == 0:
        raise ValueError("a mesh, the file has no triangles")
    if faces > MAX_FACES:
        raise ValueError(f"at most {MAX_FACES:,} triangles, simplify the mesh first")


_READERS: dict[str, Callable[[bytes], _Mesh]] = {
    ".stl": _read_stl,
    ".obj": _read_obj,
    ".glb": _read_glb,
    **{suffix: partial(_read_other, suffix=suffix) for suffix in trimesh_formats.SUFFIXES},
}
