"""Sources of robots: shipped arms, files beside the scene, and uploaded archives."""

from __future__ import annotations

import contextlib
import io
import zipfile
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import PurePosixPath

from abi import assets
from abi.errors import SceneError
from abi.obstacles.mesh_files.threemf import DAMAGED_ZIP
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.mesh_lookup import MeshLookup, is_plain
from abi.robot.robot import Robot, require_motion
from abi.robot.urdf_meshes import mesh_names
from abi.robot.urdf_reader import read_srdf, read_urdf

SHIPPED: Mapping[str, str] = {"ur5e": "tool0", "panda": "panda_hand_tcp", "xarm7": "link_eef"}
"""Usual tip of each arm that comes with the package, by its name."""

_MAX_ARCHIVE, _MAX_UNPACKED, _MAX_FILES = 30_000_000, 100_000_000, 400
_ROOM = 0.9
"""Part of an archive's size that meshes for looks alone may fill it to."""
_ZIP = b"PK\x03\x04"
_EPOCH = (1980, 1, 1, 0, 0, 0)


def load_robot(name: str, source: MeshSource, plain: bool = False) -> Robot:
    """Load a shipped arm by name, or the arm of a ``.urdf`` or ``.zip`` file.

    Args:
        name: in :data:`SHIPPED`, or of a file.
        source: of the files.
        plain: whether to make its archive one that can be read without trimesh.

    Raises:
        SceneError: there is no such arm, or its files are refused.
    """
    if name in SHIPPED:
        return _shipped(name)
    content = archive_of(name, source)
    return robot_from_archive(_plain(content) if plain else content)


def archive_of(name: str, source: MeshSource) -> bytes:
    """Content of a ``.zip`` file, or a ``.urdf`` file packed with the meshes that it names.

    The meshes are not read.

    Raises:
        SceneError: the file has another ending, or one that it needs is missing.
    """
    ending = PurePosixPath(name).suffix.lower()
    if ending in (".zip", ".urdf"):
        content = _content(source, name)
        # an arm that a scene has read already is kept as an archive, whatever it was
        packed = ending == ".zip" or content.startswith(_ZIP)
        return content if packed else _packed(source, name)
    expected = f"one of {', '.join(SHIPPED)}, or a file that ends in .urdf or .zip"
    raise SceneError("arm.urdf", name, expected)


@lru_cache(maxsize=8)
def robot_from_archive(content: bytes) -> Robot:
    """Read the robot in a zip archive of one URDF, its meshes and optionally an SRDF.

    Raises:
        SceneError: it is no such file, it is too large packed or unpacked,
            :func:`abi.robot.urdf_reader.read_urdf` refuses it, or nothing of it can move.
    """
    robot = _read(content)[0]
    require_motion(robot)
    return robot


def packed(files: Mapping[str, bytes], compression: int = zipfile.ZIP_DEFLATED) -> bytes:
    """Files by their paths as a zip, the same for the same files."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        for name, data in files.items():
            archive.writestr(zipfile.ZipInfo(name, _EPOCH), data, compression)
    return content.getvalue()


def unpacked(content: bytes) -> dict[str, bytes]:
    """Files of an archive by their paths, no more of each than it says beforehand.

    Raises:
        SceneError: it is damaged, or too large.
    """
    if len(content) > _MAX_ARCHIVE:
        expected = f"an archive of at most {_MAX_ARCHIVE // 10**6} MB"
        raise SceneError("arm.urdf", f"{len(content):,} bytes", expected)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            # is_dir() asks for the last letter of a name that may have none
            members = [one for one in archive.infolist() if not one.filename.endswith("/")]
            size = sum(member.file_size for member in members)
            if len(members) <= _MAX_FILES and size <= _MAX_UNPACKED:
                return {member.filename: archive.read(member) for member in members}
    except DAMAGED_ZIP as error:
        expected = "a whole zip archive without a password"
        raise SceneError("arm.urdf", str(error)[:60], expected) from None
    value = f"{len(members)} files of {size:,} bytes"
    expected = f"at most {_MAX_FILES} files of {_MAX_UNPACKED // 10**6} MB in all"
    raise SceneError("arm.urdf", value, expected)


def _read(content: bytes) -> tuple[Robot, dict[str, bytes]]:
    """A robot, and its files with each mesh in a format that needs no trimesh."""
    files = unpacked(content)
    found = [name for name in files if name.lower().endswith(".urdf")]
    if len(found) != 1:
        names = ", ".join(sorted(PurePosixPath(name).name for name in found)[:4]) or "none"
        raise SceneError("arm.urdf", names, "one file that ends in .urdf in the archive")
    lookup = MeshLookup(files, PurePosixPath(found[0]).parent)
    robot = read_urdf(files[found[0]], PurePosixPath(found[0]).name, lookup)
    texts = {name: files[name] for name in files if name.lower().endswith((".urdf", ".srdf"))}
    return _with_srdf(replace(robot, archive=content), files), texts | lookup.plain()


def _plain(content: bytes) -> bytes:
    """An archive without meshes that trimesh reads: an STL each, or nothing where it cannot."""
    if all(is_plain(name) for name in unpacked(content)):
        return content
    return packed(_read(content)[1])


def _with_srdf(robot: Robot, files: Mapping[str, bytes]) -> Robot:
    """The robot with what the SRDF among its files says; itself where there is none."""
    found = [name for name in files if name.lower().endswith(".srdf")]
    if not found:
        return robot
    if len(found) > 1:
        names = ", ".join(sorted(PurePosixPath(name).name for name in found)[:4])
        raise SceneError("arm.urdf", names, "at most one file that ends in .srdf in the archive")
    pairs = read_srdf(files[found[0]], PurePosixPath(found[0]).name)
    known = frozenset(pair for pair in pairs if pair <= robot.links.keys())
    note = f"{len(known)} pairs of links are not checked against each other: its SRDF says so."
    return replace(robot, may_touch=known, notes=(*robot.notes, note))


@lru_cache(maxsize=8)
def _shipped(name: str) -> Robot:
    return robot_from_archive(_packed(MeshSource(folder=assets.path("urdf", name)), f"{name}.urdf"))


def _packed(source: MeshSource, urdf: str) -> bytes:
    """A URDF and the meshes that it names as a zip, the same for the same files.

    Meshes that are for looks alone come along where they are there and there is room.
    """
    text, folder = _content(source, urdf), PurePosixPath(urdf).parent
    needed, looks = (
        [(folder / name).as_posix() for name in names]
        for names in mesh_names(text, PurePosixPath(urdf).name)
    )
    files = {urdf: text, **{name: _content(source, name) for name in needed}}
    for name in looks[: _MAX_FILES // 2]:
        with contextlib.suppress(SceneError):
            mesh = source.content(name)
            if sum(map(len, files.values())) + len(mesh) < _ROOM * _MAX_ARCHIVE:
                files[name] = mesh
    with contextlib.suppress(SceneError):  # one of the same name is welcome, and not needed
        beside = PurePosixPath(urdf).with_suffix(".srdf").as_posix()
        files[beside] = source.content(beside)
    return packed(files, zipfile.ZIP_STORED)


def _content(source: MeshSource, name: str) -> bytes:
    try:
        return source.content(name)
    except SceneError as error:
        raise SceneError("arm.urdf", error.value, error.expected) from None
