"""Strict reader of triangle meshes from the bytes of a file: STL, OBJ, GLB and others.

Common loaders turn a file that is truncated, or no mesh at all, into an empty mesh, and a missing
obstacle is the worst mistake a planner can make. So here lengths must match to the byte, what is
left out is named in a note, and the number of triangles must be the one that
:mod:`abi.obstacles.mesh_files.census` counts. Nothing but the given bytes is ever opened: textures,
materials and other files that a mesh may name are not looked for.

Coordinates are in the axes of the file, whichever of them points up.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import PurePosixPath

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.errors import SceneError
from abi.obstacles.mesh_files import census, dae, glb, obj, off, ply, stl, threemf
from abi.obstacles.mesh_files.parts import MeshFile, check_count, check_points
from abi.obstacles.triangle_mesh.repair import clean
from abi.obstacles.triangle_mesh.surface import Surface

MAX_BYTES = 50_000_000
MAX_FACES = 500_000

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
"""Endings of files that may begin with these bytes."""


def read(data: bytes, name: str) -> tuple[FloatArray, IntArray]:
    """Vertices (n, 3) and triangles (m, 3) of a mesh file, as from :func:`read_file`."""
    parts = read_file(data, name).parts
    return parts.vertices, parts.faces


def read_surface(data: bytes, name: str) -> Surface:
    """The repaired surface of a mesh file, as from :func:`read_file`.

    Raises:
        SceneError: it cannot be read, or no triangle has an area.
    """
    file = read_file(data, name)
    axis = () if file.up == "z" else (f"Its {file.up} axis points up, and it is not turned.",)
    surface = clean(file.parts.vertices, file.parts.faces, name)
    return surface.of_file(file.metres or file.commented, (*axis, *file.notes))


def read_file(data: bytes, name: str) -> MeshFile:
    """Triangles of a mesh file with their colours, its unit, and notes on what is left out.

    Args:
        data: the whole content, at most 50 MB and 500,000 triangles.
        name: the file's name; its ending tells the format. It is not opened.

    Raises:
        SceneError: empty, cut off, damaged, too large or not a mesh; says which.
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
            file = _READERS[suffix](data, MAX_FACES)
        found = len(file.parts.faces)
        check_count(found, MAX_FACES)
        check_points(file.parts.vertices)
        if (announced := census.count(data, suffix)) != found:
            raise ValueError(
                f"a whole {suffix[1:].upper()} file, it announces {announced:,} triangles and "
                f"{found:,} are there"
            )
    except ValueError as error:
        raise SceneError("file", name, str(error)) from None
    return file


_READERS: dict[str, Callable[[bytes, int], MeshFile]] = {
    **{".stl": stl.read, ".obj": obj.read, ".glb": glb.read, ".ply": ply.read, ".off": off.read},
    **{".3mf": threemf.read, ".dae": dae.read},
}
SUFFIXES = tuple(_READERS)
