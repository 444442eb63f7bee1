"""Untrusted zip archives, measured before they are unpacked."""

from __future__ import annotations

import io
import lzma
import struct
import zipfile
import zlib

DAMAGED_ZIP: tuple[type[Exception], ...] = (
    *(zipfile.BadZipFile, zlib.error, lzma.LZMAError, struct.error),
    *(RuntimeError, NotImplementedError, EOFError, OSError, ValueError),
)
"""Exceptions raised when a zip archive is damaged or needs a password."""
_MOST_UNPACKED = 200_000_000
_MOST_ENTRIES = 1000


def unpacked(data: bytes) -> dict[str, bytes]:
    """Unpack an archive's files by lower-case names, since case does not count there.

    Raises:
        ValueError: it is damaged, or too large.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            entries = archive.infolist()
            small = sum(entry.file_size for entry in entries) <= _MOST_UNPACKED
            names = {entry.filename.lower() for entry in entries}
            twice = len(names) < len(entries)
            if small and len(entries) <= _MOST_ENTRIES and not twice:
                return {entry.filename.lower(): archive.read(entry) for entry in entries}
    except DAMAGED_ZIP:
        raise ValueError("a whole 3MF file, which is a zip archive") from None
    if twice:
        raise ValueError("a 3MF file in which each part is once, whatever the case of its name")
    raise ValueError(f"an archive of at most {_MOST_UNPACKED // 1_000_000} MB unpacked")
