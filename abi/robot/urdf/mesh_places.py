"""Possible paths of a mesh that a URDF names: in its ROS package, or beside the URDF.

Nothing here opens a file: a name is turned into paths inside the archive or the scene's folder.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable
from pathlib import PurePosixPath

PACKAGE = "package://"
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


def places(folder: PurePosixPath, name: str) -> tuple[str, ...]:
    """Paths at which a mesh is looked for; the first that exists is used.

    That of a package ``package://NAME/REST`` is REST in the nearest folder above the URDF that is
    called NAME, or in one of that name beside these, or else REST in any of them.

    Args:
        folder: of the URDF.
        name: of the mesh, as :func:`reference` gives it.
    """
    above = (folder, *folder.parents)
    if name.startswith(PACKAGE):
        path = name.removeprefix(PACKAGE)
        package, _, rest = path.partition("/")
        paths = [one / rest for one in above if one.name == package]
        paths += [one / path for one in above] + [one / rest for one in above]
    else:
        paths = [one / name for one in above]
    inside = [_inside(path) for path in paths]
    return tuple(dict.fromkeys(path.as_posix() for path in inside if path is not None))


def alike(files: Iterable[str], name: str) -> tuple[tuple[str, ...], int]:
    """Files whose paths end most like a name, and in how many parts; letters' case is no matter."""
    wanted = _parts(name)
    ends = {file: _common(_parts(file), wanted) for file in files}
    most = max(ends.values(), default=0)
    return tuple(file for file, count in ends.items() if count == most > 0), most


def length(name: str) -> int:
    """Number of parts of a mesh's name in its package, or in the folder of the URDF."""
    return len(_parts(name)) - name.startswith(PACKAGE)


def _parts(name: str) -> list[str]:
    path = unicodedata.normalize("NFC", name.removeprefix(PACKAGE)).casefold()
    return [part for part in path.split("/") if part not in ("", ".", "..")]


def _common(first: list[str], second: list[str]) -> int:
    """Number of last parts that two paths share."""
    count = 0
    while count < min(len(first), len(second)) and first[-1 - count] == second[-1 - count]:
        count += 1
    return count


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
