"""Sources of robots: shipped arms, files beside the scene, and uploaded archives."""

from __future__ import annotations

import contextlib
import io
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import PurePosixPath

from abi import assets
from abi.archive_members import members_of
from abi.errors import SceneError
from abi.obstacles.mesh_files.zip_archive import DAMAGED_ZIP
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.urdf.link_names import names_anew
from abi.robot.urdf.mesh_lookup import MeshLookup, is_plain
from abi.robot.urdf.mesh_places import (
    PACKAGE_FILE,
    Folders,
    guesses,
    package_of,
    packages,
    places,
)
from abi.robot.urdf.robot import Robot, require_motion
from abi.robot.urdf.srdf import with_srdf
from abi.robot.urdf.strict_xml import parse
from abi.robot.urdf.urdf_joints import some_of
from abi.robot.urdf.urdf_meshes import mesh_names
from abi.robot.urdf.urdf_reader import read_urdf

SHIPPED: Mapping[str, str] = {"ur5e": "tool0", "panda": "panda_hand_tcp", "xarm7": "link_eef"}
"""Usual tip of each arm that comes with the package, by its name."""

_MAX_ARCHIVE, _MAX_UNPACKED, _MAX_FILES = 30_000_000, 100_000_000, 2_000
_ROOM = 0.9
"""Fraction of an archive's largest size up to which meshes for looks alone are included."""
_INSIDE = ".zip/"
_SRDF = ".srdf"
_TEXTS = (".urdf", _SRDF, PACKAGE_FILE)
"""Endings of the files beside the meshes that say what a robot is."""
_ZIP = b"PK\x03\x04"
_EPOCH = (1980, 1, 1, 0, 0, 0)


def load_robot(name: str, source: MeshSource, srdf: str | None = None) -> Robot:
    """Load a shipped arm by name, or the arm of a ``.urdf`` or ``.zip`` file.

    A robot that was read before is the one that the source holds.

    Args:
        name: in :data:`SHIPPED`, or of a file.
        source: of the files.
        srdf: name of the SRDF that counts, of a file or of one in the arm's archive; None for the
            one beside the URDF.

    Raises:
        SceneError: there is no such arm, or its files are refused.
    """
    if name in SHIPPED:
        if srdf is not None:
            raise SceneError("arm.srdf", srdf, "none, as the shipped arms have no SRDF")
        return _shipped(name)
    given = source.given(name)
    if srdf is not None:
        beside = _srdf_beside(source, srdf)
        alone = [PurePosixPath(srdf).name]
        if isinstance(given, Robot) and beside is None and _srdfs_in(given.archive) == alone:
            return given
        return _robot_with_srdf(archive_of(name, source), srdf, beside)
    return given if isinstance(given, Robot) else robot_from_archive(archive_of(name, source))


def load_plain_robot(name: str, source: MeshSource, srdf: str | None = None) -> Robot:
    """Load the arm of a file with an archive that can be read without trimesh.

    The file is unpacked once, and each mesh in it is read once; the archive holds the same robot,
    to the last digit. Arguments and errors are those of :func:`load_robot`; no shipped arm is
    found.
    """
    archive, files = _unpacked_files(name, source)
    if srdf is not None:
        archive, files = None, _with_one_srdf(files, srdf, _srdf_beside(source, srdf))
    robot, plain = _read(files, plain=True)
    require_motion(robot)
    if not all(map(is_plain, files)):
        archive = packed(plain)
    return replace(robot, archive=archive or _packed_anew(name, files))


def archive_of(name: str, source: MeshSource) -> bytes:
    """Content of a ``.zip`` file, or a ``.urdf`` file packed with the meshes that it names.

    ``ROBOTS.zip/URDF`` is the archive with that one of its URDF files alone. Meshes are not read.

    Raises:
        SceneError: the file has another ending, or one that it needs is missing.
    """
    if (archive := _archive_itself(name, source)) is not None:
        return archive
    return _packed_anew(name, _unpacked_files(name, source)[1])


def _packed_anew(name: str, files: Mapping[str, bytes]) -> bytes:
    """Pack files into an archive; those from beside a URDF are stored uncompressed."""
    return packed(files, zipfile.ZIP_STORED if file_of(name) == name else zipfile.ZIP_DEFLATED)


def _unpacked_files(name: str, source: MeshSource) -> tuple[bytes | None, dict[str, bytes]]:
    """The archive that a name stands for, None if it holds more than its robot; and the files."""
    archive = _archive_itself(name, source)
    if archive is not None:
        return archive, unpacked(archive)
    if source.given(name) is None and (outer := file_of(name)) != name:
        files = unpacked(_content(source, outer))
        return None, _with_one(files, name.removeprefix(f"{outer}/"))
    return None, _with_meshes(source, name)


