"""Zip archive of a scene: ``scene.yaml``, the meshes and the arm.

Meshes are stored repaired, as OBJ text with all digits; an arm is stored as it was uploaded. An
archive may come from anyone, so sizes and names are checked before anything is unpacked.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import Any

from abi.errors import SceneError
from abi.obstacles.triangle_mesh.mesh_reader import SUFFIXES
from abi.obstacles.triangle_mesh.surface import Surface
from abi.obstacles.triangle_mesh.trimesh_formats import DAMAGED_ZIP
from abi.scene.scene_file import parse_bytes, text_of

SUFFIX = ".zip"
MAX_BYTES = 50_000_000
_MOST_UNPACKED = 200_000_000
_MOST_FILES = 200
_ARMS = (".urdf", ".zip")
_SCENES = ("scene.yaml", "scene.yml", "scene.json")
_FIELD = "scene"


def pack(
    data: Mapping[str, Any], surfaces: Mapping[str, Surface], arms: Mapping[str, bytes]
) -> bytes:
    """Pack a scene into an archive.

    Args:
        data: plain data, as in a scene file.
        surfaces: surfaces of its mesh files, by name.
        arms: the file of its arm, by name, unless the arm is a shipped one.

    Raises:
        SceneError: it is too large to be read again.
    """
    names: dict[str, str] = {}
    for file in surfaces:
        stem = PurePosixPath(file).stem
        choices = [f"{stem}.obj", *(f"{stem}-{k}.obj" for k in range(2, len(surfaces) + 2))]
        names[file] = next(name for name in choices if name not in names.values())
    obstacles = [
        {**one, "file": names[one["file"]]} if "file" in one else one for one in data["obstacles"]
    ]
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive:
        archive.writestr(*text_of({**data, "obstacles": obstacles}))
        for file, surface in surfaces.items():
            archive.writestr(names[file], _obj(surface))
        for file, arm in arms.items():
            archive.writestr(file, arm)
    content = packed.getvalue()
    if len(content) > MAX_BYTES:
        raise SceneError(
            _FIELD, f"{len(content) // 1_000_000} MB", "at most 50 MB, with fewer or smaller meshes"
        )
    return content


def unpack(content: bytes, name: str) -> tuple[object, dict[str, bytes]]:
    """Unpack the plain data of a scene, and the content of its meshes and arms by name.

    Args:
        content: content of the archive.
        name: name of the archive, for errors.

    Raises:
        SceneError: damaged, too large, or without a scene.
    """
    if len(content) > MAX_BYTES:
        raise SceneError(_FIELD, name, f"a file of at most {MAX_BYTES // 1_000_000} MB")
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            # is_dir() asks for the last letter of a name that may have none
            entries = [one for one in archive.infolist() if not one.filename.endswith("/")]
            size = sum(entry.file_size for entry in entries)
            if size > _MOST_UNPACKED or len(entries) > _MOST_FILES:
                limit = f"{_MOST_FILES} files of {_MOST_UNPACKED // 1_000_000} MB in all"
                raise SceneError(_FIELD, name, f"an archive of at most {limit}")
            files = {entry.filename: entry for entry in entries}
            scene = next((file for file in _SCENES if file in files), None)
            if scene is None:
                raise SceneError(_FIELD, name, "an archive with a scene.yaml in it")
            data = parse_bytes(archive.read(files[scene]), scene)
            meshes = {
                file: archive.read(entry)
                for file, entry in files.items()
                if PurePosixPath(file).suffix.lower() in (*SUFFIXES, *_ARMS)
            }
    except DAMAGED_ZIP:
        raise SceneError(_FIELD, name, "a whole zip archive, but this is damaged") from None
    return data, meshes


def _obj(surface: Surface) -> str:
    vertices = [f"v {x!r} {y!r} {z!r}" for x, y, z in surface.vertices.tolist()]
    faces = [f"f {a} {b} {c}" for a, b, c in (surface.faces + 1).tolist()]
    return "\n".join([*vertices, *faces, ""])
