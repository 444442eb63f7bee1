"""Possible paths of a mesh that a URDF names: in its ROS package, or beside the URDF.

Nothing here opens a file: a name is turned into paths inside the archive or the scene's folder.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from pathlib import PurePosixPath

from abi.robot.urdf.strict_xml import package_name

Folders = Mapping[str, Sequence[PurePosixPath]]
"""Folders of packages by their names."""
PACKAGE = "package://"
PACKAGE_FILE = "package.xml"
"""Name of the file that names a package."""
_SCHEME = re.compile(r"\A(package|model)://")


def reference(text: str) -> str | None:
    """Name of a mesh file, with ``/`` between folders; None if it leads outside.

    It begins with ``package://NAME/`` where it is in a package.
    """
    name = _SCHEME.sub(PACKAGE, text.replace("\\", "/"))
    path = name.removeprefix(PACKAGE)
    if path != name:  # of three slashes, which some files have, the third means nothing
        path = path.lstrip("/")
    if "://" in path or path.startswith("/") or ":" in path.partition("/")[0]:
        return None
    inside = _inside(PurePosixPath(path))
    if not path or (path != name and (inside is None or "/" not in path)):
        return None
    return PACKAGE + inside.as_posix() if inside is not None and path != name else name


def packages(files: Mapping[str, bytes]) -> dict[str, tuple[PurePosixPath, ...]]:
    """Folders of the ROS packages among files, by the name that each ``package.xml`` gives."""
    found: dict[str, tuple[PurePosixPath, ...]] = {}
    for file, content in files.items():
        path = PurePosixPath(file)
        name = package_name(content) if path.name == PACKAGE_FILE else None
        if name is not None:
            found[name] = (*found.get(name, ()), path.parent)
    return found


def package_of(name: str) -> str | None:
    """Package of a mesh's name, as :func:`reference` gives it; None if it names none."""
    path = name.removeprefix(PACKAGE)
    return None if path == name else path.partition("/")[0]


def places(folder: PurePosixPath, name: str, known: Folders) -> tuple[str, ...]:
    """Paths at which a name says that a mesh is; the first that exists is used.

    That of a package ``package://NAME/REST`` is REST in the folder whose ``package.xml`` gives this
    name; if none does, in the nearest folder above the URDF that is called NAME, or in one of that
    name beside these. Any other name is one beside the URDF.

    Args:
        folder: of the URDF.
        name: of the mesh, as :func:`reference` gives it.
        known: folders of packages by their names, as :func:`packages` gives them.
    """
    package = package_of(name)
    if package is None:
        return _inside_all([folder / name])
    path = name.removeprefix(PACKAGE)
    rest = path.partition("/")[2]
    if len(known.get(package, ())) == 1:
        return _inside_all([known[package][0] / rest])
    above = (folder, *folder.parents)
    paths = [one / rest for one in above if one.name == package]
    return _inside_all(paths + [one / path for one in above])


def guesses(folder: PurePosixPath, name: str) -> tuple[str, ...]:
    """Paths at which a mesh may be that is not where its name says, the likeliest first.

    They are in the folders above the URDF; arguments as for :func:`places`.
    """
    above = (folder, *folder.parents)
    path = name.removeprefix(PACKAGE)
    rest = path.partition("/")[2] if path != name else path
    return _inside_all([one / rest for one in above])


def other_folder(name: str, file: str) -> str | None:
    """Folder that a file was taken from instead of its package's, or the URDF's; None otherwise.

    Args:
        name: of the mesh, as :func:`reference` gives it.
        file: that was taken.
    """
    rest = name.removeprefix(PACKAGE).partition("/")[2]
    if package_of(name) is None:
        rest = "/".join(part for part in PurePosixPath(name).parts if part != "..")
    if not f"/{file}".endswith(f"/{rest}"):
        return None
    return file.removesuffix(rest) or "./"


def alike(files: Iterable[str], name: str) -> tuple[tuple[str, ...], int]:
    """Files whose paths end most like a name, and in how many parts; letters' case is no matter."""
    wanted = _parts(name)
    ends = {file: _common(_parts(file), wanted) for file in files}
    most = max(ends.values(), default=0)
    return tuple(file for file, count in ends.items() if count == most > 0), most


def length(name: str) -> int:
    """Number of parts of a mesh's name, its package included."""
    return len(_parts(name))


def _parts(name: str) -> list[str]:
    path = unicodedata.normalize("NFC", name.removeprefix(PACKAGE)).casefold()
    return [part for part in path.split("/") if part not in ("", ".", "..")]


def _common(first: list[str], second: list[str]) -> int:
    """Number of last parts that two paths share."""
    count = 0
    while count < min(len(first), len(second)) and first[-1 - count] == second[-1 - count]:
        count += 1
    return count


def _inside_all(paths: Iterable[PurePosixPath]) -> tuple[str, ...]:
    """Paths without ``..``, each once, except those that lead outside."""
    inside = [_inside(path) for path in paths]
    return tuple(dict.fromkeys(path.as_posix() for path in inside if path is not None))


def _inside(path: PurePosixPath) -> PurePosixPath | None:
    """A path without ``..``; None if it leads outside its start."""
    parts: list[str] = []
    for part in path.parts:
        if part != "..":
            parts.append(part)
        elif not parts:
            return None
        else:
            parts.pop()
    return PurePosixPath(*parts)
