"""Names of files that differ only in how Unicode writes their letters.

``ü`` is one character, or ``u`` with two dots to be put on it. Both look the same, and some systems
turn one into the other as they copy or pack a file.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable
from pathlib import Path


def same_name(name: str, names: Iterable[str]) -> str | None:
    """The one of ``names`` that is ``name``, or else reads the same; None for none or several."""
    found = list(names)
    if name in found:
        return name
    normal = unicodedata.normalize("NFC", name)
    same = [one for one in found if unicodedata.normalize("NFC", one) == normal]
    return same[0] if len(same) == 1 else None


def same_path(folder: Path, name: str) -> Path:
    """Path in a folder of the file that ``name`` with its slashes names, or reads the same as.

    Raises:
        OSError: a folder cannot be listed.
    """
    path = folder
    for part in name.split("/"):
        if (path / part).exists():
            path /= part
        else:
            names = (one.name for one in path.iterdir()) if path.is_dir() else ()
            path /= same_name(part, names) or part
    return path
