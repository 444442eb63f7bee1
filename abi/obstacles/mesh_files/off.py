"""Reader of OFF text files (Geomview manual, section 4.2.5)."""

from __future__ import annotations

import re
from collections import Counter

import numpy as np

from abi.obstacles.mesh_files.parts import MeshFile, Parts, check_count, loose_points
from abi.obstacles.mesh_files.polygons import flatness_notes, triangulate
from abi.obstacles.mesh_files.words import counted, float_words, lines_of, shown

_HEADER = re.compile(r"(?:ST)?C?N?OFF")
_COUNT = re.compile(r"[0-9]{1,9}").fullmatch
_MOST = 2_000_000


def read(data: bytes, most_faces: int) -> MeshFile:
    """Vertices and polygons; normals, colours and the number of edges are ignored.

    Raises:
        ValueError: says what it ought to be.
    """
    lines = [
        (number, words)
        for number, line in enumerate(lines_of(data.decode("latin-1")), 1)
        if (words := line.partition("#")[0].split())
    ]
    if not lines or not _HEADER.fullmatch(lines[0][1][0]):
        raise ValueError("an OFF text that begins with OFF, or with COFF, NOFF or STOFF")
    if lines[0][1][1:2] == ["BINARY"]:
        raise ValueError("an OFF text, this is a binary one: save it as text, or as PLY")
    counts, following = lines[0][1][1:], 1
    if not counts and len(lines) > 1:
        counts, following = lines[1][1], 2
    if len(counts) not in (2, 3) or not all(map(_COUNT, counts)):
        raise ValueError("an OFF text that begins with OFF and its counts")
    vertices, faces = int(counts[0]), int(counts[1])
    if max(vertices, faces) > _MOST:
        raise ValueError("fewer triangles, simplify the mesh first")
    rows = lines[following:]
    if len(rows) != vertices + faces:
        raise ValueError(
            f"a whole OFF file, it announces {vertices:,} vertices and {faces:,} faces and has "
            f"{len(rows):,} lines for them"
        )
    short = next((number for number, words in rows[:vertices] if len(words) < 3), None)
    if short is not None:
        raise ValueError(f"vertices of three numbers, line {short} has fewer")
    coordinates = [word.encode() for _, row in rows[:vertices] for word in row[:3]]
    points = float_words(coordinates, "vertices of numbers").reshape(-1, 3)
    polygons, numbers = [], []
    for number, row in rows[vertices:]:
        polygon = _polygon(row, vertices, number)
        if len(polygon) >= 3:
            polygons.append(polygon)
            numbers.append(number)
    corners = np.array([corner for polygon in polygons for corner in polygon], dtype=np.int32)
    sizes = np.array([len(polygon) for polygon in polygons], dtype=np.int32)
    tally = Counter[str]()
    triangles = triangulate(points, corners, sizes, lambda k: f"line {numbers[k]}", tally)
    check_count(len(triangles), most_faces)
    notes = [*flatness_notes(tally)]
    if left := faces - len(polygons):
        notes.append(f"{counted(left, 'face')} of fewer than three corners left out.")
    parts = Parts(points, triangles)
    return MeshFile(parts, notes=(*notes, *loose_points(parts)))


def _polygon(words: list[str], vertices: int, line: int) -> list[int]:
    """Corners in a line such as ``3 0 1 2 255 0 0``, which ends with a colour."""
    if not all(map(_COUNT, words[:1])) or len(words) <= int(words[0]):
        raise ValueError(f"faces that give their number of corners, line {line} does not")
    corners = words[1 : int(words[0]) + 1]
    wrong = next((w for w in corners if not _COUNT(w) or int(w) >= vertices), None)
    if wrong is not None:
        raise ValueError(f"faces of the {vertices:,} vertices, line {line} has {shown(wrong)}")
    return [int(corner) for corner in corners]
