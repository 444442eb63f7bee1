"""Reader of PLY, OFF, 3MF and DAE files by trimesh, with the checks that trimesh omits.

trimesh gets only the bytes, so it opens no other file. Archives are measured before they are
unpacked, XML may declare no entities, and the number of faces must be the one the file announces.
"""

from __future__ import annotations

import io
import lzma
import re
import struct
import zipfile
import zlib
from collections.abc import Iterable
from typing import Any

import numpy as np

from abi.arrays import ByteArray, FloatArray, IntArray

_GREY = 200
"""Of a part without a colour beside others that have one."""
_MOST_UNPACKED = 200_000_000
_MOST_ENTRIES = 1000
_MOST_FACES = 2_000_000
"""Faces announced above which a file is not looked at further."""
DAMAGED_ZIP: tuple[type[Exception], ...] = (
    *(zipfile.BadZipFile, zlib.error, lzma.LZMAError, struct.error),
    *(RuntimeError, NotImplementedError, EOFError, OSError, ValueError),
)
"""Exceptions raised when a zip archive is damaged or needs a password."""
_ENTITIES = re.compile(rb"<!(?:DOCTYPE|ENTITY)", re.IGNORECASE)
_ENCODING = re.compile(rb"""<\?xml[^>]{0,100}encoding\s*=\s*["']([^"']*)""")
_ENCODINGS = (b"utf-8", b"us-ascii", b"ascii", b"iso-8859-1", b"windows-1252")
_PLY_COUNT = re.compile(rb"element[ \t]+(vertex|face)[ \t]+([0-9]{1,9})[ \t]*\r?\n")


def read(data: bytes, suffix: str) -> tuple[FloatArray, IntArray, ByteArray]:
    """Vertices (n, 3), triangles (m, 3) and colours of a file, with all its parts in place.

    Coordinates are in the file's unit. The colours are (m, 3), or (0, 3) if it gives none.

    Args:
        data: content.
        suffix: of the file's name, such as ".ply".

    Raises:
        ValueError: damaged or not of that kind; says what is expected instead.
    """
    kind = suffix.removeprefix(".")
    announced = _CHECKS[suffix](data)
    import trimesh  # here, since it takes long to import

    try:
        scene = trimesh.load_scene(io.BytesIO(data), file_type=kind, process=False)
        mesh = scene.to_mesh()
        vertices = np.asarray(mesh.vertices, dtype=np.float64)
        faces = np.asarray(mesh.faces, dtype=np.int64)
        colours = _colours(scene.dump(), len(faces))
    except Exception as error:  # its readers raise whatever goes wrong in them
        reason = " ".join(str(error).split())[:80] or type(error).__name__
        raise ValueError(f"a whole {kind.upper()} file, this cannot be read ({reason})") from None
    if len(faces) < max(announced, 1):
        raise ValueError(
            f"a whole {kind.upper()} file, {len(faces):,} of {announced:,} faces are there"
            if announced
            else "a mesh, the file has no triangles"
        )
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise ValueError(f"a {kind.upper()} file whose faces have vertices")
    return vertices, faces.astype(np.int32), colours


def _colours(parts: Iterable[Any], count: int) -> ByteArray:
    """Colours of the triangles of a scene's parts, in their order, (m, 3); (0, 3) without any."""
    found, given = [np.empty((0, 3), dtype=np.uint8)], False
    for part in parts:
        visual = part.visual
        if visual.kind == "texture":
            colours, given = np.asarray(visual.material.main_color)[None], True
        elif visual.kind is None:
            colours = np.full((1, 4), _GREY)
        else:
            colours, given = np.asarray(visual.face_colors), True
        found.append(np.broadcast_to(colours[:, :3], (len(part.faces), 3)).astype(np.uint8))
    whole = np.concatenate(found)
    return whole if given and len(whole) == count else found[0]


def _ply_faces(data: bytes) -> int:
    header = data[: data.find(b"end_header") + 1]
    counts = dict(_PLY_COUNT.findall(header))
    if not data.startswith(b"ply") or b"vertex" not in counts or b"face" not in counts:
        raise ValueError("a PLY file with vertices and faces")
    return _modest(int(counts[b"face"]))


def _off_faces(data: bytes) -> int:
    lines = (line.partition(b"#")[0].split() for line in data[:4096].splitlines())
    words = [word for line in lines for word in line]
    if not words or words[0] != b"OFF" or not all(word.isdigit() for word in words[1:3]):
        raise ValueError("an OFF text that begins with OFF and its counts")
    return _modest(int(words[2])) if len(words) > 2 else 0


def _no_entities(data: bytes) -> int:
    if _ENTITIES.search(data):
        raise ValueError("an XML file without a document type")
    return 0


def _plain_xml(data: bytes) -> int:
    """Refuse entities, and what would hide them: other encodings, an archive behind the text."""
    encoding = _ENCODING.search(data[:200])
    if b"\0" in data or (encoding and encoding[1].lower() not in _ENCODINGS):
        raise ValueError("an XML file in UTF-8")
    if zipfile.is_zipfile(io.BytesIO(data)):
        raise ValueError("an XML file without an archive in it")
    return _no_entities(data)


def _archive(data: bytes) -> int:
    for name, content in _unpacked(data):
        if name.lower().endswith((".model", ".rels", ".xml")):
            _no_entities(content)
    return 0


def _unpacked(data: bytes) -> list[tuple[str, bytes]]:
    """Names and contents of an archive's files."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            entries = archive.infolist()
            small = sum(entry.file_size for entry in entries) <= _MOST_UNPACKED
            if small and len(entries) <= _MOST_ENTRIES:
                return [(entry.filename, archive.read(entry)) for entry in entries]
    except DAMAGED_ZIP:
        raise ValueError("a whole 3MF file, which is a zip archive") from None
    raise ValueError(f"an archive of at most {_MOST_UNPACKED // 1_000_000} MB unpacked")


def _modest(faces: int) -> int:
    if faces > _MOST_FACES:
        raise ValueError("fewer triangles, simplify the mesh first")
    return faces


_CHECKS = {".ply": _ply_faces, ".off": _off_faces, ".3mf": _archive, ".dae": _plain_xml}
SUFFIXES = tuple(_CHECKS)
