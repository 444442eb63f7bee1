"""Bodies of links that were fitted before, in the user's cache: the next start reads them.

A file is named after what its bodies were made from: the shapes, the code that fits, and the
libraries that it asks. It begins with a hash of the rest, so that a damaged one is made again.
"""

from __future__ import annotations

import hashlib
import io
import os
import zipfile
from collections.abc import Iterable, Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np
import scipy

from abi.arrays import FloatArray, read_only
from abi.atomic_file import replace_file
from abi.robot.urdf.link import LinkShape
from abi.user_cache import user_cache

_MOST = 4_000
"""Files that are kept, the latest: of a few kilobytes each."""
_HASH = hashlib.sha256().digest_size


def key_of(shapes: Iterable[LinkShape], code: Sequence[str]) -> str:
    """Name of what is made from shapes by the code in some files."""
    digest = hashlib.sha256(_made_by(tuple(code)))
    for shape in shapes:
        digest.update(repr((shape.kind, shape.size, shape.vertices.shape)).encode())
        for array in (shape.pose, shape.vertices, shape.faces):
            digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def find(key: str) -> list[FloatArray] | None:
    """Arrays that were kept under a key, None where they are not here, or damaged."""
    try:
        content = (_folder() / key).read_bytes()
        if hashlib.sha256(content[_HASH:]).digest() != content[:_HASH]:
            return None
        with np.load(io.BytesIO(content[_HASH:]), allow_pickle=False) as data:
            return [read_only(data[name]) for name in data.files]
    except (OSError, ValueError, zipfile.BadZipFile):
        return None


def keep(key: str, arrays: Sequence[FloatArray]) -> None:
    """Keep arrays under a key; where the folder cannot be written they are made again next time."""
    packed = io.BytesIO()
    np.savez(packed, *arrays)
    content = packed.getvalue()
    try:
        folder = _folder()
        folder.mkdir(parents=True, exist_ok=True)
        replace_file(folder / key, hashlib.sha256(content).digest() + content)
        _make_room(folder)
    except (OSError, ValueError):
        return


def _folder() -> Path:
    return user_cache() / "bodies"


def _make_room(folder: Path) -> None:
    """Delete the oldest files beyond those that are kept."""
    with os.scandir(folder) as entries:  # asked at each file that is kept
        names = [one.name for one in entries if not one.name.startswith(".")]
    if len(names) > _MOST:
        files = sorted((folder / name for name in names), key=_age, reverse=True)
        for file in files[: len(files) - _MOST // 2]:
            file.unlink(missing_ok=True)


def _age(file: Path) -> float:
    """Larger for a file that was written earlier, infinite for one that is gone."""
    try:
        return -file.stat().st_mtime
    except OSError:
        return np.inf


@lru_cache(maxsize=4)
def _made_by(code: tuple[str, ...]) -> bytes:
    """Hash of the code in files, and of the libraries' versions."""
    digest = hashlib.sha256(f"{np.__version__} {scipy.__version__}".encode())
    for file in code:
        digest.update(Path(file).read_bytes())
    return digest.digest()
