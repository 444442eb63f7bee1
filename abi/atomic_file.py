"""Atomic writing of files: whole, or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import shutil
from pathlib import Path


def replace_file(path: Path, content: bytes) -> None:
    """Write ``content`` to ``path`` atomically; on failure the old file is unchanged.

    An existing file keeps its permissions and, where this user may give files away, its owner; a
    new one has those of any new file. As where a file is written to directly, one that is protected
    against writing is refused, and of a symbolic link the file it leads to is written, which need
    not exist. Of a file with several names only this one changes. If ``path`` is no regular file,
    such as ``/dev/stdout`` or a pipe, it is written to directly.

    Raises:
        OSError: it cannot be written; no temporary file is left.
        ValueError: the name cannot be a path.
    """
    if path.exists() and not path.is_file():
        path.write_bytes(content)
        return
    path = Path(os.path.realpath(path))
    if path.is_symlink():
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(path))
    if path.exists():
        path.open("r+b").close()  # replacing needs no permission to write into it
    # not by tempfile, whose files are for the owner alone whatever the umask says
    temporary = path.parent / f".{secrets.token_hex(8)}{path.suffix}"
    try:
        with temporary.open("xb") as file:
            if path.is_file():
                _give_to_owner(path, temporary)
                shutil.copymode(path, temporary)
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    finally:
        with contextlib.suppress(OSError, ValueError):
            temporary.unlink(missing_ok=True)


def _give_to_owner(old: Path, new: Path) -> None:
    """Give ``new`` the owner of ``old``, if this user may do that."""
    if hasattr(os, "chown"):
        found = old.stat()
        with contextlib.suppress(PermissionError):
            os.chown(new, found.st_uid, found.st_gid)
