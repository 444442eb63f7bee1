"""Strict reader of triangle meshes from the bytes of a file: STL, OBJ, GLB and others.

Common loaders turn a file that is truncated, or no mesh at all, into an empty mesh, and a missing
obstacle is the worst mistake a planner can make. So here lengths must match to the byte. Nothing
but the given bytes is ever opened: textures, materials and other files that a mesh may name are
not looked for.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import PurePosixPath

import numpy as np

from abi.arrays import ByteArray, FloatArray, IntArray
from abi.errors import SceneError
from abi.obstacles.pose import LARGEST
from abi.obstacles.triangle_mesh import glb, obj, stl, trimesh_formats
from abi.obstacles.triangle_mesh.parts import Parts, check_count

MAX_BYTES = 50_000_000
MAX_FACES = 500_000
SUFFIXES = (".stl", ".obj", ".glb", *trimesh_formats.SUFFIXES)

_OTHER_FORMATS = (
    (b"version https://git-lfs", "the mesh itself, but this is its Git LFS pointer (git lfs pull)"),
    (b"\x89PNG", "a mesh, but this is a PNG image"),
    (b"\xff\xd8\xff", "a mesh, but this is a JPEG image"),
    (b"PK\x03\x04", "an unpacked mesh, but this is a zip archive"),
    (b"\x1f\x8b", "an unpacked mesh, but this is a gzip archive"),
    (b"%PDF", "a mesh, but this is a PDF document"),
    (b"<", "a mesh, but this is a web page or XML"),
    (b"{", "a mesh in one file, but this is text in JSON (save glTF as .glb)"),
    (b"ply", "another ending, but this is a PLY file"),
)
_OWN = {b"PK\x03\x04": ".3mf", b"<": ".dae", b"ply": ".ply"}
"""Endings of files that may begin so."""


def read(data: bytes, name: str) -> tuple[FloatArray, IntArray]:
    """Vertices (n, 3) and triangles (m, 3) of a mesh file, as the file has them.

    Args:
        data: the whole content, at most 50 MB and 500,000 triangles.
        name: the file's name; its ending tells the format. It is not opened.

    Raises:
        SceneError: empty, cut off, damaged, too large or not a mesh; says which.
    """
    vertices, faces, _ = read_coloured(data, name)
    return vertices, faces


def read_coloured(data: bytes, name: str) -> tuple[FloatArray, IntArray, ByteArray]:
    """Vertices and triangles as from :func:`read`, and colours (m, 3) of the triangles.

    Only :mod:`abi.obstacles.triangle_mesh.trimesh_formats` and the STL files of
    :func:`abi.obstacles.triangle_mesh.stl.write` give colours; otherwise they are (0, 3).
    """
    if len(data) > MAX_BYTES:
        raise SceneError("file", name, f"a file of at most {MAX_BYTES // 1_000_000} MB")
    if not data.strip(b"\0 \t\r\n"):
        raise SceneError("file", name, "a mesh, but the file is empty")
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
        raise SceneError("file", name, "finite coordinates, but some are NaN or infinite")
    if np.abs(vertices).max() > LARGEST:
        raise SceneError("file", name, f"coordinates of at most {LARGEST:g}")
    return vertices, faces, colours


def _read_other(data: bytes, suffix: str) -> Parts:
    vertices, faces, colours = trimesh_formats.read(data, suffix)
    check_count(len(faces), MAX_FACES)
    return vertices, faces, colours


_READERS: dict[str, Callable[[bytes], Parts]] = {
    ".stl": lambda data: stl.read(data, MAX_FACES),
    ".obj": lambda data: obj.read(data, MAX_FACES),
    ".glb": lambda data: glb.read(data, MAX_FACES),
    **{suffix: partial(_read_other, suffix=suffix) for suffix in trimesh_formats.SUFFIXES},
}
