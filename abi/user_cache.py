"""Cache folders of the user for what takes long to make, shared by all clones and environments."""

from __future__ import annotations

import os
import stat
import sys
import tempfile
from pathlib import Path

_NAME = "abi-visualiser"


def user_cache() -> Path:
    """Folder in the user's cache, which may not exist yet.

    It is in ``$XDG_CACHE_HOME``, or else where the system has such folders; for a user without a
    home in the temporary directory.

    Raises:
        OSError: the user has no home, and no folder there, see :func:`temporary_cache`.
    """
    if named := os.environ.get("XDG_CACHE_HOME"):
        return Path(named, _NAME)
    try:
        home = Path.home()
    except RuntimeError:
        return temporary_cache()
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local", _NAME)
    if sys.platform == "darwin":
        return home / "Library" / "Caches" / _NAME
    return home / ".cache" / _NAME


def temporary_cache() -> Path:
    """Private folder of this user in the temporary directory; it is created.

    Raises:
        OSError: it cannot be made, or others can write there.
    """
    if not hasattr(os, "getuid"):  # Windows has such a directory for each user
        folder = Path(tempfile.gettempdir(), _NAME)
        folder.mkdir(exist_ok=True)
        return folder
    folder = Path(tempfile.gettempdir(), f"{_NAME}-{os.getuid()}")
    folder.mkdir(mode=0o700, exist_ok=True)
    found = folder.lstat()
    if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid() or found.st_mode & 0o077:
        raise PermissionError(f"{folder} is not this user's alone")
    return folder
