"""Reader of OBJ files: vertices and faces (Wavefront, Advanced Visualizer, appendix B1).

Names of groups, objects, materials and their libraries are text of any kind that is not used.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator

import numpy as np

from abi.obstacles.mesh_files.parts import MeshFile, Parts, check_count, loose_points
from abi.obstacles.mesh_files.polygons import flatness_notes, triangulate
from abi.obstacles.mesh_files.units import commented
from abi.obstacles.mesh_files.words import counted, lines_of, shown

_INDEX = re.compile(r"[+-]?[0-9]{1,9}").fullmatch
_USUAL_FACE = re.compile("f" + 3 * r"\s+([0-9]{1,9})(?:/\S*)?" + r"\s*").fullmatch
"""Pattern of a triangle's line, the fast path for all but a few files."""
_UNIT = re.compile(r"# abi unit (\S{1,40})")
"""First line of a file written by this package, with the unit of the original file."""
_LONGEST_UNIT = 1e4
"""Longest accepted unit, [m]."""
_CURVED = {"surf", "bzp", "bsp", "cdp"}
"""Statements of free-form surfaces, the last three from older versions of the format."""
_TEXT = re.compile(r"\s*(?:#|(?:[gos]|usemtl|mtllib|usemap|maplib|shadow_obj|trace_obj)\s)").match
"""Statements with text, in which a final backslash is part of a path."""
_WITHOUT_SURFACE = {
    *(
        "vt",
        "vn",
        "vp",
        "g",
        "o",
        "s",
        "mg",
        "usemtl",
        "mtllib",
        "usemap",
        "maplib",
        "lod",
        "bevel",
    ),
    *("c_interp", "d_interp", "shadow_obj", "trace_obj", "cstype", "deg", "bmat", "step", "parm"),
    *("trim", "hole", "scrv", "sp", "end", "con", "curv2", "ctech", "stech", "res", "maxsec"),
}
"""Statements that add nothing to polygons."""
_LINES = {"l": "line", "p": "point", "curv": "curve", "cdc": "curve"}


def write_unit(metres: float) -> str:
    """First line of a file with this unit, [m]."""
    return f"# abi unit {metres!r}"


def read(data: bytes, most_faces: int) -> MeshFile:
    """Read vertices and faces; lines and points are left out with a note.

    Raises:
        ValueError: says what it ought to be.
    """
    if b"\0" in data:
        raise ValueError("an OBJ text, but this is a binary file")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:  # only names can be other than ASCII, and are not used
        text = data.decode("latin-1")
    vertices: list[list[float]] = []
    corners: list[int] = []
    counts: list[int] = []
    numbers: list[int] = []
    left_out: dict[str, int] = {}
    unknown: dict[str, int] = {}
    weighted = 0
    for number, line in _lines(text):
        if len(counts) > most_faces:
            break
        if usual := _USUAL_FACE(line):
            a, b, c = int(usual[1]), int(usual[2]), int(usual[3])
            if min(a, b, c) > 0:
                corners += (a - 1, b - 1, c - 1)
                counts.append(3)
                numbers.append(number)
                continue
        words = line.split()
        kind = words[0] if words else ""
        if kind in ("v", "f", "fo") and "#" in line:
            words = line.partition("#")[0].split()
        if kind == "v":
            vertices.append(_numbers(words[1:], number))
            weighted += len(words) == 5 and float(words[4]) != 1
        elif kind in ("f", "fo"):
            polygon = [_corner(word, len(vertices), number) for word in words[1:]]
            if len(polygon) < 3:
                left_out["line"] = left_out.get("line", 0) + 1
                continue
            corners += polygon
            counts.append(len(polygon))
            numbers.append(number)
        elif kind in _LINES:
            left_out[_LINES[kind]] = left_out.get(_LINES[kind], 0) + 1
        elif kind in _CURVED:
            raise ValueError(
                f"an OBJ of polygons, line {number} has a curved surface ({kind}): convert it to a "
                "mesh in the program that wrote it"
            )
        elif kind in ("call", "csh"):
            raise ValueError(f"an OBJ on its own, line {number} calls another file")
        elif kind and not kind.startswith("#") and kind not in _WITHOUT_SURFACE:
            unknown.setdefault(shown(kind), number)
    check_count(len(counts), most_faces)
    points = np.array(vertices, dtype=np.float64)
    ids, sizes = np.array(corners, dtype=np.int32), np.array(counts, dtype=np.int32)
    for late in np.flatnonzero(ids >= len(vertices))[:1]:
        place = numbers[int(np.searchsorted(np.cumsum(sizes), late, side="right"))]
        raise ValueError(
            f"faces of the {len(vertices):,} vertices there are, line {place} has {ids[late] + 1:,}"
        )
    tally = Counter[str]()
    faces = triangulate(points, ids, sizes, lambda k: f"line {numbers[k]}", tally)
    check_count(len(faces), most_faces)
    notes = [f"{counted(n, noun)} left out: no surface." for noun, n in left_out.items()]
    if weighted:
        vertices_are = counted(weighted, "vertex", "vertices")
        notes.append(f"The weight of {vertices_are} left out: it is for curved surfaces.")
    if unknown:
        first = ", ".join(f"{kind} in line {number:,}" for kind, number in [*unknown.items()][:3])
        notes.append(f"What is no statement of OBJ is left out: {first}.")
    parts = Parts(points, faces)
    said, unknown_units = commented(
        "\n".join(line for line in lines_of(text) if line.lstrip(" \t")[:1] == "#")
    )
    notes += [*loose_points(parts), *unknown_units]
    return MeshFile(parts, _unit(text), (*flatness_notes(tally), *notes), commented=said)


def _lines(text: str) -> Iterator[tuple[int, str]]:
    """Lines with their numbers; a final backslash continues a line of numbers."""
    begun, start = "", 0
    for number, line in enumerate(lines_of(text), 1):
        start = start or number
        if line.endswith("\\") and (begun or not _TEXT(line)):
            begun += line[:-1] + " "
            continue
        yield start, begun + line if begun else line
        begun, start = "", 0
    if begun:
        yield start, begun


def _unit(text: str) -> float | None:
    found = _UNIT.match(text)
    try:
        metres = float(found[1]) if found else math.nan
    except ValueError:
        return None
    return metres if 0 < metres <= _LONGEST_UNIT else None


def _numbers(words: list[str], line: int) -> list[float]:
    """Coordinates of a vertex, perhaps followed by its weight or colour."""
    try:
        text = "".join(words)  # Python reads 1_0 and digits of other scripts, and others do not
        is_plain = text.isascii() and "_" not in text
        if is_plain and 3 <= len(words) <= 7 and max(map(len, words)) <= 40:
            return [float(word) for word in words][:3]
    except ValueError:
        pass
    raise ValueError(f"vertices of three numbers, line {line} has {shown(' '.join(words))}")


def _corner(word: str, vertices: int, line: int) -> int:
    """Index from 0 of a corner such as ``7``, ``7/1/2`` or ``-1``, which counts from the end."""
    index = word.partition("/")[0]
    if _INDEX(index):
        value = int(index)
        if value >= 1:
            return value - 1
        if -vertices <= value <= -1:
            return vertices + value
    raise ValueError(
        f"faces of vertices there are, line {line} has {word[:20]!r} where there are {vertices}"
    )
