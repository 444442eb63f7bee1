"""Files written in one step: whole, or not at all."""

from __future__ import annotations

import contextlib
import os
import secrets
import shutil
from pathlib import Path


def replace_file(path: Path, content: bytes) -> None:
    """Write ``content`` to ``path`` in one step; the old file stays whole on failure.

    An existing file keeps its permissions; a new one has those of any new file. If ``path`` is no
    regular file, such as ``/dev/stdout`` or a pipe, it is written to directly.

    Raises:
        OSError: it cannot be written; no temporary file is left.
        ValueError: the name cannot be a path.
    """
    if path.exists() and not path.is_file():
        path.write_bytes(content)
        return
    # not by tempfile, whose files are for the owner alone whatever the umask says
    temporary = path.parent / f".{secrets.token_hex(8)}{path.suffix}"
    try:
        with temporary.open("xb") as file:
            if path.is_file():
                shutil.copymode(path, temporary)
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    finally:
        with contextlib.suppress(OSError, ValueError):
            temporary.unlink(missing_ok=True)
