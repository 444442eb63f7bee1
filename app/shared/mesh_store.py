"""Store of uploaded meshes and arms, which outlasts reloads and restarts of the server.

A file's name here is the hash of its content: it is part of the link to a scene, nobody can guess
it, and a file that two tabs upload is kept once. The folder is ``$ABI_STORE``, or else one in the
user's cache; when it is full, or takes half of its disk, the least recently used files are removed.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import io
import logging
import os
import re
import shutil
import tempfile
import zipfile
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abi.arrays import read_only
from abi.obstacles.triangle_mesh.mesh_source import Files
from abi.obstacles.triangle_mesh.surface import Surface
from abi.robot.urdf.robot import Robot
from abi.user_cache import user_cache

MAX_STORED = 500_000_000
"""Most bytes of all files, and at most half of the disk."""

_KEY = re.compile(r"[0-9a-f]{64}")
_log = logging.getLogger("abi.store")


def folder() -> Path:
    """Folder of the store."""
    if named := os.environ.get("ABI_STORE"):
        return Path(named)
    return user_cache() / "uploads"


def keys(files: Files) -> dict[str, str]:
    """Keys of a scene's files by name."""
    return {name: _key(content) for name, content in files.items()}


def keep(files: Files) -> None:
    """Store a scene's files; if the folder is not writable, they last as long as the tab."""
    for content in files.values():
        path = folder() / _key(content)
        try:
            if path.exists():
                path.touch()
                continue
            path.parent.mkdir(parents=True, exist_ok=True)
            packed = _packed(content)
            _make_room(path.parent, len(packed))
            _write(path, packed)
        except OSError as error:
            _warn(error.strerror or type(error).__name__)


def find(key: str) -> bytes | Surface | None:
    """Content by key; None if it is missing or the key is invalid."""
    if not _KEY.fullmatch(key):
        return None
    try:
        return _found(folder() / key)
    except (OSError, ValueError, KeyError, zipfile.BadZipFile):
        return None


@lru_cache(maxsize=8)
def _found(path: Path) -> bytes | Surface:
    content = path.read_bytes()
    # an arm's archive has its own hash for a key; a mesh that of its numbers
    if hashlib.sha256(content).hexdigest() == path.name:
        return content
    with np.load(io.BytesIO(content), allow_pickle=False) as data:
        surface = Surface(
            read_only(data["vertices"]),
            read_only(data["faces"]),
            bool(data["closed"]),
            tuple(map(str, data["notes"])),
            next(iter(data["metres"].tolist()), None) if "metres" in data else None,
            tuple(data["layers"].tolist()) if "layers" in data else (),
            (read_only(data["before"]), read_only(data["faces_before"]))
            if "before" in data
            else None,
        )
    if surface.digest != path.name:
        raise ValueError(path.name)
    return surface


@lru_cache(maxsize=8)
def _warn(reason: str) -> None:
    """Log once why uploads are not stored."""
    _log.warning("uploads are not kept", extra={"folder": str(folder()), "reason": reason})


def _key(content: object) -> str:
    if isinstance(content, bytes):
        return _hash(content)
    assert isinstance(content, Surface | Robot)
    return content.digest


@lru_cache(maxsize=8)
def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _packed(content: object) -> bytes:
    if isinstance(content, bytes):
        return content
    if isinstance(content, Robot):
        return content.archive
    assert isinstance(content, Surface)
    packed = io.BytesIO()
    arrays: dict[str, NDArray[Any]] = {
        "vertices": content.vertices,
        "faces": content.faces,
        "closed": np.array(content.closed),
        "notes": np.array(content.notes, dtype=np.str_),
        "metres": np.array([] if content.metres is None else [content.metres]),
        "layers": np.array(content.layers, dtype=np.int64),
    }
    if content.given is not None:
        arrays["before"], arrays["faces_before"] = content.given
    np.savez(packed, allow_pickle=False, **arrays)
    return packed.getvalue()


def _write(path: Path, content: bytes) -> None:
    """Write a file atomically."""
    with tempfile.NamedTemporaryFile(dir=path.parent, prefix=".new-", delete=False) as file:
        try:
            file.write(content)
            file.close()
            Path(file.name).replace(path)
        except OSError:
            Path(file.name).unlink(missing_ok=True)
            raise


def _make_room(place: Path, size: int) -> None:
    """Remove the least recently used files until a new one fits.

    Raises:
        OSError: it fits nowhere; nothing is removed.
    """
    files = sorted(_stored(place), reverse=True)
    total, disk = sum(one for _, one, _ in files), shutil.disk_usage(place)
    most = min(MAX_STORED, disk.total // 2, disk.free + total)
    if size > most:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    while files and total + size > most:
        _, one, path = files.pop()
        path.unlink(missing_ok=True)
        total -= one


def _stored(place: Path) -> Iterator[tuple[float, int, Path]]:
    """Last use, size [bytes] and path of each stored file."""
    for path in place.iterdir():
        with contextlib.suppress(FileNotFoundError):  # another server has removed it
            status = path.stat()
            yield status.st_mtime, status.st_size, path
