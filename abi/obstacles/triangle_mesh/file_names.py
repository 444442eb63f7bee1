"""File names that differ only in their Unicode normalisation.

``ü`` is one character, or ``u`` with two dots to be put on it. Both look the same, and some systems
turn one into the other as they copy or pack a file.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable
from pathlib import Path


def same_name(name: str, names: Iterable[str]) -> str | None:
    """The entry of ``names`` equal to ``name``, or the only one that reads the same; or None."""
    found = list(names)
    if name in found:
        return name
    normal = unicodedata.normalize("NFC", name)
    same = [one for one in found if unicodedata.normalize("NFC", one) == normal]
    return same[0] if len(same) == 1 else None


def same_path(folder: Path, name: str) -> Path:
    """Path in a folder of the file that ``name`` names, up to Unicode normalisation.

    Raises:
        OSError: a folder cannot be listed.
    """
    path = folder / name
    if path.exists():
        return path
    path = folder
    for part in name.split("/"):
        if (path / part).exists():
            path /= part
        else:
            names = (one.name for one in path.iterdir()) if path.is_dir() else ()
            path /= same_name(part, names) or part
    return path
