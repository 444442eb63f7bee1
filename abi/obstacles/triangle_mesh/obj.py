"""Reader of OBJ files: vertices and faces only."""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np

from abi.obstacles.triangle_mesh.parts import NO_COLOURS, Parts, check_count

_INDEX = re.compile(r"-?[0-9]{1,9}").fullmatch
_USUAL_FACE = re.compile("f" + 3 * r"\s+([0-9]{1,9})(?:/\S*)?" + r"\s*").fullmatch
"""A triangle's line, in all but a few files; it takes a third of the time."""


def read(data: bytes, most_faces: int) -> Parts:
    """Vertices and faces; a polygon becomes a fan of triangles.

    Args:
        data: the whole file.
        most_faces: triangles that it may have.

    Raises:
        ValueError: says what it ought to be.
    """
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError("an OBJ text, this is not text in UTF-8") from None
    if "\0" in text:
        raise ValueError("an OBJ text, this is a binary file")
    vertices: list[list[float]] = []
    faces: list[tuple[int, int, int]] = []
    for number, line in enumerate(text.replace("\\\n", " ").split("\n"), 1):
        if len(faces) > most_faces:
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
    check_count(len(faces), most_faces)
    return np.array(vertices, dtype=np.float64), np.array(faces, dtype=np.int32), NO_COLOURS


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
