"""Files of a zip archive by their intended names, whichever file manager wrote them."""

from __future__ import annotations

import zipfile
from pathlib import PurePosixPath

_SMALL = 1_000_000
"""Largest files of one name that are compared, [bytes]."""
_JUNK = ("__MACOSX", ".DS_Store", "Thumbs.db", "desktop.ini")


def members_of(archive: zipfile.ZipFile) -> dict[str, zipfile.ZipInfo]:
    """Files of an archive by their names, with ``/`` between folders and none that lead outside.

    Folders, and what file managers add for themselves, are left out. Of two files with one name it
    is not known which is meant, unless they are small and the same.

    Raises:
        BadZipFile: there are two.
    """
    found: dict[str, zipfile.ZipInfo] = {}
    for entry in archive.infolist():
        name = entry.filename.replace("\\", "/")
        parts = [part for part in name.split("/") if part not in ("", ".")]
        # is_dir() asks for the last letter of a name that may have none
        if parts and not name.endswith("/") and ".." not in parts and not _is_junk(parts):
            path = "/".join(parts)
            if not _are_same(archive, found.setdefault(path, entry), entry):
                raise zipfile.BadZipFile(f"two files {path}")
    return found


def without_folder(name: str, folder: PurePosixPath) -> str | None:
    """Name of a file relative to a folder; None if it is elsewhere."""
    path = PurePosixPath(name)
    return path.relative_to(folder).as_posix() if path.is_relative_to(folder) else None


def _are_same(archive: zipfile.ZipFile, one: zipfile.ZipInfo, other: zipfile.ZipInfo) -> bool:
    """Check whether two entries are one, or small ones of one content: checksums can be forged."""
    if one is other or one.file_size != other.file_size or one.file_size > _SMALL:
        return one is other
    return archive.read(one) == archive.read(other)


def _is_junk(parts: list[str]) -> bool:
    return parts[-1].startswith("._") or any(part in _JUNK for part in parts)
