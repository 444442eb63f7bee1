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
from abi.arrays import FloatArray, IntArray
from abi.errors import SceneError
from abi.obstacles.triangle_mesh import stl_obj
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.obstacles.triangle_mesh.trimesh_formats import DAMAGED_ZIP
from abi.robot.robot import Robot
from abi.robot.urdf_reader import mesh_names, read_srdf, read_urdf

SHIPPED: Mapping[str, str] = {"ur5e": "tool0", "panda": "panda_hand_tcp", "xarm7": "link_eef"}
"""Usual tip of each arm that comes with the package, by its name."""

_MAX_ARCHIVE, _MAX_UNPACKED, _MAX_FILES = 30_000_000, 100_000_000, 400
_MAX_TRIANGLES = 500_000
"""Of all shapes of a robot, one that is there twice counted twice."""
_ZIP = b"PK\x03\x04"
_EPOCH = (1980, 1, 1, 0, 0, 0)


def load_robot(name: str, source: MeshSource) -> Robot:
    """A shipped arm by its name, or that of a ``.urdf`` or ``.zip`` file.

    Args:
        name: in :data:`SHIPPED`, or of a file.
        source: of the files.

    Raises:
        SceneError: there is none, or it is refused.
    """
    ending = PurePosixPath(name).suffix.lower()
    if name in SHIPPED:
        return _shipped(name)
    if ending in (".zip", ".urdf"):
        content = _content(source, name)
        # an arm that a scene has read already is kept as an archive, whatever it was
        packed = ending == ".zip" or content.startswith(_ZIP)
        return robot_from_archive(content if packed else _packed(source, name))
    expected = f"one of {', '.join(SHIPPED)}, or a file that ends in .urdf or .zip"
    raise SceneError("arm.urdf", name, expected)


@lru_cache(maxsize=8)
def robot_from_archive(content: bytes) -> Robot:
    """The robot of a zip with one URDF and its meshes, and an SRDF if there is one.

    Raises:
        SceneError: not such a file, too large packed or unpacked, or what
            :func:`abi.robot.urdf_reader.read_urdf` refuses.
    """
    files = _unpacked(content)
    found = [name for name in files if name.lower().endswith(".urdf")]
    if len(found) != 1:
        names = ", ".join(sorted(PurePosixPath(name).name for name in found)[:4]) or "none"
        raise SceneError("arm.urdf", names, "one file that ends in .urdf in the archive")
    lookup = _Lookup(files, PurePosixPath(found[0]).parent)
    robot = read_urdf(files[found[0]], PurePosixPath(found[0]).name, lookup)
    return _with_srdf(replace(robot, archive=content), files)


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


class _Lookup:
    """Meshes of an archive: where the URDF says, or the only file of that name."""

    def __init__(self, files: Mapping[str, bytes], folder: PurePosixPath) -> None:
        self._files, self._folder = files, folder
        self._read: dict[str, tuple[FloatArray, IntArray]] = {}
        self._triangles = 0

    def __call__(self, name: str) -> tuple[FloatArray, IntArray]:
        found = (self._folder / name).as_posix()
        if found not in self._files:
            last = PurePosixPath(name).name
            same = [file for file in self._files if PurePosixPath(file).name == last]
            if len(same) != 1:
                raise SceneError("arm.urdf mesh", name, "a file that came with the URDF")
            found = same[0]
        if found not in self._read:
            self._read[found] = _mesh(self._files[found], name)
        vertices, faces = self._read[found]
        self._triangles += len(faces)
        if self._triangles > _MAX_TRIANGLES:
            expected = f"meshes of at most {_MAX_TRIANGLES:,} triangles in all"
            raise SceneError("arm.urdf mesh", name, expected)
        return vertices, faces


def _mesh(content: bytes, name: str) -> tuple[FloatArray, IntArray]:
    if PurePosixPath(name).suffix.lower() not in stl_obj.SUFFIXES:
        expected = f"a shape to collide with that ends in {', '.join(stl_obj.SUFFIXES)}"
        raise SceneError("arm.urdf mesh", name, expected)
    try:
        return stl_obj.read(content, PurePosixPath(name).name)
    except SceneError as error:
        raise SceneError("arm.urdf mesh", error.value, error.expected) from None


@lru_cache(maxsize=8)
def _shipped(name: str) -> Robot:
    return robot_from_archive(_packed(MeshSource(folder=assets.path("urdf", name)), f"{name}.urdf"))


def _packed(source: MeshSource, urdf: str) -> bytes:
    """A URDF and the meshes that it names as a zip, the same for the same files."""
    text, folder = _content(source, urdf), PurePosixPath(urdf).parent
    names = [(folder / name).as_posix() for name in mesh_names(text, PurePosixPath(urdf).name)]
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr(zipfile.ZipInfo(urdf, _EPOCH), text)
        for name in names:
            archive.writestr(zipfile.ZipInfo(name, _EPOCH), _content(source, name))
        with contextlib.suppress(SceneError):  # one of the same name is welcome, and not needed
            beside = PurePosixPath(urdf).with_suffix(".srdf").as_posix()
            archive.writestr(zipfile.ZipInfo(beside, _EPOCH), source.content(beside))
    return packed.getvalue()


def _content(source: MeshSource, name: str) -> bytes:
    try:
        return source.content(name)
    except SceneError as error:
        raise SceneError("arm.urdf", error.value, error.expected) from None


def _unpacked(content: bytes) -> dict[str, bytes]:
    """Files of an archive by their paths, no more of each than it says beforehand."""
    if len(content) > _MAX_ARCHIVE:
        expected = f"an archive of at most {_MAX_ARCHIVE // 10**6} MB"
        raise SceneError("arm.urdf", f"{len(content):,} bytes", expected)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            members = [member for member in archive.infolist() if not member.is_dir()]
            size = sum(member.file_size for member in members)
            if len(members) <= _MAX_FILES and size <= _MAX_UNPACKED:
                return {member.filename: archive.read(member) for member in members}
    except DAMAGED_ZIP as error:
        expected = "a whole zip archive without a password"
        raise SceneError("arm.urdf", str(error)[:60], expected) from None
    value = f"{len(members)} files of {size:,} bytes"
    expected = f"at most {_MAX_FILES} files of {_MAX_UNPACKED // 10**6} MB in all"
    raise SceneError("arm.urdf", value, expected)
