"""Zip archive of a scene: ``scene.yaml``, the meshes and the arm.

Meshes are stored as they were before their repair, as OBJ text with all digits; an arm is stored
as it was uploaded. A mesh whose file was of another format has its name as the comment of its
entry, so that the scene comes back equal, and other programs find OBJ files under the names that
``scene.yaml`` gives. An archive may come from anyone, so sizes and names are checked before
anything is unpacked.
"""

from __future__ import annotations

import io
import zipfile
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import PurePosixPath
from typing import Any

from abi.archive_members import members_of, without_folder
from abi.errors import SceneError
from abi.obstacles.mesh_files.obj import write_unit
from abi.obstacles.mesh_files.zip_archive import DAMAGED_ZIP
from abi.obstacles.triangle_mesh import mesh_reader
from abi.obstacles.triangle_mesh.file_names import same_name
from abi.obstacles.triangle_mesh.mesh_reader import SUFFIXES, read_surface
from abi.obstacles.triangle_mesh.mesh_source import Files
from abi.obstacles.triangle_mesh.surface import Surface
from abi.robot.urdf.robot import Robot
from abi.scene.scene_file import parse_bytes, text_of

SUFFIX = ".zip"
MAX_BYTES = 50_000_000
_MOST_UNPACKED = 200_000_000
_MOST_FILES = 2_000
_ARMS = (".urdf", ".zip", ".srdf")
_SCENES = ("scene.yaml", "scene.yml", "scene.json")
_STORED = ".obj"
_FIELD = "scene"


def pack(data: Mapping[str, Any], files: Files) -> bytes:
    """Pack a scene into an archive.

    Args:
        data: plain data, as in a scene file.
        files: surfaces of its mesh files, and its robot unless that is a shipped one, by name.

    Raises:
        SceneError: it is too large to be read again.
    """
    names = _stored_names([name for name, one in files.items() if isinstance(one, Surface)])
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive:
        archive.writestr(*text_of(_renamed(data, names)))
        for file, content in files.items():
            if not isinstance(content, Surface):
                stored = content.archive if isinstance(content, Robot) else content
                assert isinstance(stored, bytes)
                archive.writestr(file, stored)
                continue
            text = _obj(content).encode()
            count = text.count(b"\nf ")
            if len(text) > mesh_reader.MAX_BYTES or count > mesh_reader.MAX_FACES:
                expected = "a mesh of at most 500,000 triangles, and 50 MB with all its digits"
                raise SceneError("file", file, expected)
            archive.writestr(names[file], text)
            if file != names[file]:
                archive.getinfo(names[file]).comment = file.encode()
    if len(packed.getvalue()) > MAX_BYTES:
        megabytes = f"{len(packed.getvalue()) // 1_000_000} MB"
        raise SceneError(_FIELD, megabytes, "at most 50 MB, with fewer or smaller meshes")
    return packed.getvalue()


def unpack(content: bytes, name: str) -> tuple[object, dict[str, bytes | Surface]]:
    """Unpack the plain data of a scene, and the content of its meshes and arms by name.

    A mesh that was of another format than it is stored in is read, and comes as a surface.

    Args:
        content: content of the archive.
        name: name of the archive, for errors.

    Raises:
        SceneError: damaged, too large, without a scene, or with a mesh that cannot be read.
    """
    if len(content) > MAX_BYTES:
        raise SceneError(_FIELD, name, f"a file of at most {MAX_BYTES // 1_000_000} MB")
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            entries = members_of(archive)
            size = sum(entry.file_size for entry in entries.values())
            if size > _MOST_UNPACKED or len(entries) > _MOST_FILES:
                limit = f"{_MOST_FILES:,} files of {_MOST_UNPACKED // 1_000_000} MB in all"
                raise SceneError(_FIELD, name, f"an archive of at most {limit}")
            files = _in_one_folder(entries, name)
            scene = next(file for file in files if file.lower() in _SCENES)
            data = parse_bytes(archive.read(files[scene]), scene)
            stored = {
                file: archive.read(entry)
                for file, entry in files.items()
                if PurePosixPath(file).suffix.lower() in (*SUFFIXES, *_ARMS)
            }
    except DAMAGED_ZIP:
        expected = "a whole zip archive in which each file is once, whatever its slashes"
        raise SceneError(_FIELD, name, expected) from None
    names = _original_names(files)
    contents: dict[str, bytes | Surface] = {}
    for file, original in names.items():
        contents[original] = read_surface(stored.pop(file), file)
    data = _renamed(data, names)
    given = {**stored, **contents}
    found = {name: same_name(name, given) for name in _named(data)}
    return data, {**given, **{name: given[one] for name, one in found.items() if one is not None}}


