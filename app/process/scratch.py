"""Temporary folders that are removed with their process, even if it is killed.

Each contains a file that its process has locked, and that the system unlocks when the process ends
in any way. The next process to start removes the folders that are no longer locked.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import sys
import tempfile
from pathlib import Path

PREFIX = "abi-run-"
_LOCK = "lock"


def scratch_folder() -> tempfile.TemporaryDirectory[str]:
    """Make a new folder in the system's temporary folder, locked until this process ends."""
    folder = tempfile.TemporaryDirectory(prefix=PREFIX, ignore_cleanup_errors=True)
    # named once it is locked: what has no lock of that name yet is left alone
    unnamed = Path(folder.name, f"new-{_LOCK}")
    _lock(os.open(unnamed, os.O_CREAT | os.O_WRONLY))
    unnamed.rename(Path(folder.name, _LOCK))
    return folder


def are_possible() -> bool:
    """Check whether the system supports such locks, as all but Windows do."""
    return sys.platform != "win32"


def remove_abandoned() -> int:
    """Remove the folders of processes that are gone; returns how many.

    Those of other users, and what only has such a name, are left alone.
    """
    if not are_possible():
        return 0
    removed = 0
    try:
        where = Path(tempfile.gettempdir())
    except FileNotFoundError:  # nothing can be written, as in a container that is read-only
        return 0
    for folder in where.glob(f"{PREFIX}*"):
        with contextlib.suppress(OSError):
            if _is_abandoned(folder):
                shutil.rmtree(folder)
                removed += 1
    return removed


def _is_abandoned(folder: Path) -> bool:
    """Check whether a folder's lock is free.

    Raises:
        OSError: there is no such lock, or it is not ours to open.
    """
    if folder.is_symlink() or folder.stat().st_uid != os.getuid():
        return False
    number = os.open(folder / _LOCK, os.O_RDWR | os.O_NOFOLLOW)
    try:
        _lock(number)
    except BlockingIOError:
        return False
    finally:
        os.close(number)
    return True


def _lock(number: int) -> None:
    """Lock an open file until it is closed.

    Raises:
        BlockingIOError: another process has.
    """
    if sys.platform != "win32":
        import fcntl

        fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