def _archive_itself(name: str, source: MeshSource) -> bytes | None:
    """Content of a file that is an archive of one robot; None for a URDF and for several robots.

    Raises:
        SceneError: the file has another ending, or is missing.
    """
    ending = PurePosixPath(name).suffix.lower()
    if ending not in (".zip", ".urdf"):
        expected = f"one of {', '.join(SHIPPED)}, or a file that ends in .urdf or .zip"
        raise SceneError("arm.urdf", name, expected)
    if isinstance(given := source.given(name), Robot):
        return given.archive
    if given is None and file_of(name) != name:
        return None
    content = _content(source, name)
    # an arm that a scene has read already is kept as an archive, whatever it was
    return content if ending == ".zip" or content.startswith(_ZIP) else None


def file_of(name: str) -> str:
    """Name of the file that an arm is in: ``robots.zip`` for ``robots.zip/ur5.urdf``."""
    archive, slash, _ = name.partition(_INSIDE)
    return archive + _INSIDE.rstrip("/") if slash else name


def robots_in(content: bytes) -> tuple[str, ...]:
    """Paths of the URDF files in a zip, sorted; none for content that is no zip.

    Raises:
        SceneError: it is damaged, or too large.
    """
    if not content.startswith(_ZIP):
        return ()
    with _opened(content) as archive:
        return tuple(sorted(name for name in members_of(archive) if name.lower().endswith(".urdf")))


@lru_cache(maxsize=8)
def robot_from_archive(content: bytes) -> Robot:
    """Read the robot in a zip archive of one URDF, its meshes and optionally an SRDF.

    Raises:
        SceneError: it is no such file, it is too large packed or unpacked,
            :func:`abi.robot.urdf.urdf_reader.read_urdf` refuses it, or nothing of it can move.
    """
    robot = replace(_read(unpacked(content))[0], archive=content)
    require_motion(robot)
    return robot


@lru_cache(maxsize=8)
def _robot_with_srdf(archive: bytes, srdf: str, beside: bytes | None) -> Robot:
    """The robot in an archive with one SRDF alone: arguments as for :func:`_with_one_srdf`."""
    return robot_from_archive(packed(_with_one_srdf(unpacked(archive), srdf, beside)))


def _srdfs_in(content: bytes) -> list[str]:
    """Names of the SRDFs in an archive, without their folders."""
    with _opened(content) as archive:
        names = [name for name in members_of(archive) if name.lower().endswith(_SRDF)]
    return [PurePosixPath(name).name for name in names]