def _in_one_folder(entries: Mapping[str, zipfile.ZipInfo], name: str) -> dict[str, zipfile.ZipInfo]:
    """Files in the scene's folder by their names there; ``name`` is that of the archive."""
    scenes = [path for path in map(PurePosixPath, entries) if path.name.lower() in _SCENES]
    if not scenes:
        raise SceneError(_FIELD, name, "an archive with a scene.yaml in it")
    depth = min(len(scene.parts) for scene in scenes)
    outer = sorted(scene for scene in scenes if len(scene.parts) == depth)
    if len(outer) > 1:
        names = " and ".join(map(str, outer[:4]))
        raise SceneError(_FIELD, name, f"an archive of one scene, not of {names}")
    folder = outer[0].parent
    inside = {without_folder(file, folder): entry for file, entry in entries.items()}
    return {file: entry for file, entry in inside.items() if file is not None}


def _stored_names(files: Sequence[str]) -> dict[str, str]:
    """Name of the OBJ file for each mesh file: its own, or one that is not taken."""
    names = {file: file for file in files if file.lower().endswith(_STORED)}
    for file in files:
        if file in names:
            continue
        path = PurePosixPath(file)
        choices = (path.with_name(f"{path.stem}{k}{_STORED}") for k in ("", *range(2, 1 << 16)))
        names[file] = next(name for name in map(str, choices) if name not in names.values())
    return names


def _original_names(entries: Mapping[str, zipfile.ZipInfo]) -> dict[str, str]:
    """Original name of the mesh file for each OBJ file converted from another format.

    Other programs write comments, too: only one that :func:`pack` may have written is a name, and
    none that two files share.
    """
    names = {
        file: entry.comment.decode(errors="replace")
        for file, entry in entries.items()
        if file.lower().endswith(_STORED)
    }
    given = Counter(names.values())
    return {
        file: name
        for file, name in names.items()
        if PurePosixPath(name).suffix.lower() in SUFFIXES
        and name not in entries
        and given[name] == 1
        and _may_be_stored(name, file)
    }


def _may_be_stored(name: str, stored: str) -> bool:
    """Check whether a mesh file may be stored under a name: its own with another suffix."""
    mesh, path = PurePosixPath(name), PurePosixPath(stored)
    number = path.stem.removeprefix(mesh.stem)
    return mesh.parent == path.parent and (
        path.stem == mesh.stem or (number.isdecimal() and path.stem == mesh.stem + number)
    )


def _renamed(data: Any, names: Mapping[str, str]) -> Any:
    """Plain data of an unvalidated scene with mesh files renamed."""
    if not isinstance(data, Mapping):
        return data
    found, arm = dict(data), data.get("arm")
    if isinstance(data.get("obstacles"), list):
        found["obstacles"] = [_with_name(one, names) for one in data["obstacles"]]
    if isinstance(arm, Mapping) and "attached" in arm:
        found["arm"] = {**arm, "attached": _with_name(arm["attached"], names)}
    return found


def _with_name(shape: Any, names: Mapping[str, str]) -> Any:
    """Plain data of a shape with its mesh file renamed."""
    file = shape.get("file") if isinstance(shape, Mapping) else None
    return {**shape, "file": names[file]} if isinstance(file, str) and file in names else shape


def named_meshes(data: Any) -> set[str]:
    """Names of mesh files in plain data of an unvalidated scene: of obstacles and a held object."""
    fields = data if isinstance(data, Mapping) else {}
    entries, arm = fields.get("obstacles"), fields.get("arm")
    shapes = [*(entries if isinstance(entries, list) else ())]
    shapes.append(arm.get("attached") if isinstance(arm, Mapping) else None)
    names = (one.get("file") for one in shapes if isinstance(one, Mapping))
    return {name for name in names if isinstance(name, str)}


def _named(data: Any) -> set[str]:
    """Names of files in plain data of an unvalidated scene."""
    arm = data.get("arm") if isinstance(data, Mapping) else None
    names = [arm.get(key) for key in ("urdf", "srdf")] if isinstance(arm, Mapping) else []
    return named_meshes(data) | {name for name in names if isinstance(name, str)}


def _obj(surface: Surface) -> str:
    places, corners = surface.given or (surface.vertices, surface.faces)
    vertices = [f"v {x!r} {y!r} {z!r}" for x, y, z in places.tolist()]
    faces = [f"f {a} {b} {c}" for a, b, c in (corners + 1).tolist()]
    unit = [] if surface.metres is None else [write_unit(surface.metres)]
    return "\n".join([*unit, *vertices, *faces, ""])
