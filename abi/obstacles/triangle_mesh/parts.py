"""Parts of a mesh file, as its reader returns them."""

from __future__ import annotations

import numpy as np

from abi.arrays import ByteArray, FloatArray, IntArray, read_only

Parts = tuple[FloatArray, IntArray, ByteArray]
"""Vertices (n, 3) in the file's unit, triangles (m, 3) and their colours (m, 3) or (0, 3)."""

NO_COLOURS: ByteArray = read_only(np.empty((0, 3), dtype=np.uint8))


def check_count(faces: int, most: int) -> None:
    """Refuse a mesh without triangles, or with more than ``most``.

    Raises:
        ValueError: says what it ought to be.
    """
    if faces == 0:
        raise ValueError("a mesh, the file has no triangles")
    if faces > most:
        raise ValueError(f"at most {most:,} triangles, simplify the mesh first")