def packed(files: Mapping[str, bytes], compression: int = zipfile.ZIP_DEFLATED) -> bytes:
    """Pack files into a reproducible zip."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        for name, data in files.items():
            archive.writestr(zipfile.ZipInfo(name, _EPOCH), data, compression)
    return content.getvalue()


def unpacked(content: bytes) -> dict[str, bytes]:
    """Unpack an archive, no more of each file than its declared size.

    Raises:
        SceneError: it is damaged, or too large.
    """
    with _opened(content) as archive:
        members = members_of(archive)
        return {name: archive.read(member) for name, member in members.items()}


@contextlib.contextmanager
def _opened(content: bytes) -> Iterator[zipfile.ZipFile]:
    """Open an archive of limited size and number of files, to read in the block.

    Raises:
        SceneError: it is damaged, or too large.
    """
    if len(content) > _MAX_ARCHIVE:
        expected = f"an archive of at most {_MAX_ARCHIVE // 10**6} MB"
        raise SceneError("arm.urdf", f"{len(content):,} bytes", expected)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            members = members_of(archive)
            size = sum(member.file_size for member in members.values())
            if len(members) > _MAX_FILES or size > _MAX_UNPACKED:
                value = f"{len(members)} files of {size:,} bytes"
                expected = f"at most {_MAX_FILES:,} files of {_MAX_UNPACKED // 10**6} MB in all"
                raise SceneError("arm.urdf", value, expected)
            yield archive
    except DAMAGED_ZIP as error:
        expected = "a whole zip archive without a password, in which each file is once"
        raise SceneError("arm.urdf", str(error)[:60], expected) from None


def _read(files: Mapping[str, bytes], plain: bool = False) -> tuple[Robot, dict[str, bytes]]:
    """A robot still without archive, and its files, each mesh in a format that needs no trimesh.

    With ``plain`` the robot is the one that those files hold.
    """
    found = sorted(name for name in files if name.lower().endswith(".urdf"))
    if len(found) != 1:
        names = some_of(found) or "none"
        expected = "one file that ends in .urdf in the archive"
        if found:
            expected += f", or one of them named after it, such as robots.zip/{found[0]}"
        raise SceneError("arm.urdf", names, expected)
    lookup = MeshLookup(files, PurePosixPath(found[0]).parent, plain)
    robot = read_urdf(files[found[0]], PurePosixPath(found[0]).name, lookup)
    robot = replace(robot, notes=(*robot.notes, *lookup.notes))
    texts = {name: files[name] for name in files if name.lower().endswith(_TEXTS)}
    return _with_srdf(robot, files, found[0]), texts | lookup.plain()


def _with_one(files: Mapping[str, bytes], name: str) -> dict[str, bytes]:
    """Files with only the URDF whose path ends in a name."""
    urdfs = [file for file in files if file.lower().endswith(".urdf")]
    found = [file for file in urdfs if f"/{file}".endswith(f"/{name}")]
    if name in urdfs:
        found = [name]
    if len(found) != 1:
        raise SceneError("arm.urdf", name, f"one of {some_of(sorted(urdfs), 6) or 'no URDF files'}")
    return {file: files[file] for file in files if file not in urdfs or file in found}


def _srdf_beside(source: MeshSource, name: str) -> bytes | None:
    """An SRDF of the source; None if it has none of that name."""
    if not name.lower().endswith(_SRDF):
        raise SceneError("arm.srdf", name, f"a file that ends in {_SRDF}")
    try:
        return source.content(name)
    except SceneError:
        return None


def _with_one_srdf(files: Mapping[str, bytes], name: str, beside: bytes | None) -> dict[str, bytes]:
    """Files with only one SRDF: the one beside the scene, or else the one of its name among them.

    Raises:
        SceneError: there is neither.
    """
    srdfs = sorted(file for file in files if file.lower().endswith(_SRDF))
    inside = [file for file in srdfs if f"/{file}".endswith(f"/{PurePosixPath(name).name}")]
    others = {file: content for file, content in files.items() if file not in srdfs}
    if beside is None and len(inside) != 1:
        came = some_of(srdfs, 6) or "none"
        expected = f"a file inside the scene's folder, or one SRDF that came with the arm: {came}"
        raise SceneError("arm.srdf", name, expected)
    content = files[inside[0]] if beside is None else beside
    return {**others, PurePosixPath(name).name: content}


def _with_srdf(robot: Robot, files: Mapping[str, bytes], urdf: str) -> Robot:
    """The robot with the content of its SRDF: the only one among its files, or the one of its name.

    Without an SRDF more is checked than need be, so a choice among others is not made.
    """
    found = [name for name in files if name.lower().endswith(".srdf")]
    if len(found) > 1:
        stem = PurePosixPath(urdf).stem
        own = [name for name in found if PurePosixPath(name).stem == stem]
        if len(own) != 1:
            note = f"No SRDF is used, as none of several is called {stem}.srdf."
            return replace(robot, notes=(*robot.notes, note))
        found = own
    if not found:
        return robot
    renamed = names_anew(parse(files[urdf], PurePosixPath(urdf).name))
    return with_srdf(robot, files[found[0]], PurePosixPath(found[0]).name, renamed)


@lru_cache(maxsize=8)
def _shipped(name: str) -> Robot:
    return robot_from_archive(
        archive_of(f"{name}.urdf", MeshSource(folder=assets.path("urdf", name)))
    )


def _with_meshes(source: MeshSource, urdf: str) -> dict[str, bytes]:
    """A URDF and the meshes that it names, by their paths.

    Meshes that are for looks alone come along where they are there and there is room.
    """
    text, folder = _content(source, urdf), PurePosixPath(urdf).parent
    needed, looks = mesh_names(text, PurePosixPath(urdf).name)
    files = {urdf: text, **source.named(PACKAGE_FILE, folder)}
    known = packages(files)
    for name in needed:
        path, mesh = _mesh_of(source, folder, name, known)
        files[path] = mesh
    for name in looks[: _MAX_FILES // 2]:
        with contextlib.suppress(SceneError):
            path, mesh = _mesh_of(source, folder, name, known)
            if sum(map(len, files.values())) + len(mesh) < _ROOM * _MAX_ARCHIVE:
                files[path] = mesh
    with contextlib.suppress(SceneError):  # one of the same name is welcome, and not needed
        beside = PurePosixPath(urdf).with_suffix(".srdf").as_posix()
        files[beside] = source.content(beside)
    return files


def _mesh_of(
    source: MeshSource,
    folder: PurePosixPath,
    name: str,
    known: Folders,
) -> tuple[str, bytes]:
    """Path and content of a mesh that a URDF names, from the first place that has one."""
    fault = SceneError("arm.urdf mesh", name, "a file inside the scene's folder")
    paths = places(folder, name, known)
    if package_of(name) not in known:
        paths += guesses(folder, name)
    for number, path in enumerate(paths):
        try:
            return path, source.content(path)
        except SceneError as error:
            if number == 0:
                fault = SceneError("arm.urdf", error.value, error.expected)
    raise fault


def _content(source: MeshSource, name: str) -> bytes:
    try:
        return source.content(name)
    except SceneError as error:
        raise SceneError("arm.urdf", error.value, error.expected) from None
