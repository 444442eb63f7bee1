"""Triangles of a mesh file: its parts, and how they are joined."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from abi.arrays import ByteArray, FloatArray, IntArray, read_only
from abi.obstacles.mesh_files.words import counted
from abi.obstacles.pose import LARGEST

NO_COLOURS: ByteArray = read_only(np.empty((0, 3), dtype=np.uint8))
_GREY = 200
"""Colour of parts without one beside coloured parts."""


class Parts(NamedTuple):
    """Triangles and their colours.

    Attributes:
        vertices: (n, 3), in the file's unit.
        faces: (m, 3) ids of the corners.
        colours: (m, 3), or (0, 3) if the file gives none.
    """

    vertices: FloatArray
    faces: IntArray
    colours: ByteArray = NO_COLOURS


@dataclass(frozen=True, eq=False)
class MeshFile:
    """Contents of a mesh file.

    Attributes:
        parts: all its triangles, each where the file places it, in the file's unit and axes.
        metres: length of its unit, [m]; None if the format or the file does not say.
        notes: sentences on what of the file is left out.
        up: axis that points up in the file; z where it does not say. Nothing is turned.
        commented: length of the unit that a comment names, where the format itself has none, [m].
    """

    parts: Parts
    metres: float | None = None
    notes: tuple[str, ...] = ()
    up: str = "z"
    commented: float | None = None


def placed(parts: Parts, pose: FloatArray) -> Parts:
    """The parts at an affine pose (4, 4); triangles of mirrored parts keep facing outward."""
    vertices = parts.vertices @ pose[:3, :3].T + pose[:3, 3]
    mirrored = np.linalg.det(pose[:3, :3]) < 0
    return Parts(vertices, parts.faces[:, ::-1] if mirrored else parts.faces, parts.colours)


def joined(several: Sequence[Parts]) -> Parts:
    """Join parts; those without a colour become grey beside coloured ones."""
    if not several:
        return Parts(np.empty((0, 3)), np.empty((0, 3), dtype=np.int32))
    firsts = np.cumsum([0, *(len(one.vertices) for one in several[:-1])]).astype(np.int32)
    faces = [one.faces + first for one, first in zip(several, firsts, strict=True)]
    colours = NO_COLOURS
    if any(len(one.colours) for one in several):
        rows = [
            one.colours if len(one.colours) else np.full((len(one.faces), 3), _GREY, np.uint8)
            for one in several
        ]
        colours = np.concatenate(rows)
    return Parts(np.concatenate([one.vertices for one in several]), np.concatenate(faces), colours)


def loose_points(parts: Parts) -> tuple[str, ...]:
    """Sentence on the vertices that no face uses; a point blocks nothing."""
    used = np.zeros(len(parts.vertices), dtype=np.bool_)
    used[parts.faces] = True
    loose = len(used) - int(used.sum())
    return (f"{counted(loose, 'point')} left out: no face has it.",) if loose else ()


def check_count(faces: int, most: int) -> None:
    """Refuse a mesh without triangles, or with more than ``most``.

    Raises:
        ValueError: says what it ought to be.
    """
    if faces == 0:
        raise ValueError("a mesh, but the file has no triangles")
    if faces > most:
        raise ValueError(f"at most {most:,} triangles, simplify the mesh first")


def check_points(points: FloatArray) -> None:
    """Refuse coordinates that are not finite, or too large.

    Raises:
        ValueError: says what they ought to be.
    """
    if not np.isfinite(points).all():
        raise ValueError("finite coordinates, but some are NaN or infinite")
    if np.abs(points).max(initial=0.0) > LARGEST:
        raise ValueError(f"coordinates of at most {LARGEST:g}")
